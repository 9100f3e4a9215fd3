//! The two calibration-free functions A and B as quintics on 31 segments of the bend, generated in `const` evaluation.
//!
//! Segments are 8 degrees wide, between 32 and 64 degrees 16, from 112 on 4, from 152 on 2, up to 170: towards the pole
//! at 180 degrees they shrink as the functions steepen, and towards rest as the square root of the inverse does. Each
//! quintic passes through its function at six Chebyshev-Lobatto points, the segment's ends among them. With the end of
//! the model, which has a start only, the table takes 2 KiB.
//!
//! # Rounded so that nothing falls at a segment's end
//! A segment's polynomial starts at its own constant term and is evaluated with floors only. The constant terms are
//! rounded up, all others down and the linear one by two units more, so that what a segment reaches at its right end
//! never exceeds where the next one starts.

/// Segments of the bend, and the end of the model.
pub(super) const ENTRIES: usize = 32;

/// The end of the model.
pub(super) const END: usize = ENTRIES - 1;

/// The most fractional bits of a segment's pressure in kPa: a pressure of up to 1023 kPa fits, and so does k·α.
pub(super) const MOST_FRACTION_BITS: u32 = 22;

/// Of a quintic in y, minus half the offset from the segment's start as a share of its width: −1/2 < y <= 0.
///
/// Minus, because a factor that the compiler knows to be positive makes a signed product mixed, which costs the
/// Cortex-M4 four instructions instead of one.
pub(super) const COEFFICIENTS: usize = 6;

/// One segment. Its pressure has q fractional bits, as many as any admitted calibration leaves room for.
///
/// In this order, because what the search compares is loaded by one instruction from where the segment starts.
#[derive(Clone, Copy)]
#[repr(C)]
pub(super) struct Segment {
    /// Start in 2⁻²⁴ degree.
    pub start: u32,
    /// A at the start in Q19, rounded down.
    pub a_start: i32,
    /// B at the start in Q14, rounded down.
    pub b_start: i32,
    /// [`MOST_FRACTION_BITS`] − q.
    pub fewer_bits: u8,
    /// From y, in 2⁻³² of twice the width, to 2⁻²⁴ degree.
    pub angle_shift: u8,
    /// From k in Q30 per degree to its pressure over twice the width.
    pub bending_shift: u8,
    /// A in Q(7 + q).
    pub a: [i32; COEFFICIENTS],
    /// B in Q(2 + q).
    pub b: [i32; COEFFICIENTS],
}

/// All of them in order.
pub(super) static TABLE: [Segment; ENTRIES] = table();

/// The segment in which an angle in 2⁻²⁴ degree lies, and the binary logarithm of its width; the end from 170 degrees on.
#[inline(always)]
pub(super) const fn segment_of(angle: u32) -> (usize, u32) {
    if angle < 32 << 24 {
        ((angle >> 27) as usize, 27)
    } else if angle < 64 << 24 {
        ((angle >> 28) as usize + 2, 28)
    } else if angle < 112 << 24 {
        ((angle >> 27) as usize - 2, 27)
    } else if angle < 152 << 24 {
        ((angle >> 26) as usize - 16, 26)
    } else {
        ((angle >> 25) as usize - 54, 25)
    }
}

/// Start of a segment in whole degrees, and the binary logarithm of its width in 2⁻²⁴ degree.
const fn place(index: usize) -> (u32, u32) {
    let mut start = 0;
    let mut found = segment_of(0);
    while found.0 < index {
        start += 1u32 << (found.1 - 24);
        found = segment_of(start << 24);
    }
    (start, found.1)
}

/// h(α) = (1 − sin α / α) / α² = Σ (−α²)ⁿ / (2n + 3)!; 20 terms reach f64's own resolution below 180 degrees.
pub(crate) const fn h_of(alpha: f64) -> f64 {
    let mut term = 1.0 / 6.0;
    let mut sum = 0.0;
    let mut n = 0;
    while n < 20 {
        sum += term;
        let next = 2.0 * n as f64 + 4.0;
        term *= -alpha * alpha / (next * (next + 1.0));
        n += 1;
    }
    sum
}

const RADIANS: f64 = core::f64::consts::PI / 180.0;

/// A and B, in products of positive terms: nothing cancels.
const fn functions(degrees: f64) -> [f64; 2] {
    let alpha = degrees * RADIANS;
    let t = alpha * alpha * h_of(alpha);
    let mu = 1.0 - t;
    let mu2 = mu * mu;
    let w = t * (1.0 / mu + 1.0);
    let a = 4.0 * w * (1.0 + mu2 + mu2 * mu2);
    [a, 2.0 * a * w * w * (2.0 + mu2)]
}

const fn start_deg(index: usize) -> f64 {
    place(index).0 as f64
}

const fn width_deg(index: usize) -> f64 {
    (1u32 << (place(index).1 - 24)) as f64
}

/// Powers of y of the polynomial through the first `count` values; the other coefficients are zero.
const fn interpolate(points: [f64; COEFFICIENTS], mut c: [f64; COEFFICIENTS], count: usize) -> [f64; COEFFICIENTS] {
    // Newton's divided differences in place ...
    let mut order = 1;
    while order < count {
        let mut i = count - 1;
        while i >= order {
            c[i] = (c[i] - c[i - 1]) / (points[i] - points[i - order]);
            i -= 1;
        }
        order += 1;
    }
    // ... and from Newton's form to powers.
    let mut first = count - 1;
    while first > 0 {
        first -= 1;
        let mut i = first;
        while i < count - 1 {
            c[i] -= points[first] * c[i + 1];
            i += 1;
        }
    }
    c
}

