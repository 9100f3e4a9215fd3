//! The core's own two ways, as methods among the others.

use super::Method;
use crate::inverse::{self, Tabulated};
use crate::units::{Bend, Coefficients, Pressure};

/// [`inverse::bend_from_pressure`] and [`inverse::pressure_from_bend`]: what the controller calls.
#[derive(Clone, Copy, Debug)]
pub struct SegmentNewton(Coefficients);

impl Method for SegmentNewton {
    const NAME: &'static str = "segment-newton";
    const SUMMARY: &'static str = "fixed point, any calibration: this finger's quintic on a segment, solved by Newton";
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

/// [`Tabulated`]: for many calls at one calibration.
pub type FloatingQuartic = Tabulated;

impl Method for Tabulated {
    const NAME: &'static str = "floating-quartic";
    const SUMMARY: &'static str = "fixed point, one calibration: quartics on floating segments";
    type Pressure = Pressure;
    type Bend = Bend;

    fn prepare(coefficients: &Coefficients) -> Self {
        Self::new(coefficients)
    }

    fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        Self::bend_from_pressure(self, pressure)
    }

    fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        Self::pressure_from_bend(self, bend)
    }
}
