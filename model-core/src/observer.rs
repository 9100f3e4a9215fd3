//! Pressure of each chamber from the one sensor on the manifold.
//!
//! While a segment's valve is open, its chamber's pressure moves with the ISO 6358 flow that the pressure difference
//! drives; when the air rests, it *is* the manifold's. While the valve is closed, the last estimate stands. All
//! volumes are counted in manifold volumes, so that a pressure rate of the manifold alone (kPa per millisecond) is
//! the only unit of flow.

use crate::actuation::{Actuation, Passage, PerSegment};
use crate::division::divide;
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

/// What the observer and the regulator assume of the pneumatics. Nominal figures; the regulator learns their errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pneumatics {
    /// Pump: pressure rate of the manifold alone at 0 kPa, in kPa per ms.
    pub pump_rate: I16F16,
    /// Pump: gauge pressure at which it delivers nothing more; the flow falls linearly until there.
    pub pump_stall: Pressure,
    /// Segment valves and dump valve: choked pressure rate of the manifold alone, in kPa per ms and kPa of absolute
    /// upstream pressure.
    pub valve_rate: I16F16,
    /// Critical pressure ratio b of the valves (ISO 6358).
    pub critical_ratio: I16F16,
    /// Volume of one chamber in manifold volumes, with what its growth under pressure takes beside: the air that one
    /// chamber takes for 1 kPa, over what the manifold takes. The observer learns it.
    pub chamber_ratio: I16F16,
    /// Dead time of relay and valves.
    pub dead_ticks: DeadTicks,
}

impl Pneumatics {
    /// A 3 NL/min diaphragm pump with a stall pressure of 250 kPa, valves with a sonic conductance of
    /// 0.025 NL/(s bar) and b = 0.3, a manifold of 5 mL, chambers of 6.8 mL (the paper's Table 1) that take
    /// 40 % more air as they bend, and 10 ms dead time: what the design assumes, to be checked against the bench.
    pub const NOMINAL: Self = Self {
        // 50 mL/s at 101.325 kPa into 5 mL: 1.013 kPa/ms.
        pump_rate: I16F16::lit("1.013"),
        pump_stall: Pressure::from_kpa(250),
        // 0.025 NL/(s bar) / 5 mL * 101.325 kPa / 100 kPa, per millisecond.
        valve_rate: I16F16::lit("0.005066"),
        critical_ratio: I16F16::lit("0.3"),
        chamber_ratio: I16F16::lit("1.9"),
        dead_ticks: DeadTicks(10),
    };

    /// Pressure rate, in kPa per ms, at which the pump raises the manifold alone against `manifold`; never negative.
    #[must_use]
    pub fn pump_flow(&self, manifold: Pressure) -> I16F16 {
        let room = (self.pump_stall - manifold).to_fixed().max(I16F16::ZERO);
        let share = divide(room, self.pump_stall.to_fixed()).unwrap_or(I16F16::ZERO);
        self.pump_rate.saturating_mul(share.min(I16F16::ONE))
    }

    /// Flow from `from` to `to` through one valve, as pressure rate of the manifold alone in kPa per ms; odd in its
    /// arguments (ISO 6358-1, equations for choked and subsonic flow).
    #[must_use]
    pub fn valve_flow(&self, from: Pressure, to: Pressure) -> I16F16 {
        let (up, down) = (from.max(to), from.min(to));
        // Below 1 kPa absolute the sensor has long failed; the clamp keeps the ratio defined.
        let absolute = |p: Pressure| p.to_fixed().saturating_add(ATMOSPHERE).max(I16F16::ONE);
        let ratio = divide(absolute(down), absolute(up)).unwrap_or(I16F16::ONE);
        let subsonic = (ratio - self.critical_ratio).max(I16F16::ZERO);
        let subsonic =
            divide(subsonic, I16F16::ONE.saturating_sub(self.critical_ratio)).unwrap_or(I16F16::ONE).min(I16F16::ONE);
        let psi = square_root(I16F16::ONE - subsonic.saturating_mul(subsonic));
        let flow = self.valve_rate.saturating_mul(absolute(up)).saturating_mul(psi);
        if from >= to { flow } else { -flow }
    }
}

