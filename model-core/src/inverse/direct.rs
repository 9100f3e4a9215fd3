//! Both directions for coefficients given with the call: nothing is prepared, nothing is kept.
//!
//! P(α) = k·α + c1·A + c2·B is linear in its coefficients. Forward the quintics of A and B are evaluated and added up.
//! Inverse, five comparisons with the pressures at the segments' starts find the segment; then six multiplications by c1
//! and six by c2 give the quintic of *this* finger there, and a few of Newton's steps its root.

use super::segments::{COEFFICIENTS, ENTRIES, MOST_FRACTION_BITS, Segment, TABLE, segment_of};
use crate::units::Coefficients;

/// End of the model, 170 degrees, in 2⁻²⁴ degree.
const ANGLE_LIMIT: u32 = 170 << 24;

/// Degrees to radians in Q37.
const RADIANS_Q37: u32 = (core::f64::consts::PI / 180.0 * (1u64 << 37) as f64 + 0.5) as u32;

/// Bits that the first segment, whose pressure stays below 12 kPa, has room for beyond its format.
const FIRST_BITS: u32 = 3;

/// An excess times the reciprocal of a slope, shifted right by this, is in 2³².
const RECIPROCAL_SHIFT: u32 = 10;

/// Bits beyond a segment's format that the last of Newton's steps looks at.
const LAST_BITS: u32 = 6;

/// Where Newton's steps start on a segment: seven sixteenths of the way, because P is convex, so that the first step goes
/// too far, and beyond the right end it stops there.
const START: i32 = -7 << 27;
/// y at the right end of a segment.
const RIGHT_END: i32 = i32::MIN;

/// Where Newton's steps start on the first segment, −0.3: y' lies between −0.18 and −0.5 there.
const FIRST_START: i32 = -0x4CCC_CCCC;

/// (a·b) >> 32, one instruction.
#[inline(always)]
const fn high(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 32) as i32
}

/// a + ((b·c) >> 32), one instruction.
#[inline(always)]
pub(super) const fn plus_high(a: i32, b: i32, c: i32) -> i32 {
    a.wrapping_add(high(b, c))
}

/// A quintic in y, minus half the offset from a segment's start as a share of its width; its constant term is kept apart.
#[derive(Clone, Copy)]
struct Quintic([i32; COEFFICIENTS - 1]);

impl Quintic {
    /// One of Newton's steps from y on towards where the quintic and `excess` are zero together.
    #[inline(always)]
    const fn step(&self, excess: i32, y: i32) -> i32 {
        let (over_y, reciprocal) = self.tangent(y);
        let length = (plus_high(excess, over_y, y) as i64 * reciprocal as i64) >> RECIPROCAL_SHIFT;
        y.saturating_sub(length as i32)
    }

    /// The last step sees what the others round off: near the pole it is worth more than a bend's LSB.
    #[inline(always)]
    const fn last_step(&self, excess: i32, y: i32) -> i32 {
        let (over_y, reciprocal) = self.tangent(y);
        let wide = ((excess as i64) << 32).wrapping_add(over_y as i64 * y as i64);
        let left = (wide >> (32 - LAST_BITS)) as i32;
        let length = (left as i64 * reciprocal as i64) >> (RECIPROCAL_SHIFT + LAST_BITS);
        y.saturating_sub(length as i32)
    }

    /// The quintic over y, and the reciprocal of its slope, to some 10 bits, which is what Newton's steps need.
    #[inline(always)]
    const fn tangent(&self, y: i32) -> (i32, i32) {
        let [c1, c2, c3, c4, c5] = self.0;
        let p4 = plus_high(c4, c5, y);
        let p3 = plus_high(c3, p4, y);
        let p2 = plus_high(c2, p3, y);
        let p1 = plus_high(c1, p2, y);
        let slope = plus_high(p1, plus_high(p2, plus_high(p3, plus_high(p4, c5, y), y), y), y);
        (p1, (1 << 30) / ((slope >> 12) | 1))
    }
}

/// A quintic at y.
#[inline(always)]
const fn value_at(c: &[i32; COEFFICIENTS], y: i32) -> i32 {
    let [c0, c1, c2, c3, c4, c5] = *c;
    plus_high(c0, plus_high(c1, plus_high(c2, plus_high(c3, plus_high(c4, c5, y), y), y), y), y)
}

