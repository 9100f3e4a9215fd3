//! The model in both directions.
mod direct;
mod floating;
mod segments;
mod tabulated;

pub use tabulated::Tabulated;

use crate::units::{Bend, Coefficients, Pressure};
use direct::Model;
use {bend_from_pressure as bend_of, pressure_from_bend as pressure_of};

/// Beyond this bend the model's pole at 180 degrees is near and the finger cannot follow: the model ends here.
pub const BEND_LIMIT: Bend = Bend::from_deg(170);

/// Beyond this pressure the inverse saturates: the end of the pressure sensor's range.
pub const PRESSURE_LIMIT: Pressure = Pressure::from_kpa(1000);

/// The bend at which the segment rests under `pressure`.
#[must_use]
pub fn bend_from_pressure(coefficients: &Coefficients, pressure: Pressure) -> Bend {
    let bits = pressure.min(PRESSURE_LIMIT).to_bits();
    if bits <= 0 {
        return Bend::ZERO;
    }
    let angle = Model::new(coefficients).angle((bits as u32) << 6);
    Bend::from_bits(((angle + 128) >> 8) as i32)
}

/// The pressure that holds the segment at `bend`.
#[must_use]
pub fn pressure_from_bend(coefficients: &Coefficients, bend: Bend) -> Pressure {
    let bits = bend.min(BEND_LIMIT).to_bits();
    if bits <= 0 {
        return Pressure::ZERO;
    }
    let (wide, q) = Model::new(coefficients).pressure((bits as u32) << 8);
    // To Q17, then rounded.
    let rounded = ((wide >> (q + 15)) + 1) >> 1;
    Pressure::from_bits(i32::try_from(rounded).unwrap_or(i32::MAX))
}
