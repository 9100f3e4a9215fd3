//! Cubics on floating segments of an f32: the exponent chooses the octave, the leading bits of the significand the segment.

use super::remez::{GRID, grid, minimax};

/// A cubic in the distance from the segment's lower end.
pub type Cubic = [f32; 4];

/// How the segments lie: octave by octave, a power of two of them each.
#[derive(Debug)]
pub struct Segments<const OCTAVES: usize> {
    /// The biased exponent of the first octave.
    first: u32,
    bits: [u8; OCTAVES],
    /// The index of the octave's first segment.
    base: [i16; OCTAVES],
    count: usize,
}

impl<const OCTAVES: usize> Segments<OCTAVES> {
    /// Octaves from 2^`exponent` on with the number of segments as a power of two, of which those from `smallest` to
    /// `largest` are counted; both positive.
    pub const fn new(exponent: i32, bits: [u8; OCTAVES], smallest: f32, largest: f32) -> Self {
        let mut base = [0; OCTAVES];
        let mut next = -(((smallest.to_bits() & 0x7F_FFFF) >> (23 - bits[0])) as i16);
        let mut i = 0;
        while i < OCTAVES {
            base[i] = next;
            next += 1 << bits[i];
            i += 1;
        }
        let last = (largest.to_bits() - 1) & 0x7F_FFFF;
        let count = (last >> (23 - bits[OCTAVES - 1])) as i16 + base[OCTAVES - 1] + 1;
        Self { first: (127 + exponent) as u32, bits, base, count: count as usize }
    }

    /// How many segments there are.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// The index of the segment and its lower end; `None` below the first octave.
    fn place(&self, input: f32) -> Option<(usize, f32)> {
        let bits = input.to_bits();
        let octave = (bits >> 23).checked_sub(self.first)? as usize;
        let shift = 23 - u32::from(*self.bits.get(octave)?);
        let index = ((bits & 0x7F_FFFF) >> shift) as i32 + i32::from(*self.base.get(octave)?);
        let low = f32::from_bits(bits >> shift << shift);
        Some((usize::try_from(index).ok()?, low))
    }

    /// The cubic of the segment of `input`, which is positive; the last one's for what lies beyond; `None` below the first.
    pub fn evaluate(&self, cubics: &[Cubic], input: f32) -> Option<f32> {
        let (index, low) = self.place(input)?;
        let [c0, c1, c2, c3] = cubics.get(index)?;
        let offset = input - low;
        Some(c0 + offset * (c1 + offset * (c2 + offset * c3)))
    }

    /// Fills in the best cubics.
    pub fn table(&self, smallest: f32, cubics: &mut [Cubic], of: impl Fn(f64) -> f64) {
        let points = grid();
        let mut low = smallest;
        for cubic in cubics.iter_mut() {
            let Some(octave) = (low.to_bits() >> 23).checked_sub(self.first) else { return };
            let Some(&bits) = self.bits.get(octave as usize) else { return };
            let high = f32::from_bits(low.to_bits() + (1 << (23 - bits)));
            *cubic = best(&points, f64::from(low), f64::from(high), &of).map(|c| c as f32);
            low = high;
        }
    }
}

/// The best cubic of low..high in the distance from `low`.
pub fn best(points: &[f64; GRID], low: f64, high: f64, of: impl Fn(f64) -> f64) -> [f64; 4] {
    let half = (high - low) / 2.0;
    let [a, b, c, d] = minimax(points, &points.map(|x| of(low + (x + 1.0) * half)));
    // u = x/half − 1.
    let [b, c, d] = [b / half, c / (half * half), d / (half * half * half)];
    let h = half;
    [a - h * (b - h * (c - h * d)), b - h * (2.0 * c - 3.0 * h * d), c - 3.0 * h * d, d]
}
