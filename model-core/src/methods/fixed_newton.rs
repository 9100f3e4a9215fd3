//! Fixed-point Newton from a table of 8 degrees: the sign-safe products of [`crate::inverse`], to the last bit.

use super::Method;
use crate::inverse;
use crate::units::{Bend, Coefficients, Pressure};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct FixedNewton(Coefficients);

impl Method for FixedNewton {
    const NAME: &'static str = "fixed-newton";
    const SUMMARY: &'static str = "fixed point, Newton from a coarse table, rounded to the last bit";
    type Pressure = Pressure;
    type Bend = Bend;

    fn prepare(coefficients: &Coefficients) -> Self {
        Self(*coefficients)
    }

    fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        inverse::bend_from_pressure(&self.0, pressure)
    }

    fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        inverse::pressure_from_bend(&self.0, bend)
    }
}
