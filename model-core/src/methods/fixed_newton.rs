//! `fixed-newton`: Newton from a table of 8 degrees, in 64-bit fixed point, rounded to the last bit.
//!
//! ```text
//! P(α) = k·α + c1·A + c2·B      λ = α / sin α,  A = 4 (λ − λ⁻⁵),  B = 2 A (I1 − 3),  I1 = 2 λ² + λ⁻⁴
//! ```
//!
//! # Without cancellation
//! At α → 0 the stretch is 0/0 and both λ − λ⁻⁵ and I1 − 3 are differences of nearly equal numbers. With μ = sin α /
//! α and t = 1 − μ, and w = λ − 1/λ = t (λ + 1), they become products of positive terms:
//!
//! ```text
//! A = 4 w (1 + μ² + μ⁴)         I1 − 3 = w² (2 + μ²)
//! ```
//!
//! so that only t(α) = α² h(α) needs a table. h is entire and even; 22 segments of 8 degrees with a quartic each give
//! t to 9e-10 of its value. The table knows nothing of the calibration, and neither does the second one, A and B at
//! the segments' ends, in which the inverse looks for its start. Together 624 bytes, generated in `const` evaluation
//! from the formulas above.
//!
//! # Monotone
//! From one rounding boundary of the bend to the next (half an LSB on either side of a value) t grows by at least
//! 1e-7 of itself; its rounding noise is smaller (by an estimate: about a tenth), and all that follows is products of
//! such terms and floors, so that the evaluated pressure never falls. The inverse is *defined* by it: the number of rounding
//! boundaries whose pressure does not exceed the given one, that is, the solution rounded to nearest. Newton's steps
//! only find the candidate; when it lies near a boundary, one evaluation at the boundary itself decides. So the
//! inverse is monotone however flat it is (at 1000 kPa dozens of pressures share one bend), and it agrees with the
//! forward direction.
//!
//! # Errors
//! Worst error over 0..1000 kPa and eight calibrations: 8.1e-6 degree, 1.9e-5 kPa, of which rounding to the result's LSB alone
//! is 7.6e-6 (`cargo test -p model-core fixed_newton -- --nocapture`). Some 1,300 instructions on a Cortex-M4 for the
//! bend, 214 for the pressure (`cargo xtask pareto`).
//!
//! # Formats
//! | Quantity | Format | Largest |
//! |---|---|---|
//! | angle | u32, 2⁻²⁴ degree | 170 |
//! | t | u64, Q64 | 0.942 |
//! | μ, its powers | u32, Q32 | 1 − 2⁻³² |
//! | λ | u32, Q27 | 17.1 |
//! | w | u64, Q59 | 17.1 |
//! | A | u64, Q55 | 68.4 |
//! | I1 − 3 | u64, Q52 | 582 |
//! | B | u64, Q43 | 79 600 |
//! | pressure | u64, Q38 kPa | 162 000 |

use super::Method;
use crate::inverse::segments::h_of;
use crate::inverse::{BEND_LIMIT, PRESSURE_LIMIT};
use crate::units::{Bend, Coefficients, Pressure};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct FixedNewton(Coefficients);

impl Method for FixedNewton {
    const NAME: &'static str = "fixed-newton";
    const SUMMARY: &'static str = "fixed point, Newton from a coarse table, rounded to the last bit";
    type Pressure = Pressure;
    type Bend = Bend;

    fn prepare(coefficients: &Coefficients) -> Self {
        Self(*coefficients)
    }

    fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        bend_from_pressure(&self.0, pressure)
    }

    fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        pressure_from_bend(&self.0, bend)
    }
}

/// [`BEND_LIMIT`] in 2⁻²⁴ degree.
const ANGLE_LIMIT: u32 = 170 << 24;

/// One segment of the table spans 2²⁷ of 2⁻²⁴ degree: 8 degrees.
const SEGMENT_SHIFT: u32 = 27;

/// 170 / 8, rounded up.
const SEGMENTS: usize = 22;

