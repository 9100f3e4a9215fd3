//! What the methods should say, by [`crate::mechanics`].

use super::samples;
use crate::mechanics;
use crate::methods::{Direction, representable};
use model_core::methods::Representation;
use model_core::units::Coefficients;

/// The end of the pressure's domain in kPa.
const DOMAIN_KPA: f64 = 1000.0;
/// The end of the finger's working range in kPa.
const WORKING_KPA: f64 = 150.0;
/// The end of the bend's domain in degrees.
const DOMAIN_DEG: f64 = 170.0;

/// An input, the exact result, and whether it lies in the working range.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    pub input: f64,
    pub exact: f64,
    pub working: bool,
}

/// The samples of one calibration in both directions.
pub struct Truth {
    bends: Vec<Sample>,
    pressures: Vec<Sample>,
}

/// The bend in degrees at a pressure in kPa, ending at 170 degrees as the methods do.
pub fn bend_deg(coefficients: &Coefficients, pressure_kpa: f64) -> f64 {
    mechanics::angle_from_pressure_deg(&coefficients.to_f64_kpa(), pressure_kpa.min(DOMAIN_KPA)).min(DOMAIN_DEG)
}

/// The pressure in kPa at a bend in degrees.
pub fn pressure_kpa(coefficients: &Coefficients, bend_deg: f64) -> f64 {
    mechanics::pressure_from_angle_kpa(&coefficients.to_f64_kpa(), bend_deg.min(DOMAIN_DEG))
}

impl Truth {
    /// At all samples, rounded to `rounding`; pressures where they do not exceed 1000 kPa.
    pub fn new(coefficients: &Coefficients, rounding: Representation) -> Self {
        let inputs = |direction| samples::all(direction).into_iter().map(move |input| representable(rounding, input));
        let bends = inputs(Direction::BendFromPressure)
            .map(|input| Sample { input, exact: bend_deg(coefficients, input), working: input <= WORKING_KPA })
            .collect();
        let pressures = inputs(Direction::PressureFromBend)
            .map(|input| {
                let exact = pressure_kpa(coefficients, input);
                Sample { input, exact, working: exact <= WORKING_KPA }
            })
            .filter(|sample| sample.exact <= DOMAIN_KPA)
            .collect();
        Self { bends, pressures }
    }

    /// Those of one direction.
    pub fn samples(&self, direction: Direction) -> &[Sample] {
        match direction {
            Direction::BendFromPressure => &self.bends,
            Direction::PressureFromBend => &self.pressures,
        }
    }
}
