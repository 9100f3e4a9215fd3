//! One step of the inverse: the change of the bends that a straight line through the present posture asks for.

use super::arc::RADIAN;
use super::forward::{Pose, Vector};
use crate::actuation::PerSegment;

/// The largest change that a quotient can give, 4 rad.
const MOST: i64 = 1 << 30;

/// What a step aims at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    /// How far the fingertip has to go, 2⁻¹⁶ mm.
    pub error: Vector,
    /// The change that the bends would make if the place were free, rad in Q28.
    pub pull: PerSegment<i64>,
    /// Added to the square of each singular value, mm² in Q32: how little a step trusts directions that hardly move.
    pub damping: i64,
    /// The largest bend, rad in Q28; the smallest is 0.
    pub limit: i64,
}

/// The change of the bends, rad in Q28, that keeps each within its limits.
///
/// With all three free one degree of freedom is left, and the pull decides about it. A joint that would leave its range
/// is held at its limit, the one furthest outside first, and the others are solved anew.
pub(super) fn step(pose: &Pose, at: &PerSegment<i32>, aim: &Aim) -> PerSegment<i64> {
    let mut held = [None; 3];
    for _ in 0..3 {
        let change = solve(&pose.slopes, &held, aim);
        let mut worst = (0, None);
        for (((slot, change), &at), index) in held.iter().zip(change).zip(at).zip(0_usize..) {
            let (low, high) = (-i64::from(at), aim.limit - i64::from(at));
            let excess = (low - change).max(change - high);
            if slot.is_none() && excess > worst.0 {
                worst = (excess, Some((index, change.min(high).max(low))));
            }
        }
        let Some((index, end)) = worst.1 else { return change };
        if let Some(slot) = held.get_mut(index) {
            *slot = Some(end);
        }
    }
    held.map(|end| end.unwrap_or(0))
}

/// A slope times a change: 2⁻¹⁶ mm.
fn moved([x, y]: Vector, change: i64) -> Vector {
    [(x * change) >> 28, (y * change) >> 28]
}

/// Damped least squares over the joints that are not held.
fn solve(slopes: &PerSegment<Vector>, held: &PerSegment<Option<i64>>, aim: &Aim) -> PerSegment<i64> {
    let free = held.iter().filter(|end| end.is_none()).count();
    let pull = if free == 3 { aim.pull } else { [0; 3] };
    let mut rest = aim.error;
    let [mut xx, mut xy, mut yy] = [aim.damping, 0, aim.damping];
    for ((&slope, end), &pull) in slopes.iter().zip(held).zip(&pull) {
        let [x, y] = slope;
        let [dx, dy] = moved(slope, end.unwrap_or(pull));
        let [rest_x, rest_y] = rest;
        rest = [rest_x - dx, rest_y - dy];
        if end.is_none() {
            [xx, xy, yy] = [xx + x * x, xy + x * y, yy + y * y];
        }
    }
    let [rest_x, rest_y] = within(rest, 28).0;
    // One joint alone: its matrix has only the damping in the other direction.
    if free == 1 {
        let damping = aim.damping;
        return combined(slopes, held, &pull, |[x, y]| quotient(x * rest_x + y * rest_y, x * x + y * y + damping, 28));
    }
    let scale = excess_bits(xx.max(yy), 30);
    let [xx, xy, yy] = [xx >> scale, xy >> scale, yy >> scale];
    let determinant = xx * yy - xy * xy;
    if determinant <= 0 {
        return held.map(|end| end.unwrap_or(0));
    }
    let ([z_x, z_y], shrunk) = within([yy * rest_x - xy * rest_y, xx * rest_y - xy * rest_x], 34);
    combined(slopes, held, &pull, |[x, y]| {
        quotient(x * z_x + y * z_y, determinant, 28 + shrunk.cast_signed() - scale.cast_signed())
    })
}

/// The held joints' changes, and for the others the pull and what is solved.
fn combined(
    slopes: &PerSegment<Vector>,
    held: &PerSegment<Option<i64>>,
    pull: &PerSegment<i64>,
    solved: impl Fn(Vector) -> i64,
) -> PerSegment<i64> {
    let mut change = [0; 3];
    for ((change, &slope), (end, pull)) in change.iter_mut().zip(slopes).zip(held.iter().zip(pull)) {
        *change = end.unwrap_or_else(|| pull + solved(slope));
    }
    change
}

/// By how many bits a value is longer than this.
fn excess_bits(value: i64, bits: u32) -> u32 {
    (64 - value.unsigned_abs().leading_zeros()).saturating_sub(bits)
}

/// The vector, shortened until both parts have at most so many bits, and by how many bits it was.
fn within([x, y]: Vector, bits: u32) -> (Vector, u32) {
    let shift = excess_bits(x, bits).max(excess_bits(y, bits));
    ([x >> shift, y >> shift], shift)
}

/// numerator / denominator · 2^shift, for a denominator above 0, cut at [`MOST`]. In 64 bits: a numerator without room for
/// the shift leaves the rest of it to the denominator.
fn quotient(numerator: i64, denominator: i64, shift: i32) -> i64 {
    let room = numerator.unsigned_abs().leading_zeros().cast_signed() - 1;
    let own = shift.min(room);
    let numerator = if own < 0 { numerator >> own.unsigned_abs().min(63) } else { numerator << own };
    let denominator = denominator >> (shift - own).unsigned_abs().min(63);
    let cut = if numerator < 0 { -MOST } else { MOST };
    numerator.checked_div(denominator).map_or(cut, |value| value.clamp(-MOST, MOST))
}

/// Halved until no joint changes by more than half a radian, beyond which the straight line says little; with the largest
/// change that is left.
pub(super) fn tamed(change: PerSegment<i64>) -> (PerSegment<i64>, i64) {
    let most = change.into_iter().map(i64::abs).fold(0, i64::max);
    let halvings = excess_bits(most / i64::from(RADIAN / 2), 0);
    (change.map(|change| change >> halvings), most >> halvings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_keep_their_digits_whatever_the_sizes() {
        for (numerator, denominator, shift) in [
            (1_i64, 3_i64, 28),
            (-1, 3, 28),
            (1 << 60, (1 << 60) + 12_345, 28),
            (-(1 << 55) - 999, 1 << 58, 30),
            (12_345, 1 << 40, 50),
            (1 << 61, 1 << 40, -10),
            (3, 1 << 20, -5),
        ] {
            let exact = numerator as f64 / denominator as f64 * 2_f64.powi(shift);
            let found = quotient(numerator, denominator, shift) as f64;
            assert!(
                (found - exact).abs() <= 1.0 + 1e-8 * exact.abs(),
                "{numerator} {denominator} {shift}: {found} {exact}"
            );
        }
        assert_eq!([quotient(5, 1, 40), quotient(-5, 1, 40), quotient(1 << 62, 1, 63)], [MOST, -MOST, MOST]);
    }

    #[test]
    fn a_long_step_is_halved_to_half_a_radian() {
        let half = i64::from(RADIAN / 2);
        assert_eq!(tamed([half - 1, 0, 0]), ([half - 1, 0, 0], half - 1));
        let (change, most) = tamed([-8 * half, half, 4]);
        assert!(most <= half && change[0] == -most && change[1] > 0, "{change:?}");
    }
}