/// Newton steps at most. Four at most on the grid of `newton_needs_few_steps`; the bound keeps the worst case finite
/// whatever happens.
const MOST_STEPS: u32 = 8;

/// After a step this short (2⁻¹³ degree) the next would move by less than [`DOUBT`]: convergence is quadratic, with a
/// factor of at most 1/(2α) at the square-root start, where α is above 0.05 degree from the first LSB of pressure on.
const SHORT_STEP: u64 = 1 << 11;

/// The candidate is trusted to this many 2⁻²⁴ degree (an eighth of the output's LSB); nearer to a rounding boundary
/// than this, the pressure at the boundary decides.
const DOUBT: u32 = 32;

/// Degrees to radians in Q37.
const RADIANS_Q37: u32 = (core::f64::consts::PI / 180.0 * (1u64 << 37) as f64 + 0.5) as u32;

/// Radians to degrees, doubled, in Q24.
const TWICE_DEGREES_Q24: u32 = (360.0 / core::f64::consts::PI * (1u64 << 24) as f64 + 0.5) as u32;

/// The bend at which the segment rests under `pressure`.
///
/// From 0 to 1000 kPa the solution of P(α) = `pressure`, rounded to nearest, and never above [`BEND_LIMIT`]; above
/// 1000 kPa the value at 1000 kPa. At or below 0 kPa the bend is 0: the exoskeleton stops extension, and the model
/// has no branch there.
///
/// Non-decreasing: checked over every input of the domain for eight calibrations and over samples for random admitted
/// ones; not proved for all.
#[must_use]
pub fn bend_from_pressure(coefficients: &Coefficients, pressure: Pressure) -> Bend {
    let bits = pressure.min(PRESSURE_LIMIT).to_bits();
    // Positive and at most 1000·2¹⁶ from here on.
    let bits = match u32::try_from(bits) {
        Ok(bits) if bits > 0 => bits,
        _ => return Bend::ZERO,
    };
    let model = Model::new(coefficients);
    let target = u64::from(bits) << 22;
    let candidate = model.solve(bits, target);

    // Round to nearest; the boundary between two results is at half an LSB, 128 of 2⁻²⁴ degree.
    let below = candidate >> 8;
    let boundary = (below << 8) | 128;
    let rounds_up = if candidate.abs_diff(boundary) > DOUBT {
        candidate > boundary
    } else {
        model.pressure_q38(&Geometry::at(boundary)) <= target
    };
    let rounded = below + u32::from(rounds_up);
    Bend::from_bits(rounded as i32).min(BEND_LIMIT)
}

/// The pressure that holds the segment at `bend`.
///
/// From 0 to 170 degrees P(α), rounded to nearest and saturated at [`Pressure::MAX`]; 0 at or below 0 degrees, and
/// beyond [`BEND_LIMIT`] the value there.
///
/// Non-decreasing: checked over every input of the domain for eight calibrations and over samples for random admitted
/// ones; not proved for all.
#[must_use]
pub fn pressure_from_bend(coefficients: &Coefficients, bend: Bend) -> Pressure {
    let bits = bend.clamp(Bend::ZERO, BEND_LIMIT).to_bits();
    // 0..=170·2¹⁶, so that the shift stays within 32 bits.
    let geometry = Geometry::at((bits as u32) << 8);
    let exact = Model::new(coefficients).pressure_q38(&geometry);
    let rounded = (exact + (1 << 21)) >> 22;
    Pressure::from_bits(i32::try_from(rounded).unwrap_or(i32::MAX))
}

/// (a·b) >> 32 for a·b < 2⁹⁶ whose result fits 64 bits: two 32x32 multiplications.
const fn scale(a: u64, b: u32) -> u64 {
    let high = (a >> 32) * b as u64;
    let low = (a & 0xFFFF_FFFF) * b as u64;
    high.wrapping_add(low >> 32)
}

/// (a·b) >> 32.
const fn high(a: u32, b: u32) -> u32 {
    ((a as u64 * b as u64) >> 32) as u32
}

/// (a·b) >> 31, rounded, of two signed numbers of which |b| <= 1 in Q31.
const fn signed_scale(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64 + (1 << 30)) >> 31) as i32
}

