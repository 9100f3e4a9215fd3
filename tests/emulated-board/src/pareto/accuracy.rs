//! Errors of the methods, on the host, against the plant's own mechanics in f64.

use super::samples::{LARGEST, domain_end, even, hard, model, working_end};
use super::{Direction, calibrations};
use model_core::methods::{Method, Quantity as _};
use model_core::units::Coefficients;

/// Inputs of the default calibration, in the working range and again in the whole domain; others get a quarter.
const SAMPLES: u32 = 20_000;

/// Inputs with the model's answers, the same for all methods.
pub struct Truth(Vec<Calibrated>);

struct Calibrated {
    coefficients: Coefficients,
    /// Bend, pressure: input, answer, whether in the working range.
    points: [Vec<(f64, f64, bool)>; 2],
}

impl Truth {
    /// Evaluates the model for all calibrations.
    #[must_use]
    pub fn new() -> Self {
        let calibrated = |(index, coefficients): (usize, Coefficients)| {
            let real = coefficients.to_f64_kpa();
            let count = if index == 0 { SAMPLES } else { SAMPLES / 4 };
            let points = Direction::BOTH.map(|direction| {
                let [working, domain] = [working_end(direction, &real), domain_end(direction)];
                let inputs = even(count, working).chain(even(count, domain)).chain(hard(count / 10, domain));
                inputs.map(|input| (input, model(direction, &real, input), input <= working)).collect()
            });
            Calibrated { coefficients, points }
        };
        Self(calibrations().into_iter().enumerate().map(calibrated).collect())
    }
}

impl Default for Truth {
    fn default() -> Self {
        Self::new()
    }
}

/// Errors over a set of inputs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    /// The worst; infinite when a result is no number.
    pub max: f64,
    squares: f64,
    count: f64,
}

impl Errors {
    fn add(&mut self, error: f64) {
        let error = if error.is_nan() { f64::INFINITY } else { error.abs() };
        self.max = self.max.max(error);
        self.squares += error * error;
        self.count += 1.0;
    }

    /// Root mean square.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.squares / self.count.max(1.0)).sqrt()
    }
}

/// A direction's errors in its result's unit, degrees or kPa.
#[derive(Clone, Copy, Debug, Default)]
pub struct Accuracy {
    /// Default calibration, 0..150 kPa.
    pub working: Errors,
    /// Default calibration, 0..1000 kPa or 0..170 degrees.
    pub whole: Errors,
    /// All calibrations, 0..150 kPa.
    pub any_working: Errors,
    /// All calibrations, 0..1000 kPa or 0..170 degrees.
    pub any_whole: Errors,
}

/// Measures one direction of a method.
pub fn measure<M: Method>(direction: Direction, truth: &Truth) -> Accuracy {
    let mut accuracy = Accuracy::default();
    for (index, calibrated) in truth.0.iter().enumerate() {
        let method = M::prepare(&calibrated.coefficients);
        for &(input, answer, working) in &calibrated.points[direction as usize] {
            let result = match direction {
                Direction::Bend => method.bend_from_pressure(M::Pressure::from_f64(input)).to_f64(),
                Direction::Pressure => method.pressure_from_bend(M::Bend::from_f64(input)).to_f64(),
            };
            // Floats may go on where I16F16 saturates. `min` would turn a NaN into a number.
            let error = if result > LARGEST { LARGEST - answer } else { result - answer };
            let default = index == 0;
            for (errors, counts) in [
                (&mut accuracy.working, default && working),
                (&mut accuracy.whole, default),
                (&mut accuracy.any_working, working),
                (&mut accuracy.any_whole, true),
            ] {
                if counts {
                    errors.add(error);
                }
            }
        }
    }
    accuracy
}
