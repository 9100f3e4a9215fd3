//! Both directions for coefficients given with the call: nothing is prepared, nothing is kept.
//!
//! P(α) = k·α + c1·A + c2·B is linear in its coefficients, and so are the quintics of a segment: six multiplications
//! by c1 and six by c2 give the quintic of *this* finger on this segment. Forward it is evaluated; inverse it is solved by
//! Newton's steps, from the chord between the segment's ends. Five comparisons with the pressures at the segments'
//! starts find the segment.

use super::segments::{
    COEFFICIENTS, END, ENTRIES, FIRST_FRACTION_BITS, MOST_FRACTION_BITS, Segment, TABLE, segment_of,
};
use crate::units::Coefficients;

/// End of the model, 170 degrees, in 2⁻²⁴ degree.
pub(super) const ANGLE_LIMIT: u32 = 170 << 24;

/// Degrees to radians in Q37.
const RADIANS_Q37: u32 = (core::f64::consts::PI / 180.0 * (1u64 << 37) as f64 + 0.5) as u32;

/// Bits beyond a segment's format that the last of Newton's steps looks at.
const LAST_BITS: u32 = 6;

/// (a·b) >> 32, one instruction.
#[inline(always)]
const fn high(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 32) as i32
}

/// a + ((b·c) >> 32), one instruction.
#[inline(always)]
const fn plus_high(a: i32, b: i32, c: i32) -> i32 {
    a.wrapping_add(high(b, c))
}

/// The coefficients in the formats in which their products line up.
#[derive(Clone, Copy)]
pub(super) struct Model {
    /// Per degree, Q31.
    k: u32,
    /// Q25.
    c1: i32,
    /// Q30.
    c2: i32,
}

/// A quintic in y, minus half the offset from a segment's start as a share of its width; its constant term is kept apart.
#[derive(Clone, Copy)]
struct Quintic([i32; COEFFICIENTS - 1]);

impl Quintic {
    /// The quintic, less its constant term, over y.
    #[inline(always)]
    fn over_y(&self, y: i32) -> i32 {
        let [c1, c2, c3, c4, c5] = self.0;
        plus_high(c1, plus_high(c2, plus_high(c3, plus_high(c4, c5, y), y), y), y)
    }

    /// The y, from `start` on in so many of Newton's steps, at which the quintic and `excess` are zero together.
    #[inline(always)]
    fn solve(&self, excess: i32, start: i32, steps: u32) -> i32 {
        let [c1, c2, c3, c4, c5] = self.0;
        let mut y = start;
        let mut step = 0;
        while step < steps {
            let p4 = plus_high(c4, c5, y);
            let p3 = plus_high(c3, p4, y);
            let p2 = plus_high(c2, p3, y);
            let p1 = plus_high(c1, p2, y);
            let slope = plus_high(p1, plus_high(p2, plus_high(p3, plus_high(p4, c5, y), y), y), y);
            // The excess over the slope, in 2³²; the reciprocal to some 12 bits, which is what Newton's steps need.
            let reciprocal = (1 << 30) / ((slope >> 12) | 1);
            let length = if step + 1 < steps {
                (i64::from(plus_high(excess, p1, y)) * i64::from(reciprocal)) >> 10
            } else {
                // The last step sees what the others round off: near the pole it is worth more than a bend's LSB.
                let wide = (i64::from(excess) << 32).wrapping_add(i64::from(p1) * i64::from(y));
                (i64::from((wide >> (32 - LAST_BITS)) as i32) * i64::from(reciprocal)) >> (10 + LAST_BITS)
            };
            y = y.saturating_sub(length as i32);
            step += 1;
        }
        y
    }
}

/// The angle in 2⁻²⁴ degree at y on a segment.
#[inline(always)]
fn angle_at(segment: &Segment, y: i32) -> u32 {
    let offset = 0u32.wrapping_sub(y.min(0) as u32);
    segment.start.wrapping_add(offset >> (31u32.wrapping_sub(u32::from(segment.width_bits)) & 31))
}

impl Model {
    #[inline(always)]
    pub(super) const fn new(coefficients: &Coefficients) -> Self {
        // `Coefficients` admits k up to 60, c1 up to 40, and c2 up to 2, where 2³¹ is one more than fits.
        let c2 = coefficients.c2().to_bits();
        Self {
            k: (((coefficients.k().to_bits() as u32) << 2) as u64 * RADIANS_Q37 as u64 >> 32) as u32,
            c1: coefficients.c1().to_bits() << 1,
            c2: (c2 << 6).wrapping_sub(c2 >> 25),
        }
    }

    /// k·α in Q22 at an angle in 2⁻²⁴ degree.
    #[inline(always)]
    const fn bending(&self, angle: u32) -> u32 {
        ((self.k as u64 * angle as u64) >> 33) as u32
    }

    /// P in Q12 kPa, rounded down, at the start of a segment.
    #[inline(always)]
    fn start_q12(&self, segment: &Segment) -> i32 {
        let bending = (self.bending(segment.start) >> 10) as i32;
        plus_high(plus_high(bending, self.c1, segment.a_start), self.c2, segment.b_start)
    }

    /// P at a segment's start in the segment's format.
    #[inline(always)]
    fn start(&self, segment: &Segment) -> i32 {
        let bending = (self.bending(segment.start) >> (segment.fewer_bits & 31)) as i32;
        plus_high(plus_high(bending, self.c1, segment.a[0]), self.c2, segment.b[0])
    }

