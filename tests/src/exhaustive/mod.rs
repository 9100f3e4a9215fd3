//! Every input of the fixed-point functions: which functions, what is asked of them, and how they are visited.
//!
//! [`subjects`] is the list. A function maps 32 bits to 32 bits, so that all of its inputs can be visited; it must not
//! panic, must never fall, must keep to its error bound in its domain and to the domain's end values outside.

pub mod report;
pub mod run;
pub mod tally;

use host_sim::mechanics::{angle_from_pressure_deg, pressure_and_slope, pressure_from_angle_kpa};
use model_core::inverse::{self, BEND_LIMIT, PRESSURE_LIMIT, Tabulated};
use model_core::units::{Bend, Coefficients, Pressure};

/// 2⁻¹⁶ of a kPa or of a degree: the last bit of every input and result.
pub const LSB: f64 = 1.0 / 65_536.0;

/// Up to here the finger works, kPa.
pub const WORKING_LIMIT_KPA: f64 = 150.0;

/// From here on, and for errors up to [`FIRST_ORDER_ERROR_DEG`], a bend's error is taken from the pressure's; see
/// [`bend_error_deg`].
const FIRST_ORDER_FROM_DEG: f64 = 0.1;
const FIRST_ORDER_ERROR_DEG: f64 = 2e-5;

/// The functions, at one calibration. A line each.
#[must_use]
pub fn subjects(calibration: &Coefficients) -> Vec<Subject> {
    let c = *calibration;
    let bends = Tabulated::new(&c);
    let pressures = bends.clone();
    vec![
        Subject::bend("inverse::bend_from_pressure", c, BEND_BOUND, move |p| inverse::bend_from_pressure(&c, p)),
        Subject::pressure("inverse::pressure_from_bend", c, PRESSURE_BOUND, move |b| {
            inverse::pressure_from_bend(&c, b)
        }),
        Subject::bend("inverse::Tabulated::bend_from_pressure", c, BEND_BOUND, move |p| bends.bend_from_pressure(p)),
        Subject::pressure("inverse::Tabulated::pressure_from_bend", c, PRESSURE_BOUND, move |b| {
            pressures.pressure_from_bend(b)
        }),
    ]
}

/// Half an LSB of rounding is 7.6e-6 degree; two more are what three of Newton's steps leave, between 8 and 64 degrees.
pub const BEND_BOUND: Bound = Bound { absolute: 5e-5, relative: 0.0 };

/// Half an LSB of rounding, and what the formats make of large pressures: a segment's leave room for the stiffest finger,
/// so that a soft one has fewer bits, and near the pole the last bit of a pressure of 30 000 kPa is 1e-4.
pub const PRESSURE_BOUND: Bound = Bound { absolute: 5e-5, relative: 1.0 / 262_144.0 };

/// The most that a result may be off: `absolute + relative · |exact|`, in the result's unit.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// kPa or degrees.
    pub absolute: f64,
    /// In proportion to the exact value.
    pub relative: f64,
}

/// Which way a function goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// kPa in, degrees out.
    BendFromPressure,
    /// Degrees in, kPa out.
    PressureFromBend,
}

impl Direction {
    /// Unit of the inputs.
    #[must_use]
    pub const fn input_unit(self) -> &'static str {
        match self {
            Self::BendFromPressure => "kPa",
            Self::PressureFromBend => "deg",
        }
    }

    /// Unit of the results.
    #[must_use]
    pub const fn result_unit(self) -> &'static str {
        match self {
            Self::BendFromPressure => "deg",
            Self::PressureFromBend => "kPa",
        }
    }

    /// The last input of the domain, which starts at 0: 1000 kPa, 170 degrees.
    #[must_use]
    pub const fn domain_end(self) -> i32 {
        match self {
            Self::BendFromPressure => PRESSURE_LIMIT.to_bits(),
            Self::PressureFromBend => BEND_LIMIT.to_bits(),
        }
    }
}

/// A function at a calibration, as bits to bits, with its domain and its bound.
pub struct Subject {
    /// Such as `inverse::bend_from_pressure`.
    pub name: &'static str,
    /// Which way it goes; this decides domain and reference.
    pub direction: Direction,
    /// k, c1, c2 in kPa.
    pub calibration_kpa: [f64; 3],
    /// What is asked of it in the domain.
    pub bound: Bound,
    evaluate: Box<dyn Fn(i32) -> i32 + Sync>,
}

