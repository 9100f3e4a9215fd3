//! The inputs: all of them are exact in I16F16, f32 and f64, so that every method gets the same.

use super::Direction;
use host_sim::mechanics::{angle_from_pressure_deg, pressure_from_angle_kpa};
use model_core::inverse::{BEND_LIMIT, PRESSURE_LIMIT};

/// Working range in kPa: what the finger is driven with.
pub const WORKING_KPA: f64 = 150.0;

/// One LSB of I16F16.
const LSB: f64 = 1.0 / 65_536.0;

/// The end of the domain, kPa or degrees.
pub fn domain_end(direction: Direction) -> f64 {
    match direction {
        Direction::Bend => PRESSURE_LIMIT.to_f64(),
        Direction::Pressure => BEND_LIMIT.to_f64(),
    }
}

/// The end of the working range for k, c1, c2 in kPa, in the direction's input, kPa or degrees.
pub fn working_end(direction: Direction, coefficients: &[f64; 3]) -> f64 {
    match direction {
        Direction::Bend => WORKING_KPA,
        Direction::Pressure => angle_from_pressure_deg(coefficients, WORKING_KPA).min(domain_end(direction)),
    }
}

/// Down to what f32 represents: 24 bits.
fn exact(value: f64) -> f64 {
    let step = if value < 256.0 { LSB } else { 4.0 * LSB };
    (value / step).floor() * step
}

/// `count` inputs from 0 to `end`, evenly and without a period that a table's could match: the fractions of multiples
/// of the golden ratio.
pub fn even(count: u32, end: f64) -> impl Iterator<Item = f64> {
    const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
    (1..=u64::from(count)).map(move |index| {
        let fraction = index.wrapping_mul(GOLDEN) as f64 / 2_f64.powi(64);
        exact(fraction * end)
    })
}

/// Where it is hard: zero, the first 64 LSBs, `count` from one LSB to `end` at even ratios, and both sides of `end`.
pub fn hard(count: u32, end: f64) -> impl Iterator<Item = f64> {
    let ratio = (end / LSB).powf(1.0 / f64::from(count));
    let first = (0..=64).map(|bits| f64::from(bits) * LSB);
    let spaced = (0..count).map(move |index| exact(LSB * ratio.powf(f64::from(index))));
    first.chain(spaced).chain([exact(end) - 4.0 * LSB, exact(end)])
}

/// A little below and above where segments of the bend may end, at every second degree: there a search may have to look
/// twice.
pub fn joints(direction: Direction, coefficients: &[f64; 3]) -> impl Iterator<Item = f64> {
    let ends = (1..85).map(|pair| 2.0 * f64::from(pair)).map(move |degrees| match direction {
        Direction::Bend => pressure_from_angle_kpa(coefficients, degrees),
        Direction::Pressure => degrees,
    });
    let domain = domain_end(direction);
    ends.filter(move |&end| end < domain)
        .flat_map(|end| [-16.0, -4.0, -1.0, 0.0, 1.0].map(|bits| exact(end) + bits * 4.0 * LSB))
}
