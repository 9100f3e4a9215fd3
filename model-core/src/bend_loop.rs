//! Bends asked for in degrees: the model says which pressure makes them, the bend sensor trims what the model gets wrong.
//!
//! ```text
//! bends asked for ──▶ × (1 + trim) ──▶ P(α) ──▶ setpoints ──▶ regulator, chambers ──▶ finger
//!                          ▲                                        │ estimates           │ bend (BF350)
//!                          │                                        ▼                     │
//!                          └── limit ◀── integral ◀── (+) ◀── Σ α(P), lagged like a finger │
//!                                                      ▲ −                                │
//!                                                      └──────────────────────────────────┘
//! ```
//!
//! The sensor tells the sum of three bends, so what it shows is shared out: the trim of each segment is a share of its own
//! bend, and of all trims that explain the sum the smallest is taken (a normalised gradient step: a segment that bends more
//! takes more). With one segment away from zero all of it is that segment's.
//!
//! The model's bend is taken at the *estimated* pressures, not at the setpoints: a setpoint that cannot be reached and the way
//! there are no model error, so nothing winds up. Only where the regulator has come to rest within its own band the setpoint
//! counts, so that the trim also makes up for the band. The integral stands still while the
//! model's bend moves faster than a finger with the lag of `LAG_UPDATES` follows, while air flows, and without a sensor.
//! A trim is published at most once a second and only when it is worth half a degree: each costs the regulator a service.
//!
//! Trims end at ±15 %, start at none when the finger is vented, and go back to none when the sensor fails: then pressure
//! alone, by the model, holds the finger. The pressure limit comes after the trim.

use crate::actuation::PerSegment;
use crate::inverse::bend_from_pressure;
use crate::units::{Bend, Coefficients, Pressure};
use fixed::types::I16F16;

/// Ticks from one update of the trims to the next.
const UPDATE_TICKS: u8 = 16;
/// The finger's lag in updates: 80 ms.
const LAG_UPDATES: i32 = 5;
/// Updates for which the model's bend must have stood still: five times the lag.
const STILL_UPDATES: u8 = 25;
/// The model's bend stands still while it differs by less than this from what a finger with lag has: 0.5 degree, a rate of
/// 6 degrees a second.
const STILL: i32 = 1 << 15;
/// An update takes this power of one half of what is missing: half a second in all.
const GAIN_SHIFT: u32 = 5;
/// The largest trim, 15 % in 2⁻²⁴: three times the gap to experiment that the paper reports for its model.
const MOST_TRIM: i32 = (0.15 * (1 << 24) as f64) as i32;
/// A sum of bends below this is not trimmed: the sensor's own errors are worth more.
const LEAST_SUM: Bend = Bend::from_deg(10);
/// The most that one update looks at, 64 degrees.
const MOST_MISSING: i32 = 64 << 16;
/// Updates between two changes of the trims in use: one second.
const PUBLISH_UPDATES: u8 = 63;
/// The least change, half a degree of the sum.
const PUBLISH: i32 = 1 << 15;
/// A chamber this near to its setpoint is left alone by the regulator.
const REGULATED: Pressure = Pressure::from_milli_kpa(600);
/// Updates without a reading after which the sensor counts as failed.
const MISSING_UPDATES: u8 = 3;

/// What a tick shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observation {
    /// What is asked for in degrees; none when nothing is, or in pressures.
    pub bends: Option<PerSegment<Bend>>,
    /// Each chamber's setpoint.
    pub setpoints: PerSegment<Pressure>,
    /// Each chamber's estimated pressure.
    pub estimates: PerSegment<Pressure>,
    /// The finger's bend; none while its sensor fails.
    pub bend: Option<Bend>,
    /// Neither pump nor dump valve has moved air for a while.
    pub air_rests: bool,
}

/// See the module's text.
#[derive(Clone, Debug)]
pub struct BendLoop {
    slot: u8,
    /// The model's bend of each segment, and what a finger with lag has of the sum, 2⁻¹⁶ degree.
    modelled: PerSegment<Bend>,
    lagged: i32,
    /// The sensor's, filtered over 16 ticks, 2⁻²⁰ degree.
    measured: i64,
    /// Trims as they are known and as they are used, as a share of the bend, 2⁻²⁴.
    known: PerSegment<i32>,
    used: PerSegment<i32>,
    still_updates: u8,
    since_published: u8,
    missing_updates: u8,
}

impl BendLoop {
    /// No trim.
    pub(crate) const fn new() -> Self {
        Self {
            slot: 0,
            modelled: [Bend::ZERO; 3],
            lagged: 0,
            measured: 0,
            known: [0; 3],
            used: [0; 3],
            still_updates: 0,
            since_published: PUBLISH_UPDATES,
            missing_updates: 0,
        }
    }

    /// What the model is asked for, so that the finger has these bends.
    pub(crate) fn trimmed(&self, bends: PerSegment<Bend>) -> PerSegment<Bend> {
        let mut trimmed = bends;
        for (bend, &trim) in trimmed.iter_mut().zip(&self.used) {
            *bend = *bend + Bend::from_bits(((i64::from(bend.to_bits()) * i64::from(trim)) >> 24) as i32);
        }
        trimmed
    }

