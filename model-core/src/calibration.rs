//! The default calibration.
use crate::units::Coefficients;
use fixed::types::I8F24;

/// Fit to the paper's Table 2, chamber with exoskeleton.
pub const DEFAULT: Coefficients = match Coefficients::new(I8F24::ZERO, I8F24::lit("13.84"), I8F24::lit("0.336")) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("the default calibration lies outside the admitted range"),
};
