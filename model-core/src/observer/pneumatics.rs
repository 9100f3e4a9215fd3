//! What is assumed of pump, valves and chambers.

use crate::actuation::PerSegment;
use crate::units::Pressure;
use fixed::types::I16F16;

/// Dead time of relay and valves in ticks (ms), 0..=31: commands are remembered for 32 ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeadTicks(u8);

impl DeadTicks {
    /// The longest, 31 ticks.
    pub const MAX: Self = Self(31);

    /// None when `ticks` is more than 31.
    #[must_use]
    pub const fn new(ticks: u8) -> Option<Self> {
        if ticks <= Self::MAX.0 { Some(Self(ticks)) } else { None }
    }

    /// Ticks, 0..=31.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }
}

/// What the observer and the regulator assume of the pneumatics: nominal, or what the self test has measured
/// ([`SelfTest::measured`](crate::self_test::SelfTest::measured)). The readings correct the pressures, not these. Inverses are
/// kept instead of what they are of, so that no tick divides by them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pneumatics {
    /// Pump: pressure rate of the manifold alone at 0 kPa, in kPa per ms.
    pub pump_rate: I16F16,
    /// Pump: share of that rate that each kPa of gauge pressure takes away, per kPa: 1 over the stall pressure.
    pub pump_fade: I16F16,
    /// Pump: share of the way to its speed that it makes in a tick: 1 - exp(-1 ms / time constant).
    pub pump_spin: I16F16,
    /// Pump: ticks of full flow that it still gives after a stop: (1 - `pump_spin`) / `pump_spin`.
    pub pump_run_down: I16F16,
    /// Each segment valve: choked pressure rate of the manifold alone, in kPa per ms and kPa of absolute upstream pressure.
    pub valve_rates: PerSegment<I16F16>,
    /// The same of the dump valve.
    pub dump_rate: I16F16,
    /// Critical pressure ratio b of the valves (ISO 6358).
    pub critical_ratio: I16F16,
    /// 1/(1 - b).
    pub subsonic_scale: I16F16,
    /// Volume of each chamber, straight, in manifold volumes.
    pub chamber_ratios: PerSegment<I16F16>,
    /// Share of the way to its rest that a bending chamber makes in three ticks: 1 - exp(-3 ms / time constant).
    pub bending: I16F16,
    /// Pressure sensor: share of the way that it makes in a tick.
    pub sensor_share: I16F16,
    /// Dead time of relay and valves.
    pub dead_ticks: DeadTicks,
}

impl Pneumatics {
    /// A 3 NL/min diaphragm pump with a stall pressure of 250 kPa that spins up in 15 ms, valves with a sonic conductance
    /// of 0.025 NL/(s bar) and b = 0.3, a manifold of 5 mL, chambers of 6.8 mL (the paper's Table 1) that bend with a lag
    /// of 80 ms, a sensor with one of 2.5 ms, and 10 ms dead time: what the design assumes, to be checked against the bench.
    pub const NOMINAL: Self = Self {
        // 50 NmL/s, at 100 kPa, into 5 mL.
        pump_rate: I16F16::lit("1.0"),
        pump_fade: I16F16::lit("0.004"),
        pump_spin: I16F16::lit("0.0645"),
        pump_run_down: I16F16::lit("14.5"),
        // 0.025 NL/(s bar) / 5 mL, per millisecond.
        valve_rates: [I16F16::lit("0.005"); 3],
        dump_rate: I16F16::lit("0.005"),
        critical_ratio: I16F16::lit("0.3"),
        subsonic_scale: I16F16::lit("1.428571"),
        chamber_ratios: [I16F16::lit("1.3572"); 3],
        bending: I16F16::lit("0.0368"),
        sensor_share: I16F16::lit("0.3297"),
        dead_ticks: DeadTicks(10),
    };

