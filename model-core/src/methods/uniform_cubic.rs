//! Cubic Hermite interpolation in a table with uniform steps of the input: value and slope at every node.
//!
//! 250 intervals of 4 kPa and 255 of two thirds of a degree. Slopes are limited to 2.85 times the rise of the neighbouring
//! intervals, below the 3 to which a monotone cubic is bound (Fritsch and Carlson, 1980): this takes care of the infinite
//! slope at P = 0 (2.85 levels the error of a square root there to 9 % of the first interval's rise) and of saturation.
//! State: 2008 + 2048 bytes, 2 KiB at most for each direction.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core uniform_cubic -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 1.4e0 | 2.3e-4 |
//! | bare chamber | 8.9e-4 | 1.1e-4 |
//! | worst corner | 2.5e0 | 4.0e-4 |

use super::{F64Newton, Method, TABLE_LIMIT_DEG, fixed};
use crate::inverse::{BEND_LIMIT, PRESSURE_LIMIT};
use crate::units::{Bend, Coefficients, Pressure};

/// An interval of the pressure is 2 to this power of 2⁻¹⁶ kPa.
const PRESSURE_SHIFT: u32 = 18;
/// Intervals in two degrees of bend.
const PER_TWO_DEGREES: u32 = 3;
/// 1000 kPa in intervals.
const PRESSURES: usize = (PRESSURE_LIMIT.to_bits() >> PRESSURE_SHIFT) as usize;
/// 170 degrees in intervals.
const BENDS: usize = ((BEND_LIMIT.to_bits() as u32 * PER_TWO_DEGREES) >> 17) as usize;
/// Of a slope to the rise of a neighbouring interval.
const STEEPEST: f64 = 2.85;

/// Value, and slope per interval.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    value: i32,
    slope: i32,
}

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct UniformCubic {
    /// Q22.
    bends: [Node; PRESSURES + 1],
    /// Q16.
    pressures: [Node; BENDS + 1],
}

/// a·u with u in Q32 below 1.
fn scaled(a: i64, u: u32) -> i64 {
    a.wrapping_mul(i64::from(u)) >> 32
}

/// At `position` in intervals with `shift` fractional bits.
fn interpolate(nodes: &[Node], position: u32, shift: u32) -> i32 {
    let index = (position >> shift) as usize;
    let u = position << (32 - shift);
    let low = nodes.get(index).copied().unwrap_or_default();
    let high = nodes.get(index + 1).copied().unwrap_or(low);
    // y₀ + u (m₀ + u (3 Δ − 2 m₀ − m₁ + u (m₀ + m₁ − 2 Δ))); at most 30 bits and a few, so that products fit.
    let rise = i64::from(high.value) - i64::from(low.value);
    let (from, to) = (i64::from(low.slope), i64::from(high.slope));
    let cubic = from + to - 2 * rise;
    let square = rise - from - cubic;
    let value = i64::from(low.value) + scaled(from + scaled(square + scaled(cubic, u), u), u);
    i32::try_from(value).unwrap_or(i32::MAX)
}

/// Fills `nodes` with values and slopes per interval, the slopes limited.
fn table(nodes: &mut [Node], fraction_bits: u32, of: impl Fn(usize) -> (f64, f64)) {
    let most = f64::from(i32::MAX) / (1_u64 << fraction_bits) as f64;
    let value_at = |index| of(index).0.min(most);
    let last = nodes.len().saturating_sub(1);
    for (index, node) in nodes.iter_mut().enumerate() {
        let (value, slope) = (value_at(index), of(index).1);
        let before = if index > 0 { value - value_at(index - 1) } else { f64::INFINITY };
        let after = if index < last { value_at(index + 1) - value } else { f64::INFINITY };
        let limited = slope.min(STEEPEST * before.min(after));
        *node = Node { value: fixed(value, fraction_bits), slope: fixed(limited, fraction_bits) };
    }
}

impl Method for UniformCubic {
    const NAME: &'static str = "uniform-cubic";
    const SUMMARY: &'static str = "fixed point, uniform table, cubic Hermite interpolation";
    type Pressure = Pressure;
    type Bend = Bend;

    fn prepare(coefficients: &Coefficients) -> Self {
        let exact = F64Newton::prepare(coefficients);
        let mut method = Self { bends: [Node::default(); PRESSURES + 1], pressures: [Node::default(); BENDS + 1] };
        let step = f64::from(1 << PRESSURE_SHIFT) / 65_536.0;
        table(&mut method.bends, 22, |index| {
            let bend = exact.solve(index as f64 * step, TABLE_LIMIT_DEG);
            (bend, exact.slope_deg_per_kpa(bend) * step)
        });
        let step = 2.0 / f64::from(PER_TWO_DEGREES);
        table(&mut method.pressures, 16, |index| {
            let bend = index as f64 * step;
            (exact.pressure_from_bend(bend), exact.slope_kpa_per_deg(bend) * step)
        });
        method
    }

    fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        let bits = pressure.clamp(Pressure::ZERO, PRESSURE_LIMIT).to_bits() as u32;
        Bend::from_bits((interpolate(&self.bends, bits, PRESSURE_SHIFT) + (1 << 5)) >> 6).min(BEND_LIMIT)
    }

    fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        let bits = bend.clamp(Bend::ZERO, BEND_LIMIT).to_bits() as u32;
        Pressure::from_bits(interpolate(&self.pressures, bits.wrapping_mul(PER_TWO_DEGREES), 17))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check};

    #[test]
    fn errors_against_f64() {
        check::<UniformCubic>(&[
            Limits { bend_deg: 2.1e0, pressure_kpa: 3.5e-4 },
            Limits { bend_deg: 1.3e-3, pressure_kpa: 1.7e-4 },
            Limits { bend_deg: 3.8e0, pressure_kpa: 6.0e-4 },
        ]);
    }
}