/// numerator / denominator · 2^exponent to 2⁻¹⁴ of its value, by one 32-bit division; saturates, also for a
/// denominator of 0.
fn ratio(numerator: u64, denominator: u64, exponent: i32) -> u64 {
    if numerator == 0 {
        return 0;
    }
    let up = numerator.leading_zeros();
    let down = denominator.leading_zeros();
    let top = ((numerator << up) >> 32) as u32;
    // 2¹⁵..2¹⁶, except for a denominator of 0, whose shift by 64 is masked.
    let bottom = (denominator.wrapping_shl(down) >> 48) as u32;
    let Some(quotient) = top.checked_div(bottom) else { return u64::MAX };
    // numerator = top·2^(32 − up), denominator = bottom·2^(48 − down).
    let shift = exponent + down as i32 - up as i32 - 16;
    let quotient = u64::from(quotient);
    if shift >= 46 {
        u64::MAX
    } else if shift >= 0 {
        quotient << shift
    } else {
        quotient.checked_shr(shift.unsigned_abs()).unwrap_or(0)
    }
}

/// Square root of a Q40 number as Q20, to 2⁻¹⁴ of its value.
const fn root_q20(value: u64) -> u64 {
    // An even shift that leaves at most 32 bits.
    let shift = (64u32.saturating_sub(value.leading_zeros()).saturating_sub(31)) & !1;
    let shift = if value >> shift > u32::MAX as u64 { shift + 2 } else { shift };
    ((((value >> shift) as u32).isqrt()) as u64) << (shift / 2)
}

/// What the bend alone decides, whatever the calibration.
struct Geometry {
    angle: u32,
    /// dt/dα per degree, Q38, at most 0.0077.
    t_slope: u32,
    /// μ², Q32.
    mu2: u32,
    /// μ⁴, Q32.
    mu4: u32,
    /// λ, Q27.
    lambda: u32,
    /// A, Q55.
    a: u64,
    /// I1 − 3, Q52.
    excess: u64,
}

impl Geometry {
    /// At `angle` in 2⁻²⁴ degree, at most [`ANGLE_LIMIT`] and half an LSB.
    fn at(angle: u32) -> Self {
        let (t, t_slope) = shortening(angle);
        // 1 − t; at t = 0 one LSB short of 1.
        let mu = !((t >> 32) as u32);
        let mu2 = high(mu, mu);
        let mu4 = high(mu2, mu2);
        let lambda = reciprocal_q27(mu);
        let w = scale(t, lambda.saturating_add(1 << 27));
        let a = scale(w, (1 << 30) + (mu2 >> 2) + (mu4 >> 2));
        let w_q27 = w >> 32;
        let excess = scale(w_q27.wrapping_mul(w_q27), (1 << 31) + (mu2 >> 2));
        Self { angle, t_slope, mu2, mu4, lambda, a, excess }
    }

    /// A in Q24: 31 bits.
    const fn a_q24(&self) -> u32 {
        (self.a >> 31) as u32
    }
}

/// t = 1 − sin α / α in Q64 and dt/dα per degree in Q38, at `angle` in 2⁻²⁴ degree, at most [`ANGLE_LIMIT`] and half
/// an LSB.
fn shortening(angle: u32) -> (u64, u32) {
    let index = (angle >> SEGMENT_SHIFT) as usize;
    let Segment { base, rest: [c1, c2, c3, c4] } = *SEGMENT_TABLE.get(index).unwrap_or(&NO_SEGMENT);
    // Offset from the segment's middle in half widths, Q31: −1..1.
    let offset = ((angle << (32 - SEGMENT_SHIFT)) ^ 0x8000_0000) as i32;
    // Horner for h and, from the same partial sums, its derivative.
    let p3 = c3.wrapping_add(signed_scale(c4, offset));
    let p2 = c2.wrapping_add(signed_scale(p3, offset));
    let p1 = c1.wrapping_add(signed_scale(p2, offset));
    let h = base.saturating_add_signed(signed_scale(p1, offset));
    let d3 = p3.wrapping_add(signed_scale(c4, offset));
    let d2 = p2.wrapping_add(signed_scale(d3, offset));
    let h_slope = p1.wrapping_add(signed_scale(d2, offset));

    // t = α² h with 46 + 2·24 fractional bits, 32 of them shifted out; the two spare bits above keep t < 1.
    let t = scale(u64::from(angle) * u64::from(h), angle) << 2;
    // dt/dα = 2 α (h + α/2 dh/dα); dh/dα = h_slope / 4 degrees.
    let half_h = i64::from(h) + ((i64::from(angle) * i64::from(h_slope)) >> 27);
    let t_slope = ((u64::from(angle).wrapping_mul(half_h as u64)) >> 31) as u32;
    (t, t_slope)
}