    /// The trims in use, as a share of each segment's bend; within ±0.15.
    #[must_use]
    pub fn trims(&self) -> PerSegment<I16F16> {
        self.used.map(|trim| I16F16::from_bits(trim >> 8))
    }

    /// The sensor fails, and bends are made by pressure alone.
    #[must_use]
    pub const fn falls_back(&self) -> bool {
        self.missing_updates >= MISSING_UPDATES
    }

    /// Looks at a tick. At most some 230 instructions. True in the ticks in which it has little to do itself.
    pub(crate) fn step(&mut self, seen: &Observation, coefficients: &PerSegment<Coefficients>) -> bool {
        if let Some(bend) = seen.bend {
            self.measured += i64::from(bend.to_bits()) - (self.measured >> 4);
        }
        self.slot = if self.slot + 1 < UPDATE_TICKS { self.slot + 1 } else { 0 };
        let ours = usize::from(self.slot);
        let pressures = (seen.estimates.get(ours), seen.setpoints.get(ours));
        if let (Some(own), Some(modelled), (Some(&estimate), Some(&setpoint))) =
            (coefficients.get(ours), self.modelled.get_mut(ours), pressures)
        {
            let pressure = if (estimate - setpoint).abs() <= REGULATED { setpoint } else { estimate };
            let straight = seen.bends.is_some_and(|bends| bends.get(ours) == Some(&Bend::ZERO));
            // The tenth of a kPa that an empty chamber is estimated at would be worth two degrees: rest has no slope.
            *modelled = if straight { Bend::ZERO } else { bend_from_pressure(own, pressure) };
            return false;
        }
        if ours == 3 {
            self.update(seen);
            return false;
        }
        true
    }

    fn update(&mut self, seen: &Observation) {
        self.since_published = self.since_published.saturating_add(1).min(PUBLISH_UPDATES);
        let modelled: i32 = self.modelled.iter().fold(0, |sum, bend| sum + bend.to_bits());
        let behind = modelled - self.lagged;
        self.lagged += behind / LAG_UPDATES;
        let still = behind.saturating_abs() < STILL && seen.air_rests;
        self.still_updates = if still { self.still_updates.saturating_add(1) } else { 0 };

        self.missing_updates = if seen.bend.is_some() { 0 } else { self.missing_updates.saturating_add(1) };
        let Some(bends) = seen.bends else {
            // The next command starts without a trim.
            (self.known, self.used) = ([0; 3], [0; 3]);
            return;
        };
        if self.falls_back() {
            for (known, used) in self.known.iter_mut().zip(&mut self.used) {
                // Over a quarter of a second; what is left at the end is below 1e-6.
                *used -= *used / 16;
                *known = *used;
            }
            return;
        }
        if self.missing_updates > 0 || self.still_updates < STILL_UPDATES {
            return;
        }
        self.learn(&bends);
    }

