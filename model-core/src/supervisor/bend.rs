//! The finger's bend against the model's bend of the estimated pressures: an independent look at the chambers' true
//! pressures, and at whether something holds or pushes the finger.
//!
//! The work is spread over four ticks: one chamber's bend in each of three, and the comparison in the fourth.

use crate::actuation::PerSegment;
use crate::inverse::bend_from_pressure;
use crate::units::{Bend, Coefficients, Pressure};

/// Ticks of one round.
const ROUND: u8 = 4;
/// The finger follows its pressures with a lag of 80 ms: its share in a round, over 256.
const LAG_SHARE: i64 = 12;
/// At rest the sum of the bends may be off by this: zero, noise, how the finger lies.
const BOUND: Bend = Bend::from_deg(12);
/// And by a sixteenth of itself: calibration, gain.
const BOUND_SHIFT: u32 = 4;
/// And by what 1.5 kPa in a chamber make: bend grows with the root of the pressure, so most near zero. Below each pressure.
const NEAR_ZERO: (Pressure, Bend) = (Pressure::from_kpa(3), Bend::from_deg(9));
const LOW: (Pressure, Bend) = (Pressure::from_kpa(15), Bend::from_deg(4));
const HIGH: Bend = Bend::from_deg(2);
/// Driven, with everything open and every chamber below the first for so many rounds (600 ms) there is no air: no more than this then.
const EMPTY: (Pressure, Bend) = (Pressure::from_kpa(1), Bend::from_deg(6));
const EMPTY_ROUNDS: u8 = 150;
/// While a finger is being identified, by this too: one segment alone, from the stiffest coefficients admitted to the softest.
const UNKNOWN_FINGER: Bend = Bend::from_deg(60);
/// In motion by the lag's own error, this many quarters of the way that is left, and for a while after.
const MOTION_QUARTERS: i32 = 5;
const MOTION_FADES: u32 = 6;
/// For so many rounds: 240 ms.
const ROUNDS: u8 = 60;
/// Below this mean absolute second difference the signal stands still: a sound sensor's noise of 0.3 degrees has 0.6, half of it 0.3;
/// 0.05 degrees of a dead one 0.1.
const SMOOTH: Bend = Bend::from_milli_deg(180);
/// Here a sound sensor stands still too: its range ends at 360 degrees.
const RANGE_END: Bend = Bend::from_deg(350);
/// Ticks for which the reading must be out of its electrical range.
const FAILED_TICKS: u8 = 5;

/// What the bend says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    Agrees,
    Disagrees,
    SensorFailed,
}

/// See the module's page.
#[derive(Clone, Debug)]
pub(super) struct Residual {
    round: u8,
    sum: Bend,
    /// The widest margin of this round, and half of the others'.
    widest: Bend,
    margins: Bend,
    /// The expected bend, with the finger's lag.
    expected: Bend,
    /// The reading, filtered over 8 ms, and its last two.
    seen: Bend,
    last: [Bend; 2],
    roughness: Bend,
    motion: Bend,
    off: u8,
    empty: u8,
    failed: u8,
    started: bool,
}

/// What the chambers are to make of the finger.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chambers<'a> {
    /// Estimates.
    pub pressures: &'a PerSegment<Pressure>,
    pub coefficients: &'a PerSegment<Coefficients>,
    /// The coefficients may be far off.
    pub identifies: bool,
    /// The finger is driven, and everything is open.
    pub open: bool,
}

impl Residual {
    pub(super) const fn new() -> Self {
        Self {
            round: 0,
            sum: Bend::ZERO,
            widest: Bend::ZERO,
            margins: Bend::ZERO,
            expected: Bend::ZERO,
            seen: Bend::ZERO,
            last: [Bend::ZERO; 2],
            roughness: Bend::from_milli_deg(600),
            motion: Bend::ZERO,
            off: 0,
            empty: 0,
            failed: 0,
            started: false,
        }
    }

    /// One tick: the reading, if it is one, and the chambers.
    pub(super) fn watch(&mut self, reading: Option<Bend>, chambers: &Chambers) -> Verdict {
        self.failed = if reading.is_none() { self.failed.saturating_add(1) } else { 0 };
        if let Some(reading) = reading {
            self.read(reading);
        }
        let mut verdict = if self.failed >= FAILED_TICKS { Verdict::SensorFailed } else { Verdict::Agrees };
        let index = usize::from(self.round);
        if let (Some(&chamber), Some(coefficients)) = (chambers.pressures.get(index), chambers.coefficients.get(index))
        {
            self.sum = self.sum + bend_from_pressure(coefficients, chamber);
            let margin = match chamber {
                _ if chamber < NEAR_ZERO.0 => NEAR_ZERO.1,
                _ if chamber < LOW.0 => LOW.1,
                _ => HIGH,
            };
            // The largest whole, the others half: they are hardly all at their worst the same way.
            let (large, small) = (self.widest.max(margin), self.widest.min(margin));
            self.margins = self.margins + Bend::from_bits(small.to_bits() / 2);
            self.widest = large;
        } else if reading.is_some() && self.started && self.differs(chambers) {
            let stands_still = self.roughness < SMOOTH && self.seen < RANGE_END;
            verdict = if stands_still { Verdict::SensorFailed } else { Verdict::Disagrees };
        }
        self.round = (self.round + 1) % ROUND;
        verdict
    }