/// 1/μ in Q27 for μ in Q32, not below 1/32.
fn reciprocal_q27(mu: u32) -> u32 {
    // From below, to 2⁻¹¹: then each Newton step stays below, so that everything is unsigned.
    let seed = u32::MAX.checked_div((mu >> 16) + 1).unwrap_or(u32::MAX);
    let mut guess = seed << 11;
    for _ in 0..2 {
        let error = (1u64 << 59).saturating_sub(u64::from(mu) * u64::from(guess));
        guess = guess.saturating_add(high(guess, (error >> 27) as u32));
    }
    guess
}

/// The coefficients in the solver's own formats, all Q24 and not negative.
struct Model {
    k: u32,
    c1: u32,
    c2: u32,
}

impl Model {
    const fn new(coefficients: &Coefficients) -> Self {
        // `Coefficients` admits no negative value.
        Self {
            k: coefficients.k().to_bits() as u32,
            c1: coefficients.c1().to_bits() as u32,
            c2: coefficients.c2().to_bits() as u32,
        }
    }

    /// P in Q38 kPa.
    fn pressure_q38(&self, at: &Geometry) -> u64 {
        // α in Q61 radians: 2⁻²⁴ degree times Q37.
        let alpha = u64::from(at.angle) * u64::from(RADIANS_Q37);
        let b = scale(at.excess, at.a_q24());
        (scale(alpha, self.k) >> 15) + (scale(at.a, self.c1) >> 9) + (scale(b, self.c2) << 3)
    }

    /// dP/dα in Q32 kPa per degree.
    fn slope_q32(&self, at: &Geometry) -> u64 {
        // dA/dλ = 4 (1 + 5 λ⁻⁶), at most 24, in Q26.
        let mu6 = u64::from(high(at.mu4, at.mu2));
        let a_slope = (1 << 28) + ((mu6 * 5) >> 4);
        // dB/dλ = 2 (dA/dλ (I1 − 3) + A²), at most 14 020, halved in Q16; A² from Q12.
        let excess_q20 = at.excess >> 32;
        let a_q12 = u64::from(at.a_q24() >> 12);
        let b_slope = ((a_slope * excess_q20) >> 30) + ((a_q12 * a_q12) >> 8);
        // dP/dλ in Q16, at most 28 200.
        let stretch_slope = ((a_slope * u64::from(self.c1)) >> 34) + ((b_slope * u64::from(self.c2)) >> 23);
        // dλ/dα = λ² dt/dα, at most 1.8 per degree, in Q31.
        let lambda2 = (u64::from(at.lambda) * u64::from(at.lambda)) >> 32;
        let lambda_slope = (lambda2 * u64::from(at.t_slope)) >> 29;
        ((u64::from(self.k) * u64::from(RADIANS_Q37)) >> 29) + ((stretch_slope.wrapping_mul(lambda_slope)) >> 15)
    }

    /// P in Q16 kPa at the lower end of segment `index`, from the table.
    fn node(&self, index: usize) -> u64 {
        let Node { a, b } = *NODE_TABLE.get(index).unwrap_or(&NO_NODE);
        // α = 8 degrees times the index, below 4 radians in Q29.
        let alpha = (index as u64 * u64::from(RADIANS_Q37)) >> 5;
        ((alpha * u64::from(self.k)) >> 37)
            + ((u64::from(a) * u64::from(self.c1)) >> 32)
            + ((u64::from(b) * u64::from(self.c2)) >> 23)
    }