    /// Pressure rate, in kPa per ms, at which the pump at full speed raises the manifold alone against `manifold`; never
    /// negative.
    #[must_use]
    pub fn pump_flow(&self, manifold: Pressure) -> I16F16 {
        let share = I16F16::ONE.saturating_sub(self.pump_fade.saturating_mul(manifold.to_fixed()));
        self.pump_rate.saturating_mul(share.max(I16F16::ZERO).min(I16F16::ONE))
    }

    /// Flow from `from` to `to` through a valve of this choked rate ([`Self::valve_rates`], [`Self::dump_rate`]), as pressure
    /// rate of the manifold alone in kPa per ms; odd in `from` and `to` (ISO 6358-1, choked and subsonic flow).
    #[must_use]
    pub fn valve_flow(&self, rate: I16F16, from: Pressure, to: Pressure) -> I16F16 {
        let flow = rate.saturating_mul(self.effective_pressure(from, to));
        if from >= to { flow } else { -flow }
    }

    /// The absolute upstream pressure, in kPa, that would drive the same flow choked; never negative.
    ///
    /// Where the pressures differ by less than a 128th the flow is linear in the difference, and meets the law there: the
    /// root's endless slope at no difference would let a step of a millisecond swing.
    #[must_use]
    pub(crate) fn effective_pressure(&self, from: Pressure, to: Pressure) -> I16F16 {
        let (up, down) = (from.max(to), from.min(to));
        // Below 1 kPa absolute the sensor has long failed; above 500 kPa everything has.
        let absolute =
            |p: Pressure| p.to_fixed().saturating_add(ATMOSPHERE).max(I16F16::ONE).min(const { I16F16::lit("500") });
        let (up, down) = (absolute(up), absolute(down));
        let difference = up.saturating_sub(down);
        if difference < up >> LAMINAR_SHIFT {
            difference.saturating_mul(LAMINAR_SLOPE)
        } else {
            let excess = down.saturating_sub(self.critical_ratio.saturating_mul(up)).max(I16F16::ZERO);
            let scaled = excess.saturating_mul(self.subsonic_scale).min(up);
            // p1 sqrt(1 - ((r - b)/(1 - b))^2), multiplied out: (p1 - s)(p1 + s), at most 2^18 kPa^2.
            let narrow = u64::from(up.saturating_sub(scaled).to_bits().unsigned_abs());
            let wide = u64::from(up.saturating_add(scaled).to_bits().unsigned_abs());
            // Q32 to Q14, whose root is Q7.
            let square = ((narrow * wide) >> 18).min(u64::from(u32::MAX)) as u32;
            I16F16::from_bits((square.isqrt() << 9) as i32)
        }
    }

    /// How much a chamber has grown once it rests at this pressure, as a share of its straight volume.
    ///
    /// The calibrated model's bend over the root of the pressure, 30 % at 113 degrees; linear between whole roots.
    #[must_use]
    pub fn growth(&self, chamber: Pressure) -> I16F16 {
        // The root of Q16 is Q8.
        let bits = chamber.max(Pressure::ZERO).min(GROWN).to_bits().unsigned_abs();
        let root = bits.isqrt();
        let (whole, rest) = ((root >> 8) as usize, root & 0xFF);
        let low = GROWTH.get(whole).copied().unwrap_or(I16F16::ZERO);
        let high = GROWTH.get(whole + 1).copied().unwrap_or(low);
        let rest = I16F16::from_bits((rest << 8) as i32);
        low.saturating_add(high.saturating_sub(low).saturating_mul(rest))
    }
}

