//! Rehabilitation sequences: `const` tables of steps, checked when they are compiled.
//!
//! ```
//! use model_core::sequence::{Sequence, Step};
//!
//! const STEPS: [Step; 2] = [Step::kpa([60, 30, 60]).ramp_ms(2000).hold_ms(5000), Step::kpa([0; 3]).ramp_ms(2000)];
//! const GENTLE: Sequence = Sequence::new("gentle", "Once to 60/30/60 kPa and back", &STEPS, 1);
//! assert_eq!(GENTLE.duration().0, 9000);
//! ```
//!
//! A table that breaks a limit does not compile:
//!
//! ```compile_fail
//! use model_core::sequence::{Sequence, Step};
//!
//! const STEPS: [Step; 2] = [Step::kpa([200, 0, 0]).ramp_ms(9000), Step::kpa([0; 3]).ramp_ms(9000)];
//! const TOO_MUCH: Sequence = Sequence::new("too-much", "200 kPa", &STEPS, 1);
//! ```

pub mod library;
pub mod player;

use crate::actuation::PerSegment;
use crate::units::{Bend, Millis, Pressure};

/// The highest setpoint of a step: the end of the paper's working range.
pub const MAX_PRESSURE: Pressure = Pressure::from_kpa(150);
/// The largest bend of a step: what the default calibration reaches at 150 kPa, rounded down.
pub const MAX_BEND: Bend = Bend::from_deg(110);
/// The steepest ramp, in kPa per second.
pub const MAX_KPA_PER_S: i64 = 100;
/// The steepest ramp, in degrees per second.
pub const MAX_DEG_PER_S: i64 = 75;
/// The largest step change without a ramp, in kPa: the paper's staircase.
pub const MAX_STEP_KPA: i64 = 30;
/// The largest step change without a ramp, in degrees: half of what 30 kPa does to a finger at rest.
pub const MAX_STEP_DEG: i64 = 25;
/// The longest name, in bytes: what a request of the host holds ([`crate::protocol::SequenceName`]).
pub const MAX_NAME_BYTES: usize = 24;
/// The most steps in a table.
pub const MAX_STEPS: usize = 64;
/// The longest run with all repeats: half an hour.
pub const MAX_DURATION: Millis = Millis(30 * 60 * 1000);

/// What a step asks of the three segments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Gauge pressure of each chamber.
    Pressure(PerSegment<Pressure>),
    /// Bend of each segment; the controller turns it into pressure by the segment's calibration, and trims it by the bend
    /// sensor.
    Bend(PerSegment<Bend>),
}

impl Target {
    /// A finger at rest.
    pub const REST: Self = Self::Pressure([Pressure::ZERO; 3]);

    /// Every value is zero.
    #[must_use]
    pub const fn at_rest(&self) -> bool {
        Values::of(self).at_rest()
    }

    /// Every value lies within what a step may ask for: 0..=[`MAX_PRESSURE`], 0..=[`MAX_BEND`].
    #[must_use]
    pub fn within_limits(&self) -> bool {
        match self {
            Self::Pressure(all) => all.iter().all(|one| (Pressure::ZERO..=MAX_PRESSURE).contains(one)),
            Self::Bend(all) => all.iter().all(|one| (Bend::ZERO..=MAX_BEND).contains(one)),
        }
    }
}

/// One step: go to the target in a straight line, then stay there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Where to.
    pub target: Target,
    /// Time of the straight line from the last step's target (zero: a step change).
    pub ramp: Millis,
    /// Time at the target after the ramp.
    pub hold: Millis,
}

impl Step {
    /// A step to these gauge pressures in kPa, without ramp or hold yet.
    #[must_use]
    pub const fn kpa([proximal, middle, distal]: PerSegment<i16>) -> Self {
        let target = [Pressure::from_kpa(proximal), Pressure::from_kpa(middle), Pressure::from_kpa(distal)];
        Self { target: Target::Pressure(target), ramp: Millis::ZERO, hold: Millis::ZERO }
    }

