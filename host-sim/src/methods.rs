//! All methods of `model_core::methods` as values, to be listed, looked up by name and run side by side.

use model_core::methods::{Method, Quantity, Representation, StdRoot};
use model_core::units::Coefficients;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Which way a method computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// α = f(P).
    BendFromPressure,
    /// P = f⁻¹(α).
    PressureFromBend,
}

impl Direction {
    /// Both.
    pub const ALL: [Self; 2] = [Self::BendFromPressure, Self::PressureFromBend];

    /// As in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::BendFromPressure => "bend-from-pressure",
            Self::PressureFromBend => "pressure-from-bend",
        }
    }

    /// The result's unit, as at the end of JSON keys.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::BendFromPressure => "deg",
            Self::PressureFromBend => "kpa",
        }
    }
}

/// A method that has been given a calibration. Pressures in kPa, bends in degrees.
pub trait Prepared {
    /// The result in one direction; `input` is rounded to the method's own representation first.
    fn evaluate(&self, direction: Direction, input: f64) -> f64;
    /// How long all `inputs` take, converted beforehand.
    fn time(&self, direction: Direction, inputs: &[f64]) -> Duration;
}

/// A method by its name.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// On command lines and in tables.
    pub name: &'static str,
    /// One line for people.
    pub summary: &'static str,
    /// What it takes and gives.
    pub representation: Representation,
    /// Its state in RAM, for both directions.
    pub state_bytes: usize,
    /// Gives it a calibration.
    pub prepare: fn(&Coefficients) -> Box<dyn Prepared>,
}

struct Of<M>(M);

impl<M: Method> Prepared for Of<M> {
    fn evaluate(&self, direction: Direction, input: f64) -> f64 {
        match direction {
            Direction::BendFromPressure => self.0.bend_from_pressure(M::Pressure::from_f64(input)).to_f64(),
            Direction::PressureFromBend => self.0.pressure_from_bend(M::Bend::from_f64(input)).to_f64(),
        }
    }

    fn time(&self, direction: Direction, inputs: &[f64]) -> Duration {
        match direction {
            Direction::BendFromPressure => timed(inputs, M::Pressure::from_f64, |x| self.0.bend_from_pressure(x)),
            Direction::PressureFromBend => timed(inputs, M::Bend::from_f64, |x| self.0.pressure_from_bend(x)),
        }
    }
}

fn timed<X: Copy, Y>(inputs: &[f64], convert: impl Fn(f64) -> X, of: impl Fn(X) -> Y) -> Duration {
    let inputs: Vec<X> = inputs.iter().map(|&input| convert(input)).collect();
    let started = Instant::now();
    for &input in &inputs {
        black_box(of(black_box(input)));
    }
    started.elapsed()
}

fn entry<M: Method + 'static>() -> Entry {
    Entry {
        name: M::NAME,
        summary: M::SUMMARY,
        representation: M::Bend::REPRESENTATION,
        state_bytes: size_of::<M>(),
        prepare: |coefficients| Box::new(Of(M::prepare(coefficients))),
    }
}

/// All methods, in the order in which `model_core` lists them.
#[must_use]
pub fn all() -> Vec<Entry> {
    /// `f32-newton-native`'s square root.
    type Root = StdRoot;
    macro_rules! entries {
        ($($name:ident: $method:ty;)*) => { vec![$(entry::<$method>()),*] };
    }
    model_core::for_each_method!(entries)
}

/// The method of this name.
///
/// # Errors
/// Names all there are.
pub fn find(name: &str) -> Result<Entry, String> {
    let all = all();
    all.iter().find(|entry| entry.name == name).copied().ok_or_else(|| {
        let names: Vec<_> = all.iter().map(|entry| entry.name).collect();
        format!("no method is named {name:?}; there are {}", names.join(", "))
    })
}

/// The nearest number that a representation can hold, saturating as the methods do.
#[must_use]
pub fn representable(representation: Representation, value: f64) -> f64 {
    match representation {
        Representation::Fixed => model_core::units::Pressure::from_f64(value).to_f64(),
        Representation::F32 => f64::from(value as f32),
        Representation::F64 => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::calibration::DEFAULT;

    #[test]
    fn names_are_unique_and_found() {
        let all = all();
        for entry in &all {
            assert_eq!(all.iter().filter(|other| other.name == entry.name).count(), 1, "{}", entry.name);
            assert_eq!(find(entry.name).expect("there").name, entry.name);
        }
        let error = find("guess").expect_err("unknown");
        assert!(error.contains("guess") && error.contains("fixed-newton") && error.contains("f64-newton"), "{error}");
    }

    #[test]
    fn every_method_knows_the_papers_finger() {
        // Table 2, chamber with exoskeleton, 60 kPa.
        for entry in all() {
            let method = (entry.prepare)(&DEFAULT);
            let bend = method.evaluate(Direction::BendFromPressure, 60.0);
            assert!((bend - 71.0).abs() < 0.7, "{}: {bend}", entry.name);
            let pressure = method.evaluate(Direction::PressureFromBend, 71.0);
            assert!((pressure - 60.0).abs() < 1.0, "{}: {pressure}", entry.name);
        }
    }
}
