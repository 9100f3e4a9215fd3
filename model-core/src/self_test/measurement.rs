//! What the self test's own flows tell of pump, valves and chambers.
//!
//! - **Pump.** What the manifold alone has gained over a charge, by the ticks for which the pump was commanded: what is missing
//!   while it spins up comes while it runs down, and a dead time delays both ends alike.
//!   What still came after the stop tells dead time and run-down, as their sum.
//! - **Chambers.** Air is conserved when the charged manifold opens to a straight chamber at atmosphere; how much the
//!   chamber has grown by then is told by the bend.
//! - **Valves.** While the charged manifold empties, its loss against the time integral of what ISO 6358 lets through for the
//!   pressures on both sides: the slope of a straight line by least squares, which no dead time moves.
//!
//! What cannot be told stays nominal, and nothing leaves the bounds in which a machine passes the self test.
//! `cargo test -p finger-tests --test measurement -- --nocapture` prints the errors over a thousand drawn machines.

use crate::actuation::PerSegment;
use crate::controller::Reading;
use crate::division::divide;
use crate::observer::{ATMOSPHERE, Pneumatics};
use crate::units::{Bend, Pressure};
use fixed::types::I16F16;

/// Ticks of a valve's opening that are kept: twice the nominal dead time and the better part of the flow.
const TRACE: usize = 96;
/// Kept samples that are worked through in a tick.
const PER_TICK: usize = 4;
/// The line is fitted where the manifold has lost from this share of its pressure, in 256ths, ...
const FROM_256THS: i64 = 20;
/// ... to this, for a chamber ...
const TO_CHAMBER_256THS: i64 = 90;
/// ... and for the atmosphere, towards which the flow goes on as it began.
const TO_ATMOSPHERE_256THS: i64 = 160;
/// Fewer samples tell nothing.
const SAMPLES: i64 = 6;
/// Growth of a chamber's volume with its bend, a share per degree: 30 % at 113 degrees, as [`Pneumatics::growth`] has it.
const GROWTH_PER_DEG: I16F16 = I16F16::lit("0.0026549");
/// The sensor's time constant, ticks.
const SENSOR_LAG: I16F16 = I16F16::lit("2.5");
/// Dead time and run-down over the ticks of a charge, where 0, 1, 2, ... 15 sixteenths of it came after its stop: v in
/// share = 0.4 v + 0.6 v (1 - exp(-(1 - 0.4 v) / (0.6 v))).
const COMING: [I16F16; 16] = [
    I16F16::lit("0.0000"),
    I16F16::lit("0.0625"),
    I16F16::lit("0.1250"),
    I16F16::lit("0.1875"),
    I16F16::lit("0.2504"),
    I16F16::lit("0.3143"),
    I16F16::lit("0.3806"),
    I16F16::lit("0.4505"),
    I16F16::lit("0.5258"),
    I16F16::lit("0.6085"),
    I16F16::lit("0.7010"),
    I16F16::lit("0.8071"),
    I16F16::lit("0.9324"),
    I16F16::lit("1.0861"),
    I16F16::lit("1.2868"),
    I16F16::lit("1.5832"),
];
/// Nothing is taken to be less than a third or more than three times the nominal.
const BOUND: I16F16 = I16F16::lit("3");

/// What a trace is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Passing {
    Nothing,
    /// Index of the segment.
    Chamber(usize),
    Dump,
}

/// See the module's page.
#[derive(Clone, Debug)]
pub(super) struct Measurement {
    measured: Pneumatics,
    /// The reading, filtered over 8 ms.
    level: Pressure,
    /// What it is at atmosphere.
    zero: Pressure,
    /// Where the charge began, and for how many ticks the pump was commanded.
    from: Pressure,
    pumped: u16,
    /// The reading at the stop, and ticks of full flow that came after it, summed over all charges.
    stopped: Pressure,
    came: I16F16,
    /// Gains of all charges, in kPa, and the ticks of full flow that they took.
    gained: I16F16,
    ticks: I16F16,
    charges: u8,
    /// A valve's opening: readings above atmosphere, kPa in 2^-8.
    trace: [i16; TRACE],
    kept: usize,
    passing: Passing,
    /// What was there before, above atmosphere.
    before: Pressure,
    line: Line,
    /// The finger's bend, filtered over 8 ms, and what it was when the opening began.
    bend: Bend,
    straight: Bend,
}