/// The angle in 2⁻²⁴ degree at y on a segment. A trace of positive y, by rounding, stays within the rounding to a bend.
#[inline(always)]
const fn angle_at(segment: &Segment, y: i32) -> u32 {
    segment.start.wrapping_sub((y >> (segment.angle_shift & 31)) as u32)
}

/// The coefficients in the formats in which their products line up.
#[derive(Clone, Copy)]
pub(super) struct Model {
    /// Per degree, Q30.
    k: u32,
    /// Q25.
    c1: i32,
    /// Q30.
    c2: i32,
}

impl Model {
    #[inline(always)]
    pub(super) const fn new(coefficients: &Coefficients) -> Self {
        // `Coefficients` admits k up to 60, c1 up to 40, and c2 up to 2, where 2³¹ is one more than fits.
        let c2 = coefficients.c2().to_bits();
        let k = (coefficients.k().to_bits() as u32) << 1;
        Self {
            k: ((k as u64 * RADIANS_Q37 as u64) >> 32) as u32,
            c1: coefficients.c1().to_bits() << 1,
            c2: (c2 << 6).wrapping_sub(c2 >> 25),
        }
    }

    /// k·α in Q22 at an angle in 2⁻²⁴ degree.
    #[inline(always)]
    const fn bending(&self, angle: u32) -> u32 {
        ((self.k as u64 * angle as u64) >> 32) as u32
    }

    /// P in Q12 kPa, rounded down, at the start of a segment.
    #[inline(always)]
    const fn start_q12(&self, segment: &Segment) -> i32 {
        let bending = (self.bending(segment.start) >> 10) as i32;
        plus_high(plus_high(bending, self.c1, segment.a_start), self.c2, segment.b_start)
    }

    /// P at a segment's start in the segment's format.
    #[inline(always)]
    const fn start(&self, segment: &Segment) -> i32 {
        let bending = (self.bending(segment.start) >> (segment.fewer_bits & 31)) as i32;
        plus_high(plus_high(bending, self.c1, segment.a[0]), self.c2, segment.b[0])
    }

    /// This finger's quintic on a segment.
    #[inline(always)]
    const fn quintic(&self, segment: &Segment) -> Quintic {
        let mut c = [0; COEFFICIENTS - 1];
        let mut i = 0;
        while i < COEFFICIENTS - 1 {
            c[i] = plus_high(high(self.c1, segment.a[i + 1]), self.c2, segment.b[i + 1]);
            i += 1;
        }
        c[0] = c[0].wrapping_sub((self.k >> (segment.bending_shift & 31)) as i32);
        Quintic(c)
    }

    /// P at an angle in 2⁻²⁴ degree, at most 170 degrees: in Q32 beyond the fractional bits that come with it.
    ///
    /// Non-decreasing: A and B are, by their rounding within a segment and from one to the next, and so is k·α.
    #[inline(always)]
    pub(super) const fn pressure(&self, angle: u32) -> (i64, u32) {
        // 170 degrees itself is the end of the last segment.
        let angle = if angle < ANGLE_LIMIT { angle } else { ANGLE_LIMIT - 1 };
        let (index, width_bits) = segment_of(angle);
        let segment = &TABLE[index % ENTRIES];
        // Starts are multiples of the width.
        let y = 0i32.wrapping_sub(((angle << (32 - width_bits)) >> 1) as i32);
        let [a, b] = [value_at(&segment.a, y), value_at(&segment.b, y)];
        let bending = (self.bending(angle) >> (segment.fewer_bits & 31)) as i32;
        let wide = (self.c1 as i64 * a as i64).wrapping_add(self.c2 as i64 * b as i64);
        (wide.wrapping_add((bending as i64) << 32), MOST_FRACTION_BITS.wrapping_sub(segment.fewer_bits as u32))
    }