/// Standard atmosphere in kPa.
const ATMOSPHERE: I16F16 = I16F16::lit("101.325");

/// Square root of 0..=1, rounded down; below zero it is zero.
fn square_root(value: I16F16) -> I16F16 {
    // Q16 shifted by 16 more bits is Q32, whose integer root is Q16 again. One is the only value that would not fit.
    let q16 = value.to_bits().clamp(0, 0xFFFF) as u32;
    I16F16::from_bits((q16 << 16).isqrt() as i32)
}

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Observer {
    pneumatics: Pneumatics,
    chambers: PerSegment<Pressure>,
    flows: PerSegment<I16F16>,
    fast: Pressure,
    slow: Pressure,
    started: bool,
    /// One bit a tick, the newest lowest: pump on, dump open, segment valves open.
    pump_on: u32,
    dump_open: u32,
    valve_open: PerSegment<u32>,
}

impl Observer {
    /// All chambers at atmosphere, everything open: a finger that rests.
    #[must_use]
    pub const fn new(pneumatics: Pneumatics) -> Self {
        Self {
            pneumatics,
            chambers: [Pressure::ZERO; 3],
            flows: [I16F16::ZERO; 3],
            fast: Pressure::ZERO,
            slow: Pressure::ZERO,
            started: false,
            pump_on: 0,
            dump_open: u32::MAX,
            valve_open: [u32::MAX; 3],
        }
    }

    /// Takes this tick's sensor reading, before the regulator decides.
    pub fn measure(&mut self, manifold: Pressure) {
        if self.started {
            self.fast = low_pass(self.fast, manifold, 2);
            self.slow = low_pass(self.slow, manifold, 4);
        } else {
            (self.fast, self.slow, self.started) = (manifold, manifold, true);
        }
        let resting = self.air_rests();
        let per_chamber = self.chambers.iter_mut().zip(&mut self.flows).zip(&self.valve_open);
        for ((chamber, flow), &open) in per_chamber {
            if open >> self.pneumatics.dead_ticks.get() & 1 == 0 {
                *flow = I16F16::ZERO;
                continue;
            }
            let difference = (self.fast - *chamber).to_fixed();
            // Half of the difference at the most: equalised volumes must not chatter on the sensor's noise.
            let limit = difference.saturating_abs() / 2;
            let manifolds_flow = self.pneumatics.valve_flow(self.fast, *chamber);
            let flow_in = divide(manifolds_flow, self.pneumatics.chamber_ratio).unwrap_or(I16F16::ZERO);
            // Not `clamp`, which would panic if the limit were negative: it is not, but the compiler does not see that.
            *flow = flow_in.max(-limit).min(limit);
            *chamber = *chamber + Pressure::from_fixed(*flow);
            if resting && open & REST_MASK == REST_MASK {
                *chamber = low_pass(*chamber, self.slow, 3);
            }
        }
    }

    /// Remembers what was commanded this tick.
    pub fn commanded(&mut self, actuation: &Actuation) {
        let push = |bits: &mut u32, on: bool| *bits = *bits << 1 | u32::from(on);
        push(&mut self.pump_on, actuation.pump);
        push(&mut self.dump_open, actuation.dump == Passage::Open);
        for (bits, passage) in self.valve_open.iter_mut().zip(actuation.segments) {
            push(bits, passage == Passage::Open);
        }
    }

    /// Neither pump nor dump has moved air for a while.
    #[must_use]
    pub const fn air_rests(&self) -> bool {
        self.pump_on & REST_MASK == 0 && self.dump_open & REST_MASK == 0
    }

    /// Estimated gauge pressure of each chamber.
    #[must_use]
    pub const fn chambers(&self) -> PerSegment<Pressure> {
        self.chambers
    }

    /// Rate of each chamber's pressure now, kPa per ms.
    #[must_use]
    pub const fn flows(&self) -> PerSegment<I16F16> {
        self.flows
    }

    /// The manifold's gauge pressure, filtered over about 4 ms.
    #[must_use]
    pub const fn manifold(&self) -> Pressure {
        self.fast
    }

    /// The manifold's gauge pressure, filtered over about 16 ms.
    #[must_use]
    pub const fn manifold_at_rest(&self) -> Pressure {
        self.slow
    }

