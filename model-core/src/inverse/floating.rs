//! A function on floating segments: the leading bit of the input picks the octave, the next ones the segment, and a quartic
//! does the rest. Relative accuracy is the same from the first LSB to the last octave.

use super::direct::plus_high;
use core::f64::consts::FRAC_1_SQRT_2;

/// 1/√2 in Q31.
const ROOT_HALF_Q31: i64 = (FRAC_1_SQRT_2 * (1u64 << 31) as f64) as i64;

/// Coefficients of a quartic in the offset from a segment's middle, in half widths.
const COEFFICIENTS: usize = 5;

/// Octaves of an input below 2²⁴.
pub(super) const OCTAVES: usize = 24;

/// One octave of the input: where its segments lie, and the format of what they give.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
struct Octave {
    /// To be added to the input's leading bits to give the segment; wraps.
    base: i16,
    /// Input bits within a segment.
    shift: u8,
    /// Bits of the result beyond the output's and one more.
    surplus: u8,
}

/// The quartics of N segments.
#[derive(Clone, Debug)]
pub(super) struct Floating<const N: usize> {
    /// Inputs from here on lie beyond the segments.
    end: u32,
    /// The output at `end` − 1.
    pub last: i32,
    /// Indexed by the input's leading zeros.
    octaves: [Octave; 32],
    segments: [[i32; COEFFICIENTS]; N],
}

impl<const N: usize> Floating<N> {
    /// Tabulates `exact`, a non-decreasing function of an input with 8 more fractional bits than the table's, whose result has
    /// `fraction_bits` more than the output.
    ///
    /// `splits` has the binary logarithm of the number of segments of each octave; segments that do not fit into N, those
    /// from `end` on, and those where the result exceeds `most` are left out: [`Self::end`] says where.
    pub fn tabulate(
        exact: impl Fn(u32) -> i64,
        fraction_bits: u32,
        splits: &[u8; OCTAVES],
        end: u32,
        most: i64,
    ) -> Self {
        let mut table = Self { end: 1, last: 0, octaves: [Octave::default(); 32], segments: [[0; COEFFICIENTS]; N] };
        // The end of the last octave has one bit too many.
        let at = |input: u32| exact(u32::try_from(u64::from(input) << 8).unwrap_or(u32::MAX));
        let mut count = 0;
        'all: for (octave, &split) in (0_u32..).zip(splits) {
            let shift = octave.saturating_sub(u32::from(split));
            let (first, after) = (1_u32 << octave, (2_u32 << octave).min(end));
            if first >= after {
                break;
            }
            // The largest value of the octave takes 30 bits, so that no coefficient takes more than 32.
            let largest = at(after).min(most).unsigned_abs();
            let spare = largest.leading_zeros() as i32 - 34;
            // Output bits, and the one that rounds, stay within the word.
            let scale = spare.min(31 - fraction_bits as i32).max(1 - fraction_bits as i32);
            let scaled = |value: i64| if scale >= 0 { value << scale } else { value >> -scale };
            table.octaves[(31 - octave) as usize & 31] = Octave {
                base: (count as i32 - (first >> shift) as i32) as i16,
                shift: shift as u8,
                surplus: (fraction_bits as i32 + scale - 1) as u8,
            };
            let mut start = first;
            let mut left = at(start);
            while start < after {
                let width = 1_u32 << shift;
                let right = at(start + width);
                let Some(segment) = table.segments.get_mut(count).filter(|_| right <= most) else { break 'all };
                // The Chebyshev-Lobatto points of the segment but its ends.
                let near = ((u64::from(width << 8) * (ROOT_HALF_Q31 as u64)) >> 32) as u32;
                let middle = (start << 8) + (width << 7);
                *segment =
                    quartic([left, exact(middle - near), exact(middle), exact(middle + near), right].map(scaled));
                left = right;
                count += 1;
                start += width;
                table.end = start;
            }
        }
        table.last = table.at(table.end - 1).unwrap_or(0);
        table
    }

    /// The output; `None` for an input that is not above zero, or beyond the segments.
    #[inline(always)]
    pub fn at(&self, input: u32) -> Option<i32> {
        if input.wrapping_sub(1) >= self.end.wrapping_sub(1) {
            return None;
        }
        let octave = self.octaves[(input.leading_zeros() & 31) as usize];
        let leading = input >> (octave.shift & 31);
        let [c0, c1, c2, c3, c4] = *self.segments.get(leading.wrapping_add(octave.base as u32) as usize)?;
        // −1..1 in Q31 across the segment.
        let x = (((input << (31 - (octave.shift & 31))) << 1) ^ 0x8000_0000) as i32;
        let value = plus_high(c0, plus_high(c1, plus_high(c2, plus_high(c3, c4, x), x), x), x);
        Some(((value >> (octave.surplus & 31)) + 1) >> 1)
    }
}

/// The quartic through the values at −1, −1/√2, 0, 1/√2 and 1; the coefficient of the j-th power times 2ʲ, because a
/// product's upper half is half of it.
fn quartic([y0, y1, y2, y3, y4]: [i64; 5]) -> [i32; COEFFICIENTS] {
    let ends = y4 + y0 - 2 * y2;
    let inner = y3 + y1 - 2 * y2;
    let slope = ((y3 - y1) * ROOT_HALF_Q31 + (1 << 30)) >> 31;
    let c4 = ends - 2 * inner;
    let c3 = (y4 - y0) - 2 * slope;
    // Twice c2 and twice c1, whose halves the powers of two take in.
    let c2 = 4 * inner - ends;
    let c1 = 4 * slope - (y4 - y0);
    [y2 as i32, c1 as i32, (2 * c2) as i32, (8 * c3) as i32, (16 * c4) as i32]
}
