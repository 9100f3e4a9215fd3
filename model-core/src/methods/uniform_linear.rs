//! Linear interpolation in a table with uniform steps of the input: the plainest method.
//!
//! 500 intervals of 2 kPa and 510 of a third of a degree, exact at their ends, 2⁻¹⁶ in between. Where the bend rises like
//! a square root, in the first interval, no uniform step is fine enough. State: 2004 + 2044 bytes, 2 KiB at most for each
//! direction.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core uniform_linear -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 2.7e0 | 1.6e-1 |
//! | bare chamber | 3.3e-2 | 1.2e-1 |
//! | worst corner | 4.5e0 | 1.0e-1 |

use super::{F64Newton, Method, TABLE_LIMIT_DEG, fixed};
use crate::inverse::{BEND_LIMIT, PRESSURE_LIMIT};
use crate::units::{Bend, Coefficients, Pressure};

/// An interval of the pressure is 2 to this power of 2⁻¹⁶ kPa.
const PRESSURE_SHIFT: u32 = 17;
/// Intervals a degree of bend.
const PER_DEGREE: u32 = 3;
/// 1000 kPa in intervals.
const PRESSURES: usize = (PRESSURE_LIMIT.to_bits() >> PRESSURE_SHIFT) as usize;
/// 170 degrees in intervals.
const BENDS: usize = ((BEND_LIMIT.to_bits() as u32 * PER_DEGREE) >> 16) as usize;

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct UniformLinear {
    /// Q22.
    bends: [i32; PRESSURES + 1],
    /// Q16.
    pressures: [i32; BENDS + 1],
}

/// At `position` in intervals with `shift` fractional bits.
fn interpolate(values: &[i32], position: u32, shift: u32) -> i32 {
    let index = (position >> shift) as usize;
    let fraction = position & ((1 << shift) - 1);
    let low = values.get(index).copied().unwrap_or(0);
    let high = values.get(index + 1).copied().unwrap_or(low);
    let rise = i64::from(high).wrapping_sub(i64::from(low)).wrapping_mul(i64::from(fraction));
    low.wrapping_add((rise >> shift) as i32)
}

impl Method for UniformLinear {
    const NAME: &'static str = "uniform-linear";
    const SUMMARY: &'static str = "fixed point, uniform table, linear interpolation";
    type Pressure = Pressure;
    type Bend = Bend;

    fn prepare(coefficients: &Coefficients) -> Self {
        let exact = F64Newton::prepare(coefficients);
        let mut method = Self { bends: [0; PRESSURES + 1], pressures: [0; BENDS + 1] };
        let step = f64::from(1 << PRESSURE_SHIFT) / 65_536.0;
        for (index, bend) in method.bends.iter_mut().enumerate() {
            *bend = fixed(exact.solve(index as f64 * step, TABLE_LIMIT_DEG), 22);
        }
        for (index, pressure) in method.pressures.iter_mut().enumerate() {
            *pressure = fixed(exact.pressure_from_bend(index as f64 / f64::from(PER_DEGREE)), 16);
        }
        method
    }

    fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        let bits = pressure.clamp(Pressure::ZERO, PRESSURE_LIMIT).to_bits() as u32;
        Bend::from_bits((interpolate(&self.bends, bits, PRESSURE_SHIFT) + (1 << 5)) >> 6).min(BEND_LIMIT)
    }

    fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        let bits = bend.clamp(Bend::ZERO, BEND_LIMIT).to_bits() as u32;
        Pressure::from_bits(interpolate(&self.pressures, bits.wrapping_mul(PER_DEGREE), 16))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check};

    #[test]
    fn errors_against_f64() {
        check::<UniformLinear>(&[
            Limits { bend_deg: 4.1e0, pressure_kpa: 2.4e-1 },
            Limits { bend_deg: 5.0e-2, pressure_kpa: 1.8e-1 },
            Limits { bend_deg: 6.8e0, pressure_kpa: 1.5e-1 },
        ]);
    }
}