    /// Ticks of pump flow that were commanded and have not arrived yet.
    #[must_use]
    pub const fn pump_ticks_pending(&self) -> u32 {
        pending(self.pump_on, self.pneumatics.dead_ticks)
    }

    /// Ticks of dump flow that were commanded and have not arrived yet.
    #[must_use]
    pub const fn dump_ticks_pending(&self) -> u32 {
        pending(self.dump_open, self.pneumatics.dead_ticks)
    }

    /// The pneumatics assumed.
    #[must_use]
    pub const fn pneumatics(&self) -> &Pneumatics {
        &self.pneumatics
    }

    /// The pressure at which manifold and `group` would come to rest if nothing more flowed in or out.
    #[must_use]
    pub fn level(&self, group: PerSegment<bool>) -> Pressure {
        let ratio = self.pneumatics.chamber_ratio;
        let mut excess = I16F16::ZERO;
        for (&chamber, member) in self.chambers.iter().zip(group) {
            if member {
                excess = excess.saturating_add(ratio.saturating_mul((chamber - self.fast).to_fixed()));
            }
        }
        let share = divide(excess, self.volume(group)).unwrap_or(I16F16::ZERO);
        self.fast + Pressure::from_fixed(share)
    }

    /// Volume of the manifold and `group`, in manifold volumes; at least one.
    #[must_use]
    pub fn volume(&self, group: PerSegment<bool>) -> I16F16 {
        group
            .iter()
            .filter(|&&member| member)
            .fold(I16F16::ONE, |sum, _| sum.saturating_add(self.pneumatics.chamber_ratio))
    }

    /// Takes the resting manifold's pressure as that of every chamber in `group`, and learns the chambers' volume from
    /// a flow that began at `from` and should have ended at `to`; less than 10 kPa teaches nothing.
    pub fn equalised(&mut self, group: PerSegment<bool>, from: Pressure, to: Pressure) {
        for (chamber, member) in self.chambers.iter_mut().zip(group) {
            if member {
                *chamber = self.slow;
            }
        }
        let moved = (self.slow - from).to_fixed();
        if moved.saturating_abs() < const { I16F16::lit("10") } || from == to {
            return;
        }
        // Coming out lower than expected means that the chambers take more air than was thought.
        let excess = divide((to - self.slow).to_fixed(), moved).unwrap_or(I16F16::ZERO);
        let correction =
            I16F16::ONE.saturating_add(excess.clamp(const { I16F16::lit("-0.3") }, const { I16F16::lit("0.3") }) / 2);
        let ratio = &mut self.pneumatics.chamber_ratio;
        *ratio = ratio.saturating_mul(correction).clamp(const { I16F16::lit("0.5") }, const { I16F16::lit("6") });
    }
}

/// The last 24 ticks: dead time, spin-down and the sensor's lag.
const REST_MASK: u32 = 0x00FF_FFFF;

/// How many of the newest `dead_ticks` bits are set.
const fn pending(bits: u32, dead_ticks: DeadTicks) -> u32 {
    (bits & ((1 << dead_ticks.get()) - 1)).count_ones()
}