    /// A step to these bends in degrees, without ramp or hold yet.
    #[must_use]
    pub const fn deg([proximal, middle, distal]: PerSegment<i16>) -> Self {
        let target = [Bend::from_deg(proximal), Bend::from_deg(middle), Bend::from_deg(distal)];
        Self { target: Target::Bend(target), ramp: Millis::ZERO, hold: Millis::ZERO }
    }

    /// The same with a ramp of this many milliseconds.
    #[must_use]
    pub const fn ramp_ms(self, ramp: u32) -> Self {
        Self { ramp: Millis(ramp), ..self }
    }

    /// The same with a hold of this many milliseconds.
    #[must_use]
    pub const fn hold_ms(self, hold: u32) -> Self {
        Self { hold: Millis(hold), ..self }
    }
}

/// A named table of steps, run some times; afterwards the finger vents. Only checked tables exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// The name on the command line and in the protocol.
    pub name: &'static str,
    /// One line for people.
    pub description: &'static str,
    steps: &'static [Step],
    repeats: u16,
    identifies: bool,
}

/// What is wrong with a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SequenceError {
    /// The name is no kebab-case (lower-case letters and digits, single hyphens between), or longer than
    /// [`MAX_NAME_BYTES`].
    Name,
    /// There are no steps, or more than [`MAX_STEPS`].
    Length,
    /// The repeats are zero.
    Repeats,
    /// A setpoint lies outside 0..=150 kPa.
    Pressure,
    /// A setpoint lies outside 0..=110 degrees.
    Bend,
    /// A ramp is steeper than [`MAX_KPA_PER_S`] or [`MAX_DEG_PER_S`].
    Ramp,
    /// A step change without a ramp is larger than [`MAX_STEP_KPA`] or [`MAX_STEP_DEG`].
    StepChange,
    /// Pressures and bends follow each other elsewhere than at zero.
    Mixed,
    /// The last step does not end at zero.
    End,
    /// All repeats together take longer than [`MAX_DURATION`].
    Duration,
}

impl Sequence {
    /// A checked table, in `const` evaluation.
    ///
    /// # Panics
    /// When the table breaks a limit: as a compile error that names the limit. At run time use [`Sequence::check`].
    #[must_use]
    pub const fn new(name: &'static str, description: &'static str, steps: &'static [Step], repeats: u16) -> Self {
        match Self::check(name, description, steps, repeats) {
            Ok(sequence) => sequence,
            Err(SequenceError::Name) => {
                panic!("sequence: the name must be 1 to 24 lower-case letters and digits, single hyphens between")
            }
            Err(SequenceError::Length) => panic!("sequence: a table has 1 to 64 steps: add a step or split the table"),
            Err(SequenceError::Repeats) => panic!("sequence: repeats must be at least 1"),
            Err(SequenceError::Pressure) => {
                panic!("sequence: a setpoint lies outside 0..=150 kPa, the finger's working range: lower it")
            }
            Err(SequenceError::Bend) => {
                panic!("sequence: a setpoint lies outside 0..=110 degrees, the finger's working range: lower it")
            }
            Err(SequenceError::Ramp) => {
                panic!("sequence: a ramp is steeper than 100 kPa/s or 75 degrees/s: make it longer")
            }
            Err(SequenceError::StepChange) => {
                panic!("sequence: a step without a ramp changes by more than 30 kPa or 25 degrees: give it a ramp")
            }
            Err(SequenceError::Mixed) => {
                panic!("sequence: pressures and bends follow each other away from zero: put a step at zero between")
            }
            Err(SequenceError::End) => panic!("sequence: the last step must end at zero in every segment"),
            Err(SequenceError::Duration) => {
                panic!("sequence: all repeats together last longer than 30 minutes: shorten it")
            }
        }
    }