/// Sums of a fit by least squares: x in kPa ms, y in kPa 2^-8.
#[derive(Clone, Copy, Debug)]
struct Line {
    cursor: usize,
    x: I16F16,
    n: i64,
    sum_x: i64,
    sum_y: i64,
    sum_xx: i64,
    sum_xy: i64,
}

impl Line {
    const NONE: Self = Self { cursor: 0, x: I16F16::ZERO, n: 0, sum_x: 0, sum_y: 0, sum_xx: 0, sum_xy: 0 };

    const fn add(&mut self, y: i64) {
        let x = (self.x.to_bits() >> 16) as i64;
        self.n += 1;
        self.sum_x += x;
        self.sum_y += y;
        self.sum_xx += x * x;
        self.sum_xy += x * y;
    }

    /// kPa per ms and kPa.
    fn slope(&self) -> Option<I16F16> {
        if self.n < SAMPLES {
            return None;
        }
        let over = self.n * self.sum_xy - self.sum_x * self.sum_y;
        let under = self.n * self.sum_xx - self.sum_x * self.sum_x;
        let bits = (over << 8).checked_div(under)?;
        Some(I16F16::from_bits(i32::try_from(bits).ok()?))
    }
}

impl Measurement {
    pub(super) const fn new() -> Self {
        Self {
            measured: Pneumatics::NOMINAL,
            level: Pressure::ZERO,
            zero: Pressure::ZERO,
            from: Pressure::ZERO,
            pumped: 0,
            stopped: Pressure::ZERO,
            came: I16F16::ZERO,
            gained: I16F16::ZERO,
            ticks: I16F16::ZERO,
            charges: 0,
            trace: [0; TRACE],
            kept: 0,
            passing: Passing::Nothing,
            before: Pressure::ZERO,
            line: Line::NONE,
            bend: Bend::ZERO,
            straight: Bend::ZERO,
        }
    }

    /// Each tick's readings, before anything else.
    pub(super) fn read(&mut self, reading: Pressure, bend: Reading<Bend>) {
        self.level = self.level.low_passed(reading, 3);
        if let Reading::Valid(bend) = bend {
            self.bend = self.bend.low_passed(bend, 3);
        }
    }

    /// The finger has rested at atmosphere.
    pub(super) const fn rests(&mut self) {
        self.zero = self.level;
    }

    /// The pump is commanded from now on.
    pub(super) const fn charging(&mut self) {
        (self.from, self.pumped) = (self.level, 0);
    }

    /// A tick of the pump.
    pub(super) const fn pumps(&mut self) {
        self.pumped = self.pumped.saturating_add(1);
    }

    /// The pump is commanded to stop.
    pub(super) const fn stops(&mut self, reading: Pressure) {
        self.stopped = reading;
    }

    /// The pump has long stopped, and nothing was open: the next opening begins.
    pub(super) fn charged(&mut self) {
        self.charges = self.charges.saturating_add(1);
        let gain = self.level - self.from;
        let mean = self.from.midpoint(self.level) - self.zero;
        let share = I16F16::ONE.saturating_sub(self.measured.pump_fade.saturating_mul(mean.to_fixed()));
        self.gained = self.gained.saturating_add(gain.to_fixed());
        self.ticks = self.ticks.saturating_add(I16F16::from_num(self.pumped.min(1000)).saturating_mul(share));
        if let Some(rate) = divide(self.gained, self.ticks) {
            self.measured.pump_rate = within(rate, Pneumatics::NOMINAL.pump_rate);
        }
        self.came = self.came.saturating_add(self.coming((self.level - self.stopped).to_fixed(), gain.to_fixed()));
        if let Some(ticks) = divide(self.came, I16F16::from_num(self.charges)) {
            let run_down = ticks.saturating_sub(I16F16::from_num(self.measured.dead_ticks.get()));
            self.measured.pump_run_down = run_down.max(I16F16::ONE).min(const { I16F16::lit("60") });
        }
        self.before = self.level - self.zero;
        (self.kept, self.passing) = (0, Passing::Nothing);
        self.straight = self.bend;
    }