    /// The angle in 2⁻²⁴ degree at which the pressure is `bits` (Q16 kPa, the same as `target` in Q38), to within
    /// [`DOUBT`].
    fn solve(&self, bits: u32, target: u64) -> u32 {
        self.solve_counted(bits, target).0
    }

    /// [`Model::solve`] and how often it evaluated the model.
    fn solve_counted(&self, bits: u32, target: u64) -> (u32, u32) {
        // The last segment whose lower end's pressure does not exceed the target.
        let mut low = 0;
        let mut end = SEGMENTS;
        while end - low > 1 {
            let middle = low.midpoint(end);
            if self.node(middle) <= u64::from(bits) {
                low = middle;
            } else {
                end = middle;
            }
        }
        // A little wider than the segment, for the rounding of the table.
        let slack = 1 << 16;
        let floor = (low << SEGMENT_SHIFT) as u32;
        let ceiling = ANGLE_LIMIT.min(floor.saturating_add((1 << SEGMENT_SHIFT) + slack));
        let mut below = floor.saturating_sub(slack);
        let mut above = ceiling;
        let start = if low == 0 {
            self.quadratic_start(bits)
        } else {
            let base = self.node(low);
            let rise = self.node(low + 1).saturating_sub(base);
            // The last segment stops after 2 degrees.
            let width = if low + 1 == SEGMENTS { 25 } else { SEGMENT_SHIFT as i32 };
            let fraction = ratio(u64::from(bits).saturating_sub(base), rise, width);
            u64::from(floor).saturating_add(fraction)
        };
        let mut angle = start.min(u64::from(above)).max(u64::from(below)) as u32;
        let mut steps = 0;
        while steps < MOST_STEPS {
            steps += 1;
            let here = Geometry::at(angle);
            let pressure = self.pressure_q38(&here);
            // The bracket follows the sign, so that a step too long ends inside it.
            if pressure <= target {
                below = angle;
            } else {
                above = angle;
            }
            // Q38 over Q32, in 2⁻²⁴ degree.
            let length = ratio(target.abs_diff(pressure), self.slope_q32(&here), 18);
            let short = u32::try_from(length).unwrap_or(u32::MAX);
            let next = if pressure <= target { angle.saturating_add(short) } else { angle.saturating_sub(short) };
            // min and max, because a mistaken bracket must not make `clamp` panic.
            let next = next.min(above).max(below);
            // No movement: solved, or beyond 170 degrees.
            let settled = length < SHORT_STEP || next == angle;
            angle = next;
            if settled {
                break;
            }
        }
        (angle, steps)
    }

    /// The root of 4 c1 α² + k α = P, which is what the model becomes at α → 0, in 2⁻²⁴ degree; without cancellation:
    /// 2 P / (k + √(k² + 16 c1 P)).
    fn quadratic_start(&self, bits: u32) -> u64 {
        let k2 = (u64::from(self.k) * u64::from(self.k)) >> 8;
        let root = root_q20(k2.saturating_add((u64::from(self.c1) * u64::from(bits)) << 4));
        ratio(u64::from(bits) * u64::from(TWICE_DEGREES_Q24), u64::from(self.k >> 4) + root, 4)
    }
}

/// h over one segment as a quartic in the offset from its middle, in half widths; 2⁻⁴⁶ per square degree.
#[derive(Clone, Copy)]
struct Segment {
    base: u32,
    rest: [i32; 4],
}

/// A in Q24 and B in Q15 at a segment's end.
#[derive(Clone, Copy)]
struct Node {
    a: u32,
    b: u32,
}

static SEGMENT_TABLE: [Segment; SEGMENTS] = segments();
static NODE_TABLE: [Node; SEGMENTS + 1] = nodes();
/// In place of an index out of bounds, which the angle's limit rules out.
const NO_SEGMENT: Segment = Segment { base: 0, rest: [0; 4] };
/// Likewise.
const NO_NODE: Node = Node { a: u32::MAX, b: u32::MAX };

