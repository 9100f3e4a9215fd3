//! What has been seen of one function over a stretch of rising inputs.

use super::{LSB, Subject};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Upper ends of the histogram's bins, in LSB of the result; the last one takes the rest.
pub const BIN_ENDS_LSB: [f64; 9] = [0.25, 0.5, 0.51, 0.6, 0.75, 1.0, 4.0, 64.0, f64::INFINITY];

/// Failures that are written out; the rest is counted.
const MOST_DESCRIBED: usize = 5;

/// An error and where it was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extreme {
    /// Absolute error in the result's unit.
    pub error: f64,
    /// Bits of the input.
    pub input_bits: i32,
}

impl Extreme {
    fn include(&mut self, other: Self) {
        // A NaN must not pass for small.
        if other.error > self.error || other.error.is_nan() {
            *self = other;
        }
    }
}

/// See the module.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Inputs visited.
    pub inputs: u64,
    /// Those of them in the domain.
    pub domain_inputs: u64,
    /// The largest error in the domain.
    pub worst: Extreme,
    /// The largest error in the working range.
    pub worst_working: Extreme,
    /// Sum of the squared errors in the domain.
    pub squares: f64,
    /// Results in the domain by the size of their error.
    pub histogram: [u64; BIN_ENDS_LSB.len()],
    /// Broken demands of every kind.
    pub failures: u64,
    /// The first few of them.
    pub described: Vec<String>,
    first: Option<(i32, i32)>,
    last: Option<(i32, i32)>,
}

impl Tally {
    /// Visits inputs in rising order. A panic of the function is a failure and ends the stretch.
    pub fn visit(&mut self, subject: &Subject, value_at_end: i32, inputs: impl Iterator<Item = i32>) {
        let mut at = None;
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            for bits in inputs {
                at = Some(bits);
                let result = subject.evaluate(bits);
                self.judge(subject, value_at_end, bits, result);
            }
        }));
        if outcome.is_err() {
            self.fail(|| at.map_or_else(|| "panics".to_owned(), |bits| format!("panics at input {bits}")));
        }
    }

    fn judge(&mut self, subject: &Subject, value_at_end: i32, bits: i32, result: i32) {
        self.inputs += 1;
        self.check_order(bits, result);
        self.first.get_or_insert((bits, result));
        self.last = Some((bits, result));
        if let Some(expected) = subject.expected_outside(bits, value_at_end) {
            if result != expected {
                self.fail(|| format!("gives {result} at input {bits} outside the domain, not {expected}"));
            }
            return;
        }
        self.domain_inputs += 1;
        let judged = subject.error(bits, result);
        let here = Extreme { error: judged.error.abs(), input_bits: bits };
        self.worst.include(here);
        if judged.working {
            self.worst_working.include(here);
        }
        self.squares += here.error * here.error;
        let bin = BIN_ENDS_LSB.iter().position(|&end| here.error <= end * LSB).unwrap_or(BIN_ENDS_LSB.len() - 1);
        self.histogram[bin] += 1;
        let bound = subject.bound.absolute + subject.bound.relative * judged.exact.abs();
        let within = here.error <= bound;
        if !within {
            self.fail(|| format!("is off by {:.3e} at input {bits}, bound {bound:.3e}", judged.error));
        }
    }

    fn check_order(&mut self, bits: i32, result: i32) {
        if let Some((before, value)) = self.last
            && result < value
        {
            self.fail(|| format!("falls from {value} at input {before} to {result} at input {bits}"));
        }
    }

    fn fail(&mut self, describe: impl FnOnce() -> String) {
        self.failures += 1;
        if self.described.len() < MOST_DESCRIBED {
            self.described.push(describe());
        }
    }

    /// Appends what was seen of the inputs that follow; that the result does not fall from one to the other is checked.
    #[must_use]
    pub fn followed_by(mut self, next: Self) -> Self {
        if let Some((bits, result)) = next.first {
            self.check_order(bits, result);
        }
        self.inputs += next.inputs;
        self.domain_inputs += next.domain_inputs;
        self.worst.include(next.worst);
        self.worst_working.include(next.worst_working);
        self.squares += next.squares;
        for (sum, count) in self.histogram.iter_mut().zip(next.histogram) {
            *sum += count;
        }
        self.failures += next.failures;
        self.described.extend(next.described);
        self.described.truncate(MOST_DESCRIBED);
        self.first = self.first.or(next.first);
        self.last = next.last.or(self.last);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BEND_BOUND, Subject};
    use super::*;
    use model_core::calibration::DEFAULT;
    use model_core::inverse::bend_from_pressure;
    use model_core::units::{Bend, Pressure};

    const END: i32 = 1000 << 16;

    /// What is found of the core's inverse with one result spoilt.
    fn spoilt(at: i32, spoil: fn(i32) -> i32) -> Tally {
        let subject = Subject::bend("spoilt", DEFAULT, BEND_BOUND, move |p: Pressure| {
            let good = bend_from_pressure(&DEFAULT, p).to_bits();
            Bend::from_bits(if p.to_bits() == at { spoil(good) } else { good })
        });
        let value_at_end = bend_from_pressure(&DEFAULT, Pressure::from_bits(END)).to_bits();
        let stretch = |range: std::ops::Range<i32>| {
            let mut tally = Tally::default();
            tally.visit(&subject, value_at_end, range);
            tally
        };
        // `at` opens the second stretch, so that the border is what is tested.
        stretch(at - 100..at).followed_by(stretch(at..at + 100))
    }

    #[test]
    fn what_is_wrong_is_found() {
        let inside = 30 << 16;
        assert_eq!(spoilt(inside, |good| good).failures, 0);
        assert_eq!(spoilt(END + 200, |good| good).failures, 0);
        let falls = spoilt(inside, |good| good - 3);
        assert!(falls.described.iter().any(|text| text.contains("falls")), "{:?}", falls.described);
        // The bound is 3.3 LSB.
        let off = spoilt(inside, |good| good + 5);
        assert!(off.described.iter().any(|text| text.contains("off by")), "{:?}", off.described);
        assert_eq!(off.worst.input_bits, inside);
        let outside = spoilt(END + 200, |good| good + 1);
        assert!(outside.described.iter().any(|text| text.contains("outside")), "{:?}", outside.described);
        let below = spoilt(-200, |good| good - 1);
        assert!(below.described.iter().any(|text| text.contains("outside")), "{:?}", below.described);
    }

    #[test]
    fn a_panic_is_a_failure_with_its_input() {
        let tally = spoilt(30 << 16, |_| panic!("this panic belongs to the test"));
        assert_eq!(tally.described, ["panics at input 1966080"]);
    }
}