    /// Ticks of full flow after a stop, from a charge of so many kPa of which so many came after it.
    ///
    /// With dead time and run-down in their nominal proportion, the share that came after is a function of their sum over the
    /// ticks for which the pump was commanded; the charge is too short for the full speed.
    fn coming(&self, after: I16F16, gain: I16F16) -> I16F16 {
        let pumped = I16F16::from_num(self.pumped.clamp(1, 1000));
        let lag = divide(SENSOR_LAG, pumped).unwrap_or(I16F16::ZERO);
        let share = divide(after, gain).unwrap_or(I16F16::ZERO).saturating_sub(lag).max(I16F16::ZERO);
        let sixteenths = share.saturating_mul(I16F16::from_num(16));
        let index = usize::try_from(sixteenths.to_bits() >> 16).unwrap_or(0).min(COMING.len() - 2);
        let low = COMING.get(index).copied().unwrap_or(I16F16::ZERO);
        let high = COMING.get(index + 1).copied().unwrap_or(low);
        let part = sixteenths.saturating_sub(I16F16::from_num(index as u8)).min(I16F16::ONE);
        pumped.saturating_mul(low.saturating_add(high.saturating_sub(low).saturating_mul(part)))
    }

    /// A tick of an opening: kept for later.
    pub(super) fn opens(&mut self, reading: Pressure) {
        if let Some(sample) = self.trace.get_mut(self.kept) {
            let bits = (reading - self.zero).to_bits() >> 8;
            *sample = bits.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16;
            self.kept += 1;
        }
    }

    /// The charged manifold, alone before, has emptied into this chamber, straight and at atmosphere before.
    pub(super) fn filled(&mut self, segment: usize) {
        let after = self.level - self.zero;
        let growth = GROWTH_PER_DEG.saturating_mul((self.bend - self.straight).to_fixed().max(I16F16::ZERO));
        // The chamber's air in chamber volumes: its pressure, and what grew, filled from nothing.
        let taken = after.to_fixed().saturating_add(growth.saturating_mul(after.to_fixed().saturating_add(ATMOSPHERE)));
        let ratio = divide((self.before - after).to_fixed(), taken);
        if let (Some(own), Some(ratio)) = (self.measured.chamber_ratios.get_mut(segment), ratio) {
            *own = within(ratio, NOMINAL_RATIO);
        }
        (self.passing, self.line) = (Passing::Chamber(segment), Line::NONE);
    }

    /// The charged manifold has emptied through the dump valve.
    pub(super) const fn dumped(&mut self) {
        (self.passing, self.line) = (Passing::Dump, Line::NONE);
    }

    /// Works through a part of what was kept; to be called in each tick in which nothing is kept.
    pub(super) fn work(&mut self) {
        let (inverse, to) = match self.passing {
            Passing::Nothing => return,
            Passing::Chamber(segment) => {
                let ratio = self.measured.chamber_ratios.get(segment).copied().unwrap_or(NOMINAL_RATIO);
                (divide(I16F16::ONE, ratio).unwrap_or(I16F16::ZERO), TO_CHAMBER_256THS)
            }
            Passing::Dump => (I16F16::ZERO, TO_ATMOSPHERE_256THS),
        };
        let before = i64::from(self.before.to_bits()) >> 8;
        for _ in 0..PER_TICK {
            let sample = self.trace.get(self.line.cursor).filter(|_| self.line.cursor < self.kept);
            let Some(&sample) = sample else {
                self.end();
                return;
            };
            self.line.cursor += 1;
            let lost = before - i64::from(sample);
            let manifold = Pressure::from_bits(i32::from(sample) << 8);
            let chamber = Pressure::from_fixed((self.before - manifold).to_fixed().saturating_mul(inverse));
            if lost << 8 >= before * FROM_256THS && lost << 8 <= before * to {
                self.line.add(lost);
            }
            if lost << 8 >= before * (FROM_256THS / 2) {
                let effective = self.measured.effective_pressure(manifold, chamber.max(Pressure::ZERO));
                self.line.x = self.line.x.saturating_add(effective);
            }
        }
    }

    fn end(&mut self) {
        if let Some(rate) = self.line.slope() {
            let rate = within(rate, Pneumatics::NOMINAL.dump_rate);
            match self.passing {
                Passing::Chamber(segment) => {
                    if let Some(own) = self.measured.valve_rates.get_mut(segment) {
                        *own = rate;
                    }
                }
                Passing::Dump => self.measured.dump_rate = rate,
                Passing::Nothing => {}
            }
        }
        self.passing = Passing::Nothing;
    }

    /// What has been measured. One valve's slope is off by 5 % for the sensor's noise alone, about as much as valves of one make
    /// differ: half of each is the mean of all.
    pub(super) fn measured(&self) -> Pneumatics {
        let sum = self.measured.valve_rates.into_iter().fold(I16F16::ZERO, I16F16::saturating_add);
        let mean = sum.saturating_mul(const { I16F16::lit("0.33333") });
        let valve_rates = self.measured.valve_rates.map(|own| own.saturating_add(mean.saturating_sub(own) / 2));
        Pneumatics { valve_rates, ..self.measured }
    }
}