/// To the nearest integer.
const fn nearest(value: f64) -> i64 {
    (if value < 0.0 { value - 0.5 } else { value + 0.5 }) as i64
}

/// The quartic through h at each segment's five Chebyshev points, cos((2i + 1) π/10).
const fn segments() -> [Segment; SEGMENTS] {
    const POINTS: [f64; 5] =
        [-0.951_056_516_295_153_5, -0.587_785_252_292_473_1, 0.0, 0.587_785_252_292_473_1, 0.951_056_516_295_153_5];
    let radians = core::f64::consts::PI / 180.0;
    let unit = radians * radians * (1u64 << 46) as f64;
    let mut table = [Segment { base: 0, rest: [0; 4] }; SEGMENTS];
    let mut index = 0;
    while index < SEGMENTS {
        let middle = 8.0 * index as f64 + 4.0;
        // Newton's divided differences in place ...
        let mut c = [0.0; 5];
        let mut i = 0;
        while i < 5 {
            c[i] = h_of(radians * (middle + 4.0 * POINTS[i])) * unit;
            i += 1;
        }
        let mut order = 1;
        while order < 5 {
            let mut i = 4;
            while i >= order {
                c[i] = (c[i] - c[i - 1]) / (POINTS[i] - POINTS[i - order]);
                i -= 1;
            }
            order += 1;
        }
        // ... and from Newton's form to powers of the offset.
        let mut start = 4;
        while start > 0 {
            start -= 1;
            let mut i = start;
            while i < 4 {
                c[i] -= POINTS[start] * c[i + 1];
                i += 1;
            }
        }
        table[index] = Segment {
            base: nearest(c[0]) as u32,
            rest: [nearest(c[1]) as i32, nearest(c[2]) as i32, nearest(c[3]) as i32, nearest(c[4]) as i32],
        };
        index += 1;
    }
    table
}

/// A and B at one angle.
const fn node_at(degrees: f64) -> Node {
    let alpha = degrees * (core::f64::consts::PI / 180.0);
    let t = alpha * alpha * h_of(alpha);
    let mu = 1.0 - t;
    let mu2 = mu * mu;
    let w = t * (1.0 / mu + 1.0);
    let a = 4.0 * w * (1.0 + mu2 + mu2 * mu2);
    let b = 2.0 * a * w * w * (2.0 + mu2);
    Node { a: nearest(a * (1u64 << 24) as f64) as u32, b: nearest(b * (1u64 << 15) as f64) as u32 }
}

