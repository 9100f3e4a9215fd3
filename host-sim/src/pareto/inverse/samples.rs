//! Where the methods are looked at.

use crate::methods::Direction;

/// The resolution of the fixed-point formats.
pub const LSB: f64 = 1.0 / 65_536.0;

/// The end of the domain in the input's unit.
pub const fn limit(direction: Direction) -> f64 {
    match direction {
        Direction::BendFromPressure => 1000.0,
        Direction::PressureFromBend => 170.0,
    }
}

/// Every place at which one of the tables has a segment's end: multiples of 0.5 kPa or of a twelfth of a degree, floating
/// segments with up to 128 an octave, of the input and of 180 degrees less the bend.
pub fn ends(direction: Direction) -> Vec<f64> {
    let limit = limit(direction);
    let step = if direction == Direction::BendFromPressure { 0.5 } else { 1.0 / 12.0 };
    let uniform = (1..=(limit / step) as u32).map(|i| f64::from(i) * step);
    let floating = (0..26).flat_map(|octave| (128..256).map(move |i| f64::from(i << octave) / 128.0 * LSB));
    let mut ends: Vec<f64> = uniform.chain(floating.clone()).collect();
    if direction == Direction::PressureFromBend {
        ends.extend(floating.map(|rest| 180.0 - rest));
    }
    // On the fixed-point grid, a third of a degree rounded to it.
    let mut ends: Vec<f64> = ends.into_iter().map(|end| (end / LSB).ceil() * LSB).collect();
    ends.retain(|end| (LSB..=limit).contains(end));
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    ends
}

/// The first bits, a uniform and a logarithmic grid, all ends of segments and their neighbours, on the fixed-point grid.
pub fn all(direction: Direction) -> Vec<f64> {
    let limit = limit(direction);
    let mut inputs: Vec<f64> = (0..=512).map(|bits| f64::from(bits) * LSB).collect();
    inputs.extend((1..=7000).map(|i| limit * f64::from(i) / 7000.0));
    // The working range again.
    inputs.extend((1..=3000).map(|i| limit * 0.15 * f64::from(i) / 3000.0));
    inputs.extend((0..2000).map(|i| LSB * (limit / LSB).powf(f64::from(i) / 2000.0)));
    inputs.extend(ends(direction).into_iter().flat_map(|end| [end - LSB, end, end + LSB]));
    for input in &mut inputs {
        *input = (*input / LSB).round() * LSB;
    }
    inputs.retain(|input| (0.0..=limit).contains(input));
    inputs.sort_by(f64::total_cmp);
    inputs.dedup();
    inputs
}

/// For timing: spread over the working range, in an order that no branch predictor can learn.
pub fn timed(direction: Direction, count: usize) -> Vec<f64> {
    let range = if direction == Direction::BendFromPressure { 150.0 } else { 110.0 };
    // Multiples of the golden ratio's fraction fill the range evenly, never twice in a place.
    (1..=count).map(|i| range * (i as f64 * 0.618_033_988_749_895).fract()).collect()
}