/// Powers of y of A and of B on a segment.
///
/// On the first one both are y² times a cubic, so that their value and slope at rest are exactly zero and A keeps its
/// relative accuracy however small the bend.
const fn powers(index: usize) -> [[f64; COEFFICIENTS]; 2] {
    // (1 − cos(i π/5)) / 4, and the same for thirds.
    const SIX: [f64; COEFFICIENTS] = [
        0.0,
        0.047_745_751_406_263_14,
        0.172_745_751_406_263_15,
        0.327_254_248_593_736_85,
        0.452_254_248_593_736_85,
        0.5,
    ];
    const FOUR: [f64; COEFFICIENTS] = [0.0, 0.125, 0.375, 0.5, 0.0, 0.0];
    let [start, width] = [start_deg(index), width_deg(index)];
    let mut both = [[0.0; COEFFICIENTS]; 2];
    let mut which = 0;
    while which < 2 {
        let mut values = [0.0; COEFFICIENTS];
        if index == 0 {
            // A is 4 α² to the first order, B is of the sixth.
            let twice = 2.0 * width * RADIANS;
            values[0] = if which == 0 { 4.0 * twice * twice } else { 0.0 };
            let mut i = 1;
            while i < 4 {
                values[i] = functions(2.0 * FOUR[i] * width)[which] / (FOUR[i] * FOUR[i]);
                i += 1;
            }
            let cubic = interpolate(FOUR, values, 4);
            both[which] = [0.0, 0.0, cubic[0], cubic[1], cubic[2], cubic[3]];
        } else {
            let mut i = 0;
            while i < COEFFICIENTS {
                values[i] = functions(start + 2.0 * SIX[i] * width)[which];
                i += 1;
            }
            both[which] = interpolate(SIX, values, COEFFICIENTS);
        }
        which += 1;
    }
    both
}

const fn magnitude(value: f64) -> f64 {
    if value < 0.0 { -value } else { value }
}

/// The most fractional bits with which each coefficient fits 31 bits, alone and in the sum of any admitted calibration.
const fn fraction_bits(index: usize) -> u32 {
    let [a, b] = powers(index);
    // Both functions are largest at the right end.
    let [a_end, b_end] = functions(start_deg(index) + width_deg(index));
    let mut largest = if 128.0 * a_end > 4.0 * b_end { 128.0 * a_end } else { 4.0 * b_end };
    let mut power = 0;
    while power < COEFFICIENTS {
        let angle = match power {
            0 => start_deg(index),
            1 => 2.0 * width_deg(index),
            _ => 0.0,
        };
        let [a, b] = [magnitude(a[power]), magnitude(b[power])];
        // Of P, and of A and B in their own formats, which have 7 and 2 more fractional bits.
        let values = [60.0 * angle * RADIANS + 40.0 * a + 2.0 * b, 128.0 * a, 4.0 * b];
        let mut i = 0;
        while i < values.len() {
            if values[i] > largest {
                largest = values[i];
            }
            i += 1;
        }
        power += 1;
    }
    let mut q = 0;
    while q < MOST_FRACTION_BITS && largest * ((1u64 << (q + 1)) as f64) < 2_147_000_000.0 {
        q += 1;
    }
    q
}

const fn floor(value: f64) -> i64 {
    let truncated = value as i64;
    if value < truncated as f64 { truncated - 1 } else { truncated }
}

/// To the integer above or below.
const fn rounded(value: f64, up: bool) -> i64 {
    if up { -floor(-value) } else { floor(value) }
}

const fn table() -> [Segment; ENTRIES] {
    const EMPTY: Segment = Segment {
        start: 0,
        a_start: 0,
        b_start: 0,
        // The end has no width, and every pressure lies above what it has.
        fewer_bits: 8,
        angle_shift: 31,
        bending_shift: 31,
        a: [0; COEFFICIENTS],
        b: [0; COEFFICIENTS],
    };
    let mut all = [EMPTY; ENTRIES];
    let mut index = 0;
    while index < ENTRIES {
        let [a, b] = functions(start_deg(index));
        all[index].start = place(index).0 << 24;
        all[index].a_start = (a * (1u32 << 19) as f64) as i32;
        all[index].b_start = (b * (1u32 << 14) as f64) as i32;
        if index < END {
            let [a, b] = powers(index);
            let q = fraction_bits(index);
            all[index].fewer_bits = (MOST_FRACTION_BITS - q) as u8;
            all[index].angle_shift = (31 - place(index).1) as u8;
            all[index].bending_shift = (31 - place(index).1 + MOST_FRACTION_BITS - q) as u8;
            let mut power = 0;
            while power < COEFFICIENTS {
                // The odd powers' signs follow from the offset's.
                let odd = power % 2 == 1;
                let down = if power == 1 && index > 0 { 2 } else { 0 };
                let a = rounded(a[power] * (1u64 << (q + 7)) as f64, power == 0) - down;
                let b = rounded(b[power] * (1u64 << (q + 2)) as f64, power == 0) - down;
                all[index].a[power] = (if odd { -a } else { a }) as i32;
                all[index].b[power] = (if odd { -b } else { b }) as i32;
                power += 1;
            }
        }
        index += 1;
    }
    all
}