/// A and B at the lower end of every segment, and at 170 degrees, where the last one stops short.
const fn nodes() -> [Node; SEGMENTS + 1] {
    let mut table = [Node { a: 0, b: 0 }; SEGMENTS + 1];
    let mut index = 0;
    while index < SEGMENTS {
        table[index] = node_at(8.0 * index as f64);
        index += 1;
    }
    table[SEGMENTS] = node_at(170.0);
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{CALIBRATIONS, Limits, check};

    const DOMAIN_PRESSURE: i32 = 1000 << 16;
    const DOMAIN_BEND: i32 = 170 << 16;

    fn calibration((k, c1, c2): (f64, f64, f64)) -> Coefficients {
        Coefficients::from_f64_kpa(k, c1, c2).unwrap()
    }

    fn bend(coefficients: &Coefficients, bits: i32) -> i32 {
        bend_from_pressure(coefficients, Pressure::from_bits(bits)).to_bits()
    }

    fn pressure(coefficients: &Coefficients, bits: i32) -> i32 {
        pressure_from_bend(coefficients, Bend::from_bits(bits)).to_bits()
    }

    #[test]
    fn errors_against_f64() {
        check::<FixedNewton>(&[Limits { bend_deg: 1.0e-5, pressure_kpa: 3.0e-5 }; 3]);
    }

    #[test]
    fn never_falls() {
        for parameters in CALIBRATIONS {
            let c = calibration(parameters);
            for (of, domain, step) in [
                (bend as fn(&Coefficients, i32) -> i32, DOMAIN_PRESSURE, 2111),
                (pressure as fn(&Coefficients, i32) -> i32, DOMAIN_BEND, 353),
            ] {
                let mut last = i32::MIN;
                for bits in (-10..20_000).chain((20_000..=domain).step_by(step)) {
                    let value = of(&c, bits);
                    assert!(value >= last, "{parameters:?}: falls from {last} to {value} at {bits}");
                    last = value;
                }
            }
        }
    }

    /// The definition: the smallest bend whose upper rounding boundary the pressure does not reach.
    fn assert_is_the_rounded_solution(c: &Coefficients, bits: i32) {
        let found = bend(c, bits);
        let model = Model::new(c);
        let at = |boundary: u32| model.pressure_q38(&Geometry::at(boundary));
        let target = (bits as u64) << 22;
        let middle = (found as u32) << 8;
        assert!(found == 0 || at(middle - 128) <= target, "{bits}: {found} too large");
        assert!(found == DOMAIN_BEND || at(middle + 128) > target, "{bits}: {found} too small");
    }

    /// What makes the inverse monotone: Newton's candidate is never off by more than the doubt that the boundary
    /// check covers.
    #[test]
    fn every_result_is_the_rounded_solution() {
        for parameters in CALIBRATIONS {
            let c = calibration(parameters);
            for bits in (1..50_000).chain((1..=DOMAIN_PRESSURE).step_by(307)) {
                assert_is_the_rounded_solution(&c, bits);
            }
            for degrees in (8..=168).step_by(8) {
                let end = pressure(&c, degrees << 16).min(DOMAIN_PRESSURE - 100);
                for bits in end - 100..=end + 100 {
                    assert_is_the_rounded_solution(&c, bits);
                }
            }
        }
    }

    #[test]
    fn newton_needs_few_steps() {
        for parameters in CALIBRATIONS {
            let c = calibration(parameters);
            let (mut most, mut sum, mut count) = (0, 0, 0);
            let mut distance = 0;
            for bits in (1..5000).chain((1..=DOMAIN_PRESSURE).step_by(1009)) {
                let model = Model::new(&c);
                let target = (bits as u64) << 22;
                let (angle, steps) = model.solve_counted(bits as u32, target);
                most = most.max(steps);
                sum += steps;
                count += 1;
                // The exact crossing of the evaluated model, by bisection.
                let (mut low, mut high) = (0, ANGLE_LIMIT);
                while high - low > 1 {
                    let middle = u32::midpoint(low, high);
                    if model.pressure_q38(&Geometry::at(middle)) <= target {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                distance = distance.max(low.abs_diff(angle));
            }
            let mean = f64::from(sum) / f64::from(count);
            println!(
                "{parameters:?}: {mean:.2} evaluations, at most {most}; candidate within {distance} of 2^-24 degree"
            );
            assert!(most <= 4 && distance < DOUBT, "{most} {distance}");
        }
    }

    #[test]
    fn the_table_holds_the_stretch_at_and_between_segment_ends() {
        let (mut worst, mut worst_t) = (0.0_f64, 0.0_f64);
        for angle in (0..=ANGLE_LIMIT).step_by(99_991).chain((1..22).flat_map(|i| [(i << 27) - 1, i << 27])) {
            let degrees = f64::from(angle) / f64::from(1 << 24);
            let alpha = degrees.to_radians();
            let t = alpha * alpha * h_of(alpha);
            // Nearer to zero t's own resolution shows; the inverse's exactness there has its own test.
            if degrees > 0.01 {
                let found = shortening(angle).0 as f64 / 2.0_f64.powi(64);
                worst_t = worst_t.max((found / t - 1.0).abs());
            }
            let here = Geometry::at(angle);
            let lambda = f64::from(here.lambda) / f64::from(1 << 27);
            worst = worst.max(((1.0 - t) * lambda - 1.0).abs());
        }
        println!("t to {worst_t:.2e} of its value, stretch to {worst:.2e}");
        assert!(worst < 2.3e-8 && worst_t < 1.2e-9, "{worst} {worst_t}");
    }
}