impl Subject {
    /// A function from pressure to bend.
    pub fn bend(
        name: &'static str,
        calibration: Coefficients,
        bound: Bound,
        function: impl Fn(Pressure) -> Bend + Sync + 'static,
    ) -> Self {
        Self {
            name,
            direction: Direction::BendFromPressure,
            calibration_kpa: calibration.to_f64_kpa(),
            bound,
            evaluate: Box::new(move |bits| function(Pressure::from_bits(bits)).to_bits()),
        }
    }

    /// A function from bend to pressure.
    pub fn pressure(
        name: &'static str,
        calibration: Coefficients,
        bound: Bound,
        function: impl Fn(Bend) -> Pressure + Sync + 'static,
    ) -> Self {
        Self {
            name,
            direction: Direction::PressureFromBend,
            calibration_kpa: calibration.to_f64_kpa(),
            bound,
            evaluate: Box::new(move |bits| function(Bend::from_bits(bits)).to_bits()),
        }
    }

    /// The function itself.
    #[must_use]
    pub fn evaluate(&self, bits: i32) -> i32 {
        (self.evaluate)(bits)
    }

    /// What inputs outside the domain must give: nothing below 0, the value at the domain's end beyond it. None inside.
    fn expected_outside(&self, bits: i32, value_at_end: i32) -> Option<i32> {
        if bits < 0 {
            Some(0)
        } else if bits > self.direction.domain_end() {
            Some(value_at_end)
        } else {
            None
        }
    }

    /// Error of a result in the domain, in the result's unit, and the exact value (of a bend to first order).
    fn error(&self, bits: i32, result: i32) -> Judged {
        let (input, found) = (f64::from(bits) * LSB, f64::from(result) * LSB);
        match self.direction {
            Direction::BendFromPressure => {
                let error = bend_error_deg(&self.calibration_kpa, input, found);
                Judged { error, exact: found - error, working: input <= WORKING_LIMIT_KPA }
            }
            Direction::PressureFromBend => {
                let exact = pressure_from_angle_kpa(&self.calibration_kpa, input).min(Pressure::MAX.to_f64());
                Judged { error: found - exact, exact, working: exact <= WORKING_LIMIT_KPA }
            }
        }
    }
}

/// One result held against the reference.
struct Judged {
    error: f64,
    exact: f64,
    /// Whether the pressure lies in the working range.
    working: bool,
}

/// Error in degrees of the bend `found_deg` at a pressure, whose exact value is never above the model's limit.
///
/// To solve the model anew for each of 65 million pressures would take most of the time. Instead the pressure at the
/// found bend is compared with the given one: the error e is their difference over the slope, but for a second-order
/// term e² P''/(2 P'). P''/P' is at most 1/α (α in radians) up to mid-range and 4/(π − α) towards the pole. From 0.1
/// degree on and for an error of at most 2e-5 degree that is below 2e-9 degree; all other results are held against the
/// solution itself.
fn bend_error_deg(coefficients: &[f64; 3], pressure_kpa: f64, found_deg: f64) -> f64 {
    let limit = BEND_LIMIT.to_f64();
    if found_deg >= FIRST_ORDER_FROM_DEG && found_deg < limit {
        let (pressure, slope) = pressure_and_slope(coefficients, found_deg.to_radians());
        let error = ((pressure - pressure_kpa) / slope).to_degrees();
        if error.abs() <= FIRST_ORDER_ERROR_DEG && found_deg - error < limit {
            return error;
        }
    }
    found_deg - angle_from_pressure_deg(coefficients, pressure_kpa).min(limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::calibration::DEFAULT;

    /// The shortcut gives what solving the model gives.
    #[test]
    fn the_first_order_error_is_the_error() {
        for [k, c1, c2] in [DEFAULT.to_f64_kpa(), [0.0, 5.0, 0.0], [60.0, 40.0, 2.0]] {
            for step in 1..2000 {
                let pressure = f64::from(step * step) * 3.7e-5;
                let exact = angle_from_pressure_deg(&[k, c1, c2], pressure);
                for off in [-1.9e-5, -7e-6, 0.0, 7e-6, 1.9e-5, 0.3] {
                    let error = bend_error_deg(&[k, c1, c2], pressure, exact + off);
                    assert!((error - off).abs() < 2e-9, "{pressure} kPa, off by {off}: {error}");
                }
            }
        }
    }
}