/// Standard atmosphere in kPa.
pub(crate) const ATMOSPHERE: I16F16 = I16F16::lit("101.325");
/// The flow is linear below a difference of 2^-7 of the upstream pressure.
const LAMINAR_SHIFT: u32 = 7;
/// What meets the law there with b = 0.3: sqrt(1 - ((1 - 1/128 - 0.3)/0.7)^2) * 128.
const LAMINAR_SLOPE: I16F16 = I16F16::lit("19.07");
/// The growth's table ends here.
const GROWN: Pressure = Pressure::from_milli_kpa(195_900);
/// Growth at 0, 1, 4, 9, ... 196 kPa.
const GROWTH: [I16F16; 15] = [
    I16F16::lit("0.0000"),
    I16F16::lit("0.0205"),
    I16F16::lit("0.0413"),
    I16F16::lit("0.0629"),
    I16F16::lit("0.0855"),
    I16F16::lit("0.1098"),
    I16F16::lit("0.1361"),
    I16F16::lit("0.1649"),
    I16F16::lit("0.1955"),
    I16F16::lit("0.2259"),
    I16F16::lit("0.2532"),
    I16F16::lit("0.2759"),
    I16F16::lit("0.2942"),
    I16F16::lit("0.3090"),
    I16F16::lit("0.3212"),
];

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: Pneumatics = Pneumatics::NOMINAL;

    /// ISO 6358 in f64, written from the standard's own form.
    fn flow_f64(from: f64, to: f64) -> f64 {
        let (up, down) = (from.max(to) + 101.325, from.min(to) + 101.325);
        let b = 0.3;
        let psi = if down / up <= b { 1.0 } else { (1.0 - ((down / up - b) / (1.0 - b)).powi(2)).sqrt() };
        (from - to).signum() * 0.005 * up * psi
    }

    #[test]
    fn valve_flow_follows_iso_6358_both_ways() {
        for (from, to) in [(150.0, 0.0), (150.0, 147.0), (400.0, 0.0), (0.0, 60.0), (1.0, 0.0), (75.0, 73.0)] {
            let ours = MODEL
                .valve_flow(MODEL.dump_rate, Pressure::from_f64_kpa(from), Pressure::from_f64_kpa(to))
                .to_num::<f64>();
            let exact = flow_f64(from, to);
            assert!((ours - exact).abs() < 0.01 * exact.abs() + 0.002, "{from} -> {to}: {ours} for {exact}");
        }
        assert_eq!(MODEL.valve_flow(MODEL.dump_rate, Pressure::from_kpa(40), Pressure::from_kpa(40)), I16F16::ZERO);
    }

    #[test]
    fn pump_flow_falls_to_nothing_at_the_stall() {
        assert!((MODEL.pump_flow(Pressure::from_kpa(125)).to_num::<f64>() - 0.5).abs() < 1e-3);
        assert_eq!(MODEL.pump_flow(Pressure::from_kpa(300)), I16F16::ZERO);
        assert_eq!(MODEL.pump_flow(Pressure::from_kpa(-50)), MODEL.pump_rate);
    }

    #[test]
    fn growth_follows_the_calibrated_bend() {
        use crate::calibration;
        use crate::inverse::bend_from_pressure;
        assert_eq!(MODEL.growth(Pressure::from_kpa(-5)), I16F16::ZERO);
        for kpa in 0..=160 {
            let pressure = Pressure::from_kpa(kpa);
            let exact = 0.3 * bend_from_pressure(&calibration::DEFAULT, pressure).to_f64() / 113.0;
            let ours = MODEL.growth(pressure).to_num::<f64>();
            assert!((ours - exact).abs() < 0.002, "{kpa} kPa: {ours} for {exact}");
        }
        assert_eq!(MODEL.growth(Pressure::MAX), MODEL.growth(Pressure::from_kpa(196)));
    }

    #[test]
    fn inverses_are_those_of_their_figures() {
        let near = |ours: I16F16, exact: f64| {
            assert!((ours.to_num::<f64>() / exact - 1.0).abs() < 0.003, "{ours} for {exact}");
        };
        near(MODEL.subsonic_scale, 1.0 / (1.0 - 0.3));
        near(MODEL.pump_spin, 1.0 - (-1.0_f64 / 15.0).exp());
        near(MODEL.pump_run_down, 1.0 / (1.0 - (-1.0_f64 / 15.0).exp()) - 1.0);
        near(MODEL.bending, 1.0 - (-3.0_f64 / 80.0).exp());
        near(MODEL.sensor_share, 1.0 - (-1.0_f64 / 2.5).exp());
    }
}