    /// A checked table; the first broken limit otherwise.
    ///
    /// # Errors
    /// See [`SequenceError`].
    pub const fn check(
        name: &'static str,
        description: &'static str,
        steps: &'static [Step],
        repeats: u16,
    ) -> Result<Self, SequenceError> {
        if !is_kebab(name.as_bytes()) || name.len() > MAX_NAME_BYTES {
            return Err(SequenceError::Name);
        }
        if steps.is_empty() || steps.len() > MAX_STEPS {
            return Err(SequenceError::Length);
        }
        if repeats == 0 {
            return Err(SequenceError::Repeats);
        }
        let mut previous = Values::REST;
        let mut rest = steps;
        let mut once: u64 = 0;
        // Slice patterns instead of indices: nothing here can panic at run time.
        while let [step, tail @ ..] = rest {
            let next = Values::of(&step.target);
            if let Err(error) = next.check_after(&previous, step.ramp) {
                return Err(error);
            }
            once += step.ramp.0 as u64 + step.hold.0 as u64;
            previous = next;
            rest = tail;
        }
        if !previous.at_rest() {
            return Err(SequenceError::End);
        }
        if once * repeats as u64 > MAX_DURATION.0 as u64 {
            return Err(SequenceError::Duration);
        }
        Ok(Self { name, description, steps, repeats, identifies: false })
    }

    /// The same for a finger that the calibration in use does not fit: its bend may be far from the model's while it runs.
    #[must_use]
    pub const fn for_identification(self) -> Self {
        Self { identifies: true, ..self }
    }

    /// Whether the finger's bend may be far from the model's.
    #[must_use]
    pub const fn identifies(&self) -> bool {
        self.identifies
    }

    /// The steps, in order; at least one.
    #[must_use]
    pub const fn steps(&self) -> &'static [Step] {
        self.steps
    }

    /// How often the steps are run, at least once.
    #[must_use]
    pub const fn repeats(&self) -> u16 {
        self.repeats
    }

    /// The time of all repeats, without the venting that follows.
    #[must_use]
    pub fn duration(&self) -> Millis {
        let once = self.steps.iter().fold(Millis::ZERO, |sum, step| sum + step.ramp + step.hold);
        Millis(once.0.saturating_mul(u32::from(self.repeats)))
    }
}

/// A target's raw values in 2^-16 of its unit, for the checks.
struct Values {
    bits: PerSegment<i64>,
    is_bend: bool,
}

impl Values {
    const REST: Self = Self { bits: [0; 3], is_bend: false };

    const fn of(target: &Target) -> Self {
        match *target {
            Target::Pressure([p, m, d]) => {
                Self { bits: [p.to_bits() as i64, m.to_bits() as i64, d.to_bits() as i64], is_bend: false }
            }
            Target::Bend([p, m, d]) => {
                Self { bits: [p.to_bits() as i64, m.to_bits() as i64, d.to_bits() as i64], is_bend: true }
            }
        }
    }

    const fn at_rest(&self) -> bool {
        let [p, m, d] = self.bits;
        p == 0 && m == 0 && d == 0
    }

    const fn check_after(&self, previous: &Self, ramp: Millis) -> Result<(), SequenceError> {
        let (limit, steepest, largest, outside) = if self.is_bend {
            (MAX_BEND.to_bits() as i64, MAX_DEG_PER_S, MAX_STEP_DEG, SequenceError::Bend)
        } else {
            (MAX_PRESSURE.to_bits() as i64, MAX_KPA_PER_S, MAX_STEP_KPA, SequenceError::Pressure)
        };
        let [p, m, d] = self.bits;
        let [last_p, last_m, last_d] = previous.bits;
        if p < 0 || m < 0 || d < 0 || p > limit || m > limit || d > limit {
            return Err(outside);
        }
        if self.is_bend != previous.is_bend && !previous.at_rest() && !self.at_rest() {
            return Err(SequenceError::Mixed);
        }
        let change = max(max((p - last_p).abs(), (m - last_m).abs()), (d - last_d).abs());
        if ramp.0 == 0 {
            return if change > largest << 16 { Err(SequenceError::StepChange) } else { Ok(()) };
        }
        // change / ramp > steepest, without a division.
        if change * 1000 > (steepest << 16) * ramp.0 as i64 { Err(SequenceError::Ramp) } else { Ok(()) }
    }
}