/// First-order low pass with a time constant of 2^`shift` ticks.
fn low_pass(state: Pressure, input: Pressure, shift: u32) -> Pressure {
    let step = (i64::from(input.to_bits()) - i64::from(state.to_bits())) >> shift;
    state + Pressure::from_bits(step as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: Pneumatics = Pneumatics::NOMINAL;

    /// ISO 6358 in f64, written from the standard's own form.
    fn flow_f64(from: f64, to: f64) -> f64 {
        let (up, down) = (from.max(to) + 101.325, from.min(to) + 101.325);
        let b = 0.3;
        let psi = if down / up <= b { 1.0 } else { (1.0 - ((down / up - b) / (1.0 - b)).powi(2)).sqrt() };
        (from - to).signum() * 0.005_066 * up * psi
    }

    /// Everything closed for longer than the dead time, at atmosphere.
    fn held_at_zero() -> Observer {
        let mut observer = Observer::new(MODEL);
        for _ in 0..40 {
            observer.measure(Pressure::ZERO);
            observer.commanded(&Actuation::HOLD);
        }
        observer
    }

    #[test]
    fn dead_times_end_before_the_history_does() {
        assert_eq!(DeadTicks::new(31), Some(DeadTicks::MAX));
        assert_eq!(DeadTicks::new(32), None);
        // The longest counts every tick but the oldest of 32.
        let mut observer = Observer::new(Pneumatics { dead_ticks: DeadTicks::MAX, ..MODEL });
        for _ in 0..40 {
            observer.commanded(&Actuation { pump: true, ..Actuation::HOLD });
        }
        assert_eq!((observer.pump_ticks_pending(), observer.dump_ticks_pending()), (31, 0));
    }

    #[test]
    fn valve_flow_follows_iso_6358_both_ways() {
        for (from, to) in [(150.0, 0.0), (150.0, 149.0), (400.0, 0.0), (0.0, 60.0), (1.0, 0.0), (75.0, 74.5)] {
            let ours = MODEL.valve_flow(Pressure::from_f64_kpa(from), Pressure::from_f64_kpa(to)).to_num::<f64>();
            let exact = flow_f64(from, to);
            assert!((ours - exact).abs() < 0.01 * exact.abs() + 0.002, "{from} -> {to}: {ours} for {exact}");
        }
        assert_eq!(MODEL.valve_flow(Pressure::from_kpa(40), Pressure::from_kpa(40)), I16F16::ZERO);
    }

    #[test]
    fn pump_flow_falls_to_nothing_at_the_stall() {
        assert!((MODEL.pump_flow(Pressure::from_kpa(125)).to_num::<f64>() - 0.5065).abs() < 1e-3);
        assert_eq!(MODEL.pump_flow(Pressure::from_kpa(300)), I16F16::ZERO);
        assert_eq!(MODEL.pump_flow(Pressure::from_kpa(-50)), MODEL.pump_rate);
    }

    #[test]
    fn a_chamber_behind_a_closed_valve_keeps_its_estimate() {
        let mut observer = held_at_zero();
        for _ in 0..200 {
            observer.measure(Pressure::from_kpa(120));
            observer.commanded(&Actuation::HOLD);
        }
        assert_eq!(observer.chambers(), [Pressure::ZERO; 3]);
    }

    #[test]
    fn an_open_chamber_comes_to_the_manifolds_pressure() {
        let mut observer = held_at_zero();
        let open = Actuation { segments: [Passage::Open, Passage::Closed, Passage::Closed], ..Actuation::HOLD };
        for _ in 0..600 {
            observer.commanded(&open);
            observer.measure(Pressure::from_kpa(120));
        }
        let [proximal, middle, _] = observer.chambers();
        assert!((proximal - Pressure::from_kpa(120)).abs() < Pressure::from_milli_kpa(50));
        assert_eq!(middle, Pressure::ZERO);
    }

    #[test]
    fn the_level_conserves_the_gas() {
        let mut observer = Observer::new(MODEL);
        observer.measure(Pressure::from_kpa(100));
        // The first tick's flow into the chamber is not yet worth half a kPa of the level.
        let equal_shares = 100.0 / (1.0 + MODEL.chamber_ratio.to_num::<f64>());
        assert!((observer.level([true, false, false]).to_f64() - equal_shares).abs() < 0.5);
        assert_eq!(observer.level([false; 3]), observer.manifold());
    }

    #[test]
    fn a_flow_that_falls_short_teaches_a_larger_chamber() {
        let mut observer = held_at_zero();
        for _ in 0..200 {
            observer.measure(Pressure::from_kpa(80));
            observer.commanded(&Actuation::HOLD);
        }
        let group = [true, false, false];
        let before = observer.pneumatics().chamber_ratio;
        observer.equalised(group, Pressure::from_kpa(75), Pressure::from_kpa(100));
        assert_eq!(observer.pneumatics().chamber_ratio, before, "5 kPa teach nothing");
        observer.equalised(group, Pressure::ZERO, Pressure::from_kpa(100));
        assert!(observer.pneumatics().chamber_ratio > before);
        assert_eq!(observer.chambers()[0], observer.manifold_at_rest());
    }
}