    /// The angle in 2⁻²⁴ degree at a pressure in Q22 kPa, above 0 and below 1024; at most 170 degrees.
    ///
    /// Three of Newton's steps leave 2e-5 degree at the most, between 8 and 64 degrees; `MORE` steps leave nothing.
    #[inline(always)]
    pub(super) fn angle<const MORE: usize>(&self, pressure_q22: u32) -> u32 {
        let coarse = (pressure_q22 >> 10) as i32;
        if coarse < self.start_q12(&TABLE[1]) {
            return self.near_rest(pressure_q22 << FIRST_BITS);
        }
        // The last segment whose start does not exceed the pressure, in five comparisons; it may be the end, where every
        // y is 170 degrees.
        let mut index = 0;
        for step in [16, 8, 4, 2, 1] {
            if self.start_q12(&TABLE[index | step]) <= coarse {
                index |= step;
            }
        }
        let excess_on =
            |segment: &Segment| self.start(segment).wrapping_sub((pressure_q22 >> (segment.fewer_bits & 31)) as i32);
        let mut segment = &TABLE[index];
        let mut excess = excess_on(segment);
        let mut y = START;
        if excess > 0 {
            // What was compared is rounded down: it is the segment before, within 0.001 kPa of its end.
            segment = &TABLE[(index - 1) % ENTRIES];
            excess = excess_on(segment);
            y = RIGHT_END;
        }
        let quintic = self.quintic(segment);
        if y != RIGHT_END {
            y = quintic.step(excess, y);
        }
        for _ in 0..MORE {
            y = quintic.step(excess, y);
        }
        angle_at(segment, quintic.last_step(excess, quintic.step(excess, y)))
    }

    /// The same from Q24 kPa, below 256, whose last bits count near rest.
    #[inline(never)]
    pub(super) fn angle_q24(&self, pressure: u32) -> u32 {
        if ((pressure >> 12) as i32) < self.start_q12(&TABLE[1]) {
            self.near_rest(pressure << 1)
        } else {
            self.angle::<2>(pressure >> 2)
        }
    }

    /// On the first segment, where P is y (c1 + y (c2 + ...)) and its root starts like a square root. From Q25 kPa.
    ///
    /// With y' = 2ˢ y and P' = 4ˢ P the equation keeps its form, its coefficients being c1·2ˢ, c2, c3/2ˢ, ...: so that P'
    /// is 1/32 to 1/4 of c2, and y' nowhere small.
    #[inline(always)]
    fn near_rest(&self, pressure: u32) -> u32 {
        let segment = &TABLE[0];
        let [c1, c2, c3, c4, c5] = self.quintic(segment).0;
        let (c1, c2) = (c1 << FIRST_BITS, c2 << FIRST_BITS);
        let room = pressure.leading_zeros() as i32 - (c2 - (c2 >> 6)).leading_zeros() as i32 - 3;
        let room = if room < 0 { 0 } else { room >> 1 };
        // As far as c1 leaves room; where it leaves none, P is linear and y' may be small.
        let most = c1.wrapping_neg().leading_zeros() as i32 - 2;
        let s = (if room < most { room } else { most }) & 31;
        let scaled = Quintic([
            c1 << s,
            c2,
            (c3 << FIRST_BITS) >> s,
            (c4 << FIRST_BITS) >> s >> s,
            (c5 << FIRST_BITS) >> s >> s >> s,
        ]);
        let excess = 0i32.wrapping_sub((pressure << s << s) as i32);
        let mut y = FIRST_START;
        let mut step = 0;
        while step < 3 {
            y = scaled.step(excess, y);
            step += 1;
        }
        angle_at(segment, scaled.last_step(excess, y) >> s)
    }
}

/// A/8, B/128 and α/2 in Q28 at an angle in 2⁻²⁴ degree, at most 130 degrees.
pub(super) fn regressors(angle: u32) -> [i32; 3] {
    /// Degrees to half a radian: from 2⁻²⁴ degree, over 2³², to Q28.
    const HALF_RADIANS: u64 = (core::f64::consts::PI / 180.0 * (1u64 << 35) as f64 + 0.5) as u64;
    let (index, width_bits) = segment_of(angle);
    let segment = &TABLE[index % ENTRIES];
    let y = 0i32.wrapping_sub(((angle << (32 - width_bits)) >> 1) as i32);
    let q = MOST_FRACTION_BITS.wrapping_sub(u32::from(segment.fewer_bits));
    let a = (i64::from(value_at(&segment.a, y)) << 18) >> (q & 31);
    let b = (i64::from(value_at(&segment.b, y)) << 19) >> (q & 31);
    let alpha = (u64::from(angle) * HALF_RADIANS) >> 32;
    [a as i32, b as i32, alpha as i32]
}