    /// This finger's quintic on a segment.
    #[inline(always)]
    fn quintic(&self, segment: &Segment) -> Quintic {
        let mut c = [0; COEFFICIENTS - 1];
        let mut i = 0;
        while i < COEFFICIENTS - 1 {
            c[i] = plus_high(high(self.c1, segment.a[i + 1]), self.c2, segment.b[i + 1]);
            i += 1;
        }
        // k over twice the width, Q22: 2⁻²⁴ degree times Q31 less 32 bits, and one that doubles.
        let shift = 32i32.wrapping_sub(i32::from(segment.width_bits)).wrapping_add(i32::from(segment.fewer_bits)) & 31;
        c[0] = c[0].wrapping_sub((self.k >> shift) as i32);
        Quintic(c)
    }

    /// P at an angle in 2⁻²⁴ degree, at most [`ANGLE_LIMIT`]: in Q32 beyond the fractional bits that come with it.
    ///
    /// Non-decreasing, by its rounding within a segment and from one to the next.
    #[inline(always)]
    pub(super) fn pressure(&self, angle: u32) -> (i64, u32) {
        // 170 degrees itself is the end of the last segment.
        let angle = if angle < ANGLE_LIMIT { angle } else { ANGLE_LIMIT - 1 };
        let (index, width_bits) = segment_of(angle);
        let segment = &TABLE[index % ENTRIES];
        // Starts are multiples of the width.
        let y = 0i32.wrapping_sub(((angle << (32 - width_bits)) >> 1) as i32);
        let rise = i64::from(self.quintic(segment).over_y(y)) * i64::from(y);
        let wide = (i64::from(self.start(segment)) << 32).wrapping_add(rise);
        (wide, (MOST_FRACTION_BITS as i32 - i32::from(segment.fewer_bits)) as u32)
    }

    /// The same from Q24 kPa, below 256, whose last bits count near rest.
    #[inline(never)]
    pub(super) fn angle_q24(&self, pressure: u32) -> u32 {
        if pressure < 1 << 22 && (pressure >> 12) < self.start_q12(&TABLE[1]) as u32 {
            self.near_rest_q25(pressure << 1)
        } else {
            self.angle(pressure >> 2)
        }
    }

    /// The angle in 2⁻²⁴ degree at a pressure in Q22 kPa, above 0 and at most 1023; at most [`ANGLE_LIMIT`].
    #[inline(always)]
    pub(super) fn angle(&self, pressure_q22: u32) -> u32 {
        let coarse = (pressure_q22 >> 10) as i32;
        if coarse < self.start_q12(&TABLE[1]) {
            return self.near_rest(pressure_q22);
        }
        // The last segment whose start does not exceed the pressure, in five comparisons.
        let mut index = 0;
        for step in [16, 8, 4, 2, 1] {
            if self.start_q12(&TABLE[index | step]) <= coarse {
                index |= step;
            }
        }
        if index == END {
            return ANGLE_LIMIT;
        }
        // What was compared is rounded down, so that the segment may be one too high.
        let mut segment = &TABLE[index];
        let excess_on = |segment: &Segment| {
            self.start(segment).wrapping_sub((pressure_q22 >> (segment.fewer_bits & 31)) as i32)
        };
        let mut excess = excess_on(segment);
        if excess > 0 {
            if index == 1 {
                return self.near_rest(pressure_q22);
            }
            segment = &TABLE[(index - 1) % ENTRIES];
            excess = excess_on(segment);
        }
        // From the segment's middle three steps leave 1e-5 degree at the most, between 8 and 16 degrees.
        angle_at(segment, self.quintic(segment).solve(excess, -1 << 30, 3))
    }

    /// [`Self::near_rest_q25`], of fewer bits.
    #[inline(always)]
    fn near_rest(&self, pressure_q22: u32) -> u32 {
        self.near_rest_q25(pressure_q22 << (FIRST_FRACTION_BITS - MOST_FRACTION_BITS))
    }

    /// On the first segment, where P is y (c1 + y (c2 + ...)) and its root starts like a square root. From Q25 kPa.
    ///
    /// With y' = 2ˢ y and P' = 4ˢ P the equation keeps its form, its coefficients being c1·2ˢ, c2, c3/2ˢ, ...: so that P'
    /// is 1/32 to 1/4 of c2, and y' nowhere small.
    #[inline(always)]
    pub(super) fn near_rest_q25(&self, pressure: u32) -> u32 {
        let segment = &TABLE[0];
        let Quintic([c1, c2, c3, c4, c5]) = self.quintic(segment);
        let room = pressure.leading_zeros() as i32 - (c2 - (c2 >> 6)).leading_zeros() as i32 - 3;
        // As far as c1 leaves room; where it leaves none, P is linear and y' may be small.
        let s = (room >> 1).max(0).min(c1.wrapping_neg().leading_zeros() as i32 - 2) & 31;
        let scaled = Quintic([c1 << s, c2, c3 >> s, c4 >> s >> s, c5 >> s >> s >> s]);
        let y = scaled.solve(0i32.wrapping_sub((pressure << s << s) as i32), -0x4CCC_CCCC, 4);
        angle_at(segment, y >> s)
    }
}