    fn learn(&mut self, bends: &PerSegment<Bend>) {
        // Bends asked for lie within 0..=110 degrees: their squares add up to no more than 36,300.
        let degrees = bends.map(|bend| (bend.to_bits() >> 16).clamp(0, 180));
        let (sum, squares) = degrees.iter().fold((0, 0), |(sum, squares), &d| (sum + d, squares + d * d));
        if sum < LEAST_SUM.to_bits() >> 16 {
            return;
        }
        let explained = |trims: &PerSegment<i32>| -> i32 {
            trims.iter().zip(&degrees).map(|(&trim, &d)| ((i64::from(trim) * i64::from(d)) >> 8) as i32).sum()
        };
        let measured = (self.measured >> 4).clamp(i64::from(-MOST_MISSING), 1 << 26) as i32;
        let (known, used) = (explained(&self.known), explained(&self.used));
        let missing = (self.lagged - measured - known).clamp(-MOST_MISSING, MOST_MISSING);
        // In 2⁻²⁴ per degree.
        let step = (missing << 8).checked_div(squares).unwrap_or(0);
        for (trim, &d) in self.known.iter_mut().zip(&degrees) {
            *trim = (*trim + ((step * d) >> GAIN_SHIFT)).clamp(-MOST_TRIM, MOST_TRIM);
        }
        if self.since_published >= PUBLISH_UPDATES && (known - used).saturating_abs() > PUBLISH {
            (self.used, self.since_published) = (self.known, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration;
    use crate::inverse::pressure_from_bend;

    const OWN: [Coefficients; 3] = [calibration::DEFAULT; 3];

    /// A loop, and a finger that bends each segment by a factor of what the model says; pressures are as asked for.
    struct Bench {
        looped: BendLoop,
        factors: [f64; 3],
        asked: Option<PerSegment<Bend>>,
        /// The true sum, lagged by 80 ms.
        sum_deg: f64,
        sensor: bool,
        air_rests: bool,
        /// What the chambers really are held at, whatever is asked for.
        pressures: Option<PerSegment<Pressure>>,
    }

    impl Bench {
        fn new(factors: [f64; 3], asked_deg: [i16; 3]) -> Self {
            Self {
                looped: BendLoop::new(),
                factors,
                asked: Some(asked_deg.map(Bend::from_deg)),
                sum_deg: 0.0,
                sensor: true,
                air_rests: true,
                pressures: None,
            }
        }

        fn run(&mut self, ticks: u32) -> [f64; 3] {
            for _ in 0..ticks {
                let wanted = self.looped.trimmed(self.asked.unwrap_or_default());
                let limit = Pressure::from_kpa(150);
                let set = wanted.map(|bend| pressure_from_bend(&OWN[0], bend).min(limit));
                let estimates = self.pressures.unwrap_or(set);
                let bends = estimates.map(|pressure| bend_from_pressure(&OWN[0], pressure).to_f64());
                let sum: f64 = bends.iter().zip(self.factors).map(|(bend, factor)| bend * factor).sum();
                self.sum_deg += (sum - self.sum_deg) / 80.0;
                let bend = self.sensor.then(|| Bend::from_f64_deg(self.sum_deg));
                let seen =
                    Observation { bends: self.asked, setpoints: set, estimates, bend, air_rests: self.air_rests };
                self.looped.step(&seen, &OWN);
            }
            self.looped.trims().map(|trim| trim.to_num())
        }
    }

    fn none(trims: [f64; 3]) -> bool {
        trims.iter().all(|trim| trim.abs() <= 0.0)
    }

    #[test]
    fn the_sum_arrives_and_one_segment_alone_takes_all() {
        for asked in [[60, 0, 0], [40, 80, 20], [90, 90, 90]] {
            let mut bench = Bench::new([0.93; 3], asked);
            bench.run(15_000);
            let sum: i16 = asked.iter().sum();
            assert!((bench.sum_deg - f64::from(sum)).abs() < 0.55, "{asked:?}: {}", bench.sum_deg);
        }
        let trims = Bench::new([0.93; 3], [60, 0, 0]).run(15_000);
        assert!((trims[0] - 0.075).abs() < 0.01 && trims[1].abs() + trims[2].abs() <= 0.0, "{trims:?}");
    }

    #[test]
    fn trims_end_at_their_bound_and_come_back_at_once() {
        let mut bench = Bench::new([0.5; 3], [60; 3]);
        let trims = bench.run(30_000);
        assert!(trims.iter().all(|trim| (0.149..0.1501).contains(trim)), "{trims:?}");
        // After half a minute at the bound nothing has to be unwound: a healthy finger is right again in eight seconds.
        bench.factors = [1.0; 3];
        bench.run(8000);
        assert!((bench.sum_deg - 180.0).abs() < 0.6, "{}", bench.sum_deg);
    }

    #[test]
    fn pressures_that_do_not_arrive_are_no_error_of_the_model() {
        let mut bench = Bench::new([1.0; 3], [60; 3]);
        bench.pressures = Some([Pressure::from_kpa(20); 3]);
        assert!(none(bench.run(20_000)));
    }

    #[test]
    fn nothing_is_learned_while_air_flows_or_the_target_runs() {
        let mut bench = Bench::new([0.9; 3], [60; 3]);
        bench.air_rests = false;
        assert!(none(bench.run(5000)));
        bench.air_rests = true;
        // 20 degrees a second, up and down.
        for step in 0..4000_i32 {
            let way = (step % 400 - 200).abs() * 20;
            bench.asked = Some([Bend::from_milli_deg(40_000 + 50 * way / 20); 3]);
            bench.run(5);
        }
        assert!(bench.looped.trims().iter().all(|trim| trim.abs() < 0.02), "{:?}", bench.looped.trims());
    }

    #[test]
    fn a_failed_sensor_leaves_the_model_alone_and_venting_forgets() {
        let mut bench = Bench::new([0.93; 3], [60; 3]);
        assert!(bench.run(10_000)[0] > 0.05);
        bench.sensor = false;
        bench.run(20);
        assert!(!bench.looped.falls_back());
        bench.run(2000);
        assert!(bench.looped.falls_back());
        assert!(bench.looped.trims().iter().all(|trim| trim.abs() < 1e-4));
        bench.sensor = true;
        assert!(bench.run(10_000)[0] > 0.05);
        bench.asked = None;
        assert!(none(bench.run(UPDATE_TICKS.into())));
    }

    #[test]
    fn any_numbers_are_survived() {
        let extremes = [i32::MIN, -1, 0, 1, 110 << 16, i32::MAX].map(Bend::from_bits);
        for asked in extremes {
            for bend in extremes {
                let mut looped = BendLoop::new();
                for pressure in [Pressure::MIN, Pressure::ZERO, Pressure::MAX] {
                    for _ in 0..2000 {
                        let seen = Observation {
                            bends: Some([asked; 3]),
                            setpoints: [pressure; 3],
                            estimates: [pressure; 3],
                            bend: Some(bend),
                            air_rests: true,
                        };
                        looped.step(&seen, &OWN);
                        let _ = looped.trimmed([asked; 3]);
                    }
                }
                assert!(looped.trims().iter().all(|trim| trim.to_num::<f64>().abs() < 0.1501));
            }
        }
    }
}