const fn max(a: i64, b: i64) -> i64 {
    if a > b { a } else { b }
}

/// Words of lower-case letters and digits with single hyphens between.
const fn is_kebab(mut name: &[u8]) -> bool {
    let mut in_word = false;
    while let [first, rest @ ..] = name {
        let letter = first.is_ascii_lowercase() || first.is_ascii_digit();
        if !(letter || *first == b'-' && in_word) {
            return false;
        }
        in_word = letter;
        name = rest;
    }
    in_word
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(steps: Vec<Step>, repeats: u16) -> Result<Sequence, SequenceError> {
        Sequence::check("test", "a test", steps.leak(), repeats)
    }

    const REST: Step = Step::kpa([0; 3]).ramp_ms(3000);

    #[test]
    fn each_limit_is_met_exactly_and_named_when_broken() {
        for (steps, expected) in [
            (vec![Step::kpa([150; 3]).ramp_ms(1500), REST], None),
            (vec![Step::kpa([150; 3]).ramp_ms(1499), REST], Some(SequenceError::Ramp)),
            (vec![Step::kpa([151, 0, 0]).ramp_ms(9000), REST], Some(SequenceError::Pressure)),
            (vec![Step::kpa([0, -1, 0]).ramp_ms(9000), REST], Some(SequenceError::Pressure)),
            (vec![Step::deg([0, 0, 111]).ramp_ms(9000), REST], Some(SequenceError::Bend)),
            (vec![Step::deg([75, 0, 0]).ramp_ms(1000), REST], None),
            (vec![Step::deg([75, 0, 0]).ramp_ms(999), REST], Some(SequenceError::Ramp)),
            (vec![Step::kpa([30; 3]), REST], None),
            (vec![Step::kpa([31; 3]), REST], Some(SequenceError::StepChange)),
            (vec![Step::deg([26, 0, 0]), REST], Some(SequenceError::StepChange)),
            (vec![Step::kpa([30; 3]), Step::deg([10; 3]).ramp_ms(900), REST], Some(SequenceError::Mixed)),
            (vec![Step::kpa([0; 3]), Step::deg([10; 3]).ramp_ms(900), REST], None),
            (vec![Step::kpa([30; 3])], Some(SequenceError::End)),
            (vec![], Some(SequenceError::Length)),
            (vec![REST; 65], Some(SequenceError::Length)),
            (vec![REST.hold_ms(30 * 60 * 1000)], Some(SequenceError::Duration)),
        ] {
            let text = format!("{steps:?}");
            assert_eq!(check(steps, 1).err(), expected, "{text}");
        }
        assert_eq!(check(vec![REST], 0).err(), Some(SequenceError::Repeats));
    }

    #[test]
    fn names_are_kebab_case_and_fit_into_a_request() {
        let longest = "abcdefghij-klmnopqrst-uv";
        assert_eq!(longest.len(), MAX_NAME_BYTES);
        for good in [longest, "a", "3-points"] {
            assert_eq!(Sequence::check(good, "", &[REST], 1).map(|sequence| sequence.name), Ok(good));
        }
        let too_long = "abcdefghij-klmnopqrst-uvw";
        for bad in ["", "-", "Bad", "two words", "under_score", "-a", "a-", "a--b", "gr\u{fc}n", too_long] {
            assert_eq!(Sequence::check(bad, "", &[REST], 1).err(), Some(SequenceError::Name), "{bad}");
        }
    }
}