    fn read(&mut self, reading: Bend) {
        let [one, two] = self.last;
        self.last = [reading, one];
        if !self.started {
            (self.seen, self.last, self.started) = (reading, [reading; 2], true);
            return;
        }
        let curve = ((reading - one) - (one - two)).abs();
        self.roughness = self.roughness.low_passed(curve, 6);
        self.seen = self.seen.low_passed(reading, 3);
    }

    /// Ends a round.
    fn differs(&mut self, chambers: &Chambers) -> bool {
        let target = core::mem::take(&mut self.sum);
        self.expected = lagged(self.expected, target);
        let left = (target - self.expected).abs();
        let fading = self.motion - Bend::from_bits(self.motion.to_bits() >> MOTION_FADES);
        self.motion = left.max(fading);
        let motion = Bend::from_bits((self.motion.to_bits() >> 2).saturating_mul(MOTION_QUARTERS));
        let margins = core::mem::take(&mut self.widest) + core::mem::take(&mut self.margins);
        let no_air = chambers.open && chambers.pressures.iter().all(|&chamber| chamber < EMPTY.0);
        let margins = if super::held::lasts(&mut self.empty, no_air, EMPTY_ROUNDS) { EMPTY.1 } else { margins };
        let bound = BOUND + margins + Bend::from_bits(self.expected.to_bits() >> BOUND_SHIFT) + motion;
        let bound = if chambers.identifies { bound + UNKNOWN_FINGER } else { bound };
        super::held::lasts(&mut self.off, (self.seen - self.expected).abs() > bound, ROUNDS)
    }

    /// Whether reading and pressures agree now.
    pub(super) fn is_calm(&self) -> bool {
        self.off == 0
    }
}

/// A round of the finger's lag from `old` on towards `new`.
fn lagged(old: Bend, new: Bend) -> Bend {
    let way = (i64::from(new.to_bits()) - i64::from(old.to_bits())) * LAG_SHARE;
    old + Bend::from_bits((way >> 8) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration;

    const FINGER: PerSegment<Coefficients> = [calibration::DEFAULT; 3];

    /// What comes of ticks with these chambers (kPa) and readings (degrees): the first verdict that is not agreement.
    fn first(ticks: impl Iterator<Item = (f64, Option<f64>)>) -> Option<(usize, Verdict)> {
        let mut residual = Residual::new();
        ticks.enumerate().find_map(|(tick, (chamber, reading))| {
            let reading = reading.map(Bend::from_f64_deg);
            let pressures = &[Pressure::from_f64_kpa(chamber); 3];
            let chambers = Chambers { pressures, coefficients: &FINGER, identifies: false, open: chamber == 0.0 };
            let verdict = residual.watch(reading, &chambers);
            (verdict != Verdict::Agrees).then_some((tick, verdict))
        })
    }

    /// A finger that follows with this lag (ms), a step to 60 kPa at tick 100, and a sensor with some noise.
    fn step(lag: f64, gain: f64) -> impl Iterator<Item = (f64, Option<f64>)> {
        let target = 3.0 * bend_from_pressure(&calibration::DEFAULT, Pressure::from_kpa(60)).to_f64();
        let mut bend = 0.0;
        (0..3000).map(move |tick| {
            let (chamber, goal) = if tick < 100 { (0.0, 0.0) } else { (60.0, target * gain) };
            bend += (goal - bend) / lag;
            (chamber, Some(bend + [0.4, -0.4][tick % 2]))
        })
    }

    #[test]
    fn a_finger_that_follows_agrees_whatever_its_lag() {
        for lag in [40.0, 80.0, 160.0] {
            for gain in [0.96, 1.0, 1.04] {
                assert_eq!(first(step(lag, gain)), None, "{lag} {gain}");
            }
        }
    }

    #[test]
    fn a_segment_that_stays_bent_without_air_disagrees() {
        let bent = |deg: f64| move |tick: usize| (0.0, Some(deg + [0.4, -0.4][tick % 2]));
        let (tick, verdict) = first((0..3000).map(bent(22.0))).expect("found");
        assert_eq!(verdict, Verdict::Disagrees);
        assert!((600..1200).contains(&tick), "{tick}");
        assert_eq!(first((0..3000).map(bent(14.0))), None);
    }

    #[test]
    fn a_finger_that_is_held_disagrees_and_a_sensor_that_stands_still_failed() {
        let (tick, verdict) = first(step(80.0, 0.6)).expect("found");
        assert_eq!(verdict, Verdict::Disagrees);
        assert!(tick < 1500, "{tick}");
        let frozen = step(80.0, 1.0).map(|(chamber, _)| (chamber, Some(0.0)));
        assert_eq!(first(frozen).map(|(_, verdict)| verdict), Some(Verdict::SensorFailed));
        let broken = (0..10).map(|_| (0.0, None));
        assert_eq!(first(broken), Some((4, Verdict::SensorFailed)));
    }
}