const NOMINAL_RATIO: I16F16 = {
    let [ratio, _, _]: PerSegment<I16F16> = Pneumatics::NOMINAL.chamber_ratios;
    ratio
};

/// Within the bounds of what a machine may have.
fn within(value: I16F16, nominal: I16F16) -> I16F16 {
    let lowest = divide(nominal, BOUND).unwrap_or(nominal);
    value.max(lowest).min(nominal.saturating_mul(BOUND))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A charge in so many ticks to a pressure, from nothing; the readings at rest before and after.
    fn charge(measurement: &mut Measurement, ticks: u16, kpa: f64) {
        let rest = |measurement: &mut Measurement, kpa: f64| {
            (0..100).for_each(|_| measurement.read(Pressure::from_f64_kpa(kpa), Reading::Valid(Bend::ZERO)));
        };
        rest(measurement, 0.0);
        measurement.rests();
        measurement.charging();
        (0..ticks).for_each(|_| measurement.pumps());
        rest(measurement, kpa);
        measurement.charged();
    }

    /// The manifold empties by a law of its own in f64: ISO 6358 with b = 0.3, Euler in steps of a hundredth of a tick.
    fn open(measurement: &mut Measurement, from: f64, rate: f64, ratio: Option<f64>, dead: usize) {
        let flow = |up: f64, down: f64| {
            let (up, down) = (up + 101.325, down + 101.325);
            let r = down / up;
            rate * up * if r < 0.3 { 1.0 } else { (1.0 - ((r - 0.3) / 0.7).powi(2)).max(0.0).sqrt() }
        };
        let (mut manifold, mut chamber) = (from, 0.0);
        for tick in 0..240 {
            measurement.read(Pressure::from_f64_kpa(manifold), Reading::Valid(Bend::ZERO));
            measurement.opens(Pressure::from_f64_kpa(manifold));
            for _ in 0..if tick < dead { 0 } else { 100 } {
                let step = if manifold > chamber { flow(manifold, chamber) / 100.0 } else { 0.0 };
                manifold -= step;
                chamber += ratio.map_or(0.0, |ratio| step / ratio);
            }
        }
    }

    fn work(measurement: &mut Measurement) {
        (0..=TRACE / PER_TICK).for_each(|_| measurement.work());
    }

    fn assert_near(found: I16F16, exact: f64, per_cent: f64) {
        let error = 100.0 * (found.to_num::<f64>() / exact - 1.0);
        assert!(error.abs() < per_cent, "{found} for {exact}: {error:+.1} %");
    }

    #[test]
    fn a_pump_is_told_by_its_gain() {
        let mut measurement = Measurement::new();
        // 0.6 kPa/ms for 40 ms against a mean of 11.45 kPa, which takes away 0.4 % for each kPa.
        charge(&mut measurement, 40, 22.9);
        assert_near(measurement.measured().pump_rate, 0.6, 0.5);
    }

    #[test]
    fn valves_and_stiff_chambers_are_told_by_an_opening_whatever_the_dead_time() {
        for (rate, ratio, dead) in [(0.005, 1.36, 10), (0.0035, 2.7, 20), (0.007, 0.9, 5)] {
            let mut measurement = Measurement::new();
            charge(&mut measurement, 40, 25.0);
            open(&mut measurement, 25.0, rate, Some(ratio), dead);
            measurement.filled(1);
            work(&mut measurement);
            assert_near(measurement.measured.chamber_ratios[1], ratio, 2.0);
            assert_near(measurement.measured.valve_rates[1], rate, 4.0);
            assert_eq!(measurement.measured.valve_rates[0], Pneumatics::NOMINAL.valve_rates[0]);

            charge(&mut measurement, 40, 25.0);
            open(&mut measurement, 25.0, rate, None, dead);
            measurement.dumped();
            work(&mut measurement);
            assert_near(measurement.measured.dump_rate, rate, 4.0);
        }
    }

    #[test]
    fn nothing_that_moves_nothing_is_taken_for_a_measurement() {
        let mut measurement = Measurement::new();
        charge(&mut measurement, 40, 25.0);
        open(&mut measurement, 25.0, 0.0, None, 0);
        measurement.dumped();
        work(&mut measurement);
        assert_eq!(measurement.measured.dump_rate, Pneumatics::NOMINAL.dump_rate);
        // No gain at all is kept within the bounds.
        charge(&mut measurement, 1000, 0.0);
        assert!(measurement.measured.pump_rate > I16F16::ZERO);
    }
}
