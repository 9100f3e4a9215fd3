//! Angles in radians with 28 fractional bits, their sine and cosine, and the chord of an arc.

use crate::units::Bend;
use core::f64::consts::PI;

/// One radian.
pub(super) const RADIAN: i32 = 1 << 28;
/// 2⁻¹⁶ degree in radians, in Q28 with 24 more bits.
const RADIANS_OF_BIT: i64 = (PI / 180.0 * (1_u64 << 36) as f64 + 0.5) as i64;
/// A radian in 2⁻¹⁶ degree, of Q28 with 30 more bits.
const BITS_OF_RADIAN: i64 = (180.0 / PI * (1_u64 << 18) as f64 + 0.5) as i64;
/// A radian of Q28 in 2⁻³² turn, with 28 more bits.
const PHASE_OF_RADIAN: i64 = (1.0 / (2.0 * PI) * (1_u64 << 32) as f64 + 0.5) as i64;

/// (−1)ᵏ/(2k + 1)! in Q30, the series of sinc in the square of its argument. Up to 1.5 rad the coefficients' rounding makes 1e-7
/// at most, more than what follows.
const SINC: [i64; 7] = {
    let mut terms = [0; 7];
    let (mut k, mut term) = (0, 1.0);
    while k < 7 {
        terms[k] = (term * (1_u64 << 30) as f64 + if term < 0.0 { -0.5 } else { 0.5 }) as i64;
        k += 1;
        term /= -((2 * k * (2 * k + 1)) as f64);
    }
    terms
};

/// Rounded to 2.7e-9 rad.
pub(super) fn radians(bend: Bend) -> i32 {
    ((i64::from(bend.to_bits()) * RADIANS_OF_BIT + (1 << 23)) >> 24) as i32
}

/// Rounded to 2⁻¹⁶ degree.
pub(super) fn bend(radians: i32) -> Bend {
    Bend::from_bits(((i64::from(radians) * BITS_OF_RADIAN + (1 << 29)) >> 30) as i32)
}

/// Cosine and sine in Q31, to 9e-6, of the sum of angles in radians.
pub(super) fn direction(radians: i64) -> [i64; 2] {
    let phase = ((radians * PHASE_OF_RADIAN) >> 28) as i32;
    let (cos, sin) = idsp::cossin(phase);
    [i64::from(cos), i64::from(sin)]
}

/// sinc(α/2) in Q30, and its slope by α in Q30 per radian; α up to 170 degrees.
pub(super) fn sinc_of_half(radians: i32) -> (i64, i64) {
    let half = i64::from(radians) >> 1;
    // Q30, below 2.3.
    let square = (half * half) >> 26;
    let (mut value, mut slope) = (0, 0);
    for term in SINC.into_iter().rev() {
        // Horner, and the derivative beside it.
        slope = ((slope * square) >> 30) + value;
        value = ((value * square) >> 30) + term;
    }
    // d/dα S(α²/4) = S'(α²/4) · α/2
    (value, (slope * half) >> 28)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_is_the_same_bend() {
        for bits in (-(400 << 16)..=400 << 16).step_by(9973) {
            assert_eq!(bend(radians(Bend::from_bits(bits))).to_bits(), bits);
        }
    }

    #[test]
    fn sinc_and_its_slope_are_those_of_f64() {
        let (mut worst, mut worst_slope) = (0.0_f64, 0.0_f64);
        for bits in (1..=170 << 16).step_by(997) {
            let angle = radians(Bend::from_bits(bits));
            let half = f64::from(angle) / f64::from(RADIAN) / 2.0;
            let (value, slope) = sinc_of_half(angle);
            let scale = f64::from(1 << 30);
            worst = worst.max((value as f64 / scale - half.sin() / half).abs());
            let exact = (half.cos() - half.sin() / half) / half / 2.0;
            worst_slope = worst_slope.max((slope as f64 / scale - exact).abs());
        }
        println!("sinc to {worst:.1e}, its slope to {worst_slope:.1e}");
        assert!(worst < 1e-7 && worst_slope < 1e-6, "{worst} {worst_slope}");
    }
}
