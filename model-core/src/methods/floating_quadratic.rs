//! Quadratic interpolation on floating segments (see `floating`): the values at both ends and in the middle.
//!
//! Each segment keeps its lower end's value and d = 4 m − 2 (y₀ + y₁), with m the value in the middle, so that with u from 0
//! to 1 the result is y₀ + u (y₁ − y₀) + u (1 − u) d: three words from two segments, and no jump between them. State:
//! 2036 + 1940 bytes, 2 KiB at most for each direction. The segments are laid out for the working range.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core floating_quadratic -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 2.1e-4 | 1.1e-2 |
//! | bare chamber | 2.3e-4 | 9.1e-3 |
//! | worst corner | 9.2e-4 | 6.6e-3 |

use super::floating::{Layout, Place};
use super::{F64Newton, Method, TABLE_LIMIT_DEG, fixed};
use crate::inverse::{BEND_LIMIT, PRESSURE_LIMIT};
use crate::units::{Bend, Coefficients, Pressure};

/// 1000 kPa in 2⁻¹⁶ kPa.
const MOST_PRESSURE: u32 = PRESSURE_LIMIT.to_bits() as u32;
/// 180 degrees in 2⁻¹⁶ degree.
const POLE: u32 = 180 << 16;
/// 180 degrees less the largest bend.
const LEAST_REST: u32 = POLE - BEND_LIMIT.to_bits() as u32;

const PRESSURES: Layout<26> =
    Layout::new(0, [0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 4, 4, 4, 5, 5, 5, 4, 4], 1, MOST_PRESSURE);
const RESTS: Layout<5> = Layout::new(19, [5, 5, 5, 7, 6], LEAST_REST, POLE);

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct FloatingQuadratic {
    /// Bends in Q22.
    bends: [Node; PRESSURES.count()],
    last_bend: i32,
    /// Pressures in Q16.
    pressures: [Node; RESTS.count()],
    last_pressure: i32,
}

/// A segment's lower end, and its bow.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    value: i32,
    bow: i32,
}

fn interpolate<const OCTAVES: usize>(layout: &Layout<OCTAVES>, nodes: &[Node], last: i32, input: u32) -> i32 {
    let Place { index, offset, shift } = layout.place(input);
    let Some(&Node { value: low, bow }) = nodes.get(index) else { return last };
    let high = nodes.get(index + 1).map_or(last, |node| node.value);
    // u in Q32; a segment is at most 2²⁰ wide.
    let u = u64::from(offset << (32_u32.saturating_sub(shift).min(31))).min(0xFFFF_FFFF) as u32;
    let hump = (u64::from(u) * u64::from(u.wrapping_neg())) >> 33;
    let linear = i64::from(high).wrapping_sub(i64::from(low)).wrapping_mul(i64::from(u)) >> 32;
    let bowed = i64::from(bow).wrapping_mul(hump as i64) >> 31;
    i32::try_from(i64::from(low) + linear + bowed).unwrap_or(i32::MAX)
}

/// The nodes of all segments; returns the value at the last one's upper end.
fn table<const OCTAVES: usize>(
    layout: &Layout<OCTAVES>,
    smallest: u32,
    nodes: &mut [Node],
    of: impl Fn(f64) -> i32,
) -> i32 {
    let mut last = 0;
    layout.for_each(smallest, |index, low, width| {
        let ends = [f64::from(low), f64::from(low + width)];
        let [from, to] = ends.map(&of);
        let middle = of(f64::midpoint(ends[0], ends[1]));
        let bow = 4 * i64::from(middle) - 2 * (i64::from(from) + i64::from(to));
        if let Some(node) = nodes.get_mut(index) {
            *node = Node { value: from, bow: i32::try_from(bow).unwrap_or(0) };
        }
        last = to;
    });
    last
}

impl Method for FloatingQuadratic {
    const NAME: &'static str = "floating-quadratic";
    const SUMMARY: &'static str = "fixed point, floating segments, quadratic interpolation";
    type Pressure = Pressure;
    type Bend = Bend;

    fn prepare(coefficients: &Coefficients) -> Self {
        let exact = F64Newton::prepare(coefficients);
        let mut bends = [Node::default(); PRESSURES.count()];
        let last_bend =
            table(&PRESSURES, 1, &mut bends, |bits| fixed(exact.solve(bits / 65_536.0, TABLE_LIMIT_DEG), 22));
        let mut pressures = [Node::default(); RESTS.count()];
        let last_pressure = table(&RESTS, LEAST_REST, &mut pressures, |bits| {
            fixed(exact.pressure_from_bend(180.0 - bits / 65_536.0), 16)
        });
        Self { bends, last_bend, pressures, last_pressure }
    }

    fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        match u32::try_from(pressure.to_bits()) {
            Ok(bits) if bits > 0 => {
                let bend = interpolate(&PRESSURES, &self.bends, self.last_bend, bits.min(MOST_PRESSURE));
                Bend::from_bits((bend + (1 << 5)) >> 6).min(BEND_LIMIT)
            }
            _ => Bend::ZERO,
        }
    }

    fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        let bits = bend.clamp(Bend::ZERO, BEND_LIMIT).to_bits() as u32;
        let pressure = interpolate(&RESTS, &self.pressures, self.last_pressure, POLE - bits);
        Pressure::from_bits(pressure.max(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check};

    #[test]
    fn errors_against_f64() {
        check::<FloatingQuadratic>(&[
            Limits { bend_deg: 3.2e-4, pressure_kpa: 1.6e-2 },
            Limits { bend_deg: 3.4e-4, pressure_kpa: 1.4e-2 },
            Limits { bend_deg: 1.4e-3, pressure_kpa: 9.9e-3 },
        ]);
    }
}
