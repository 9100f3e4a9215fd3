//! Sine and cosine by CORDIC in 32-bit fixed point, and Newton with them for the inverse.
//!
//! CORDIC's error is absolute, 1e-8, and t = 1 − sin α / α is a difference of nearly equal numbers near α = 0. Above 1/8 rad
//! this costs up to 1e-4 degree, the worst just above it; below, CORDIC does not fit, and the model's own series takes its place:
//! P = k α + 4 c1 x (1 − 3x/10 + 0.0771 x²) + 8/3 c2 x³ with x = α². The products need 64 bits; the three quotients are 64-bit
//! divisions.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core cordic -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 9.4e-5 | 4.0e-5 |
//! | bare chamber | 2.6e-5 | 4.2e-5 |
//! | worst corner | 9.8e-5 | 9.1e-5 |

use super::{BEND_LIMIT_DEG, F64Newton, Method, fixed};
use crate::inverse::{BEND_LIMIT, PRESSURE_LIMIT};
use crate::units::{Bend, Coefficients, Pressure};

/// Rotations; the last turns by 2⁻²⁹.
const ROTATIONS: usize = 30;
/// 1.0 in Q30, the format of angles in radians, sines and cosines.
const ONE: u32 = 1 << 30;
/// Below 1/8 rad the series.
const SERIES_BELOW: u32 = ONE / 8;
/// π in Q30; needs all 32 bits.
const PI_Q30: u32 = (core::f64::consts::PI * ONE as f64 + 0.5) as u32;
/// 170 degrees in Q30 radians.
const ANGLE_LIMIT: u32 = (BEND_LIMIT_DEG / 180.0 * core::f64::consts::PI * ONE as f64 + 0.5) as u32;
/// Radians a degree in Q40.
const RADIANS_Q40: u64 = (core::f64::consts::PI / 180.0 * (1_u64 << 40) as f64 + 0.5) as u64;
/// Degrees a radian in Q26.
const DEGREES_Q26: u64 = (180.0 / core::f64::consts::PI * (1_u64 << 26) as f64 + 0.5) as u64;
/// Nodes for the start, every 8 degrees.
const NODES: usize = 22;
/// 8 degrees in Q30 radians.
const NODE_SPACING: u64 = (8.0 / 180.0 * core::f64::consts::PI * ONE as f64 + 0.5) as u64;
/// More steps than any input takes.
const MOST_STEPS: u32 = 8;

/// atan(2⁻ⁱ) in Q30.
const TURNS: [i32; ROTATIONS] = {
    let mut turns = [0; ROTATIONS];
    turns[0] = (core::f64::consts::FRAC_PI_4 * ONE as f64 + 0.5) as i32;
    let mut i = 1;
    while i < ROTATIONS {
        let x = 1.0 / (1_u64 << i) as f64;
        let (mut sum, mut power, mut n) = (0.0, x, 0);
        while n < 30 {
            sum += power / (2 * n + 1) as f64;
            power *= -x * x;
            n += 1;
        }
        turns[i] = (sum * ONE as f64 + 0.5) as i32;
        i += 1;
    }
    turns
};

/// What all rotations together shorten a vector to, Π 1/√(1 + 4⁻ⁱ), in Q30.
const SHRINK: i32 = {
    let mut squared = 1.0;
    let mut i = 0;
    while i < ROTATIONS {
        squared *= 1.0 + 1.0 / (1_u64 << (2 * i)) as f64;
        i += 1;
    }
    // Newton for 1/√.
    let mut root = 0.6;
    let mut step = 0;
    while step < 8 {
        root *= 1.5 - 0.5 * squared * root * root;
        step += 1;
    }
    (root * ONE as f64 + 0.5) as i32
};

/// Sine and cosine in Q30 of an angle in Q30 radians, 0..π/2.
fn sin_cos(angle: i32) -> (i32, i32) {
    let (mut x, mut y, mut rest) = (SHRINK, 0_i32, angle);
    for (i, turn) in TURNS.iter().enumerate() {
        let (dx, dy) = (y >> i, x >> i);
        // All ones when the rest is negative: negates without a branch.
        let sign = rest >> 31;
        x = x.wrapping_sub((dx ^ sign).wrapping_sub(sign));
        y = y.wrapping_add((dy ^ sign).wrapping_sub(sign));
        rest = rest.wrapping_sub((turn ^ sign).wrapping_sub(sign));
    }
    (y, x)
}

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Cordic {
    /// kPa in Q24.
    k: u64,
    c1: u64,
    c2: u64,
    /// kPa in Q16 at every 8 degrees and at 170.
    nodes: [i32; NODES + 1],
}

/// a / b, 0 for b = 0, which no input reaches.
fn quotient(a: u64, b: u64) -> u64 {
    a.checked_div(b).unwrap_or(0)
}

impl Cordic {
    /// P in Q24 kPa and, where asked for, dP/dα in Q16 kPa per radian at an angle in Q30 radians, 0..=170 degrees.
    fn pressure_and_slope<const SLOPE: bool>(&self, angle: u32) -> (u64, u64) {
        let alpha = u64::from(angle);
        let stiffness = (alpha * self.k) >> 30;
        if angle < SERIES_BELOW {
            // x in Q38; below 1/64.
            let x = (alpha * alpha) >> 22;
            let square = ((x >> 8) * (x >> 8)) >> 30;
            let falloff = (1 << 30) - ((x * 3 / 10) >> 8) + ((square * 79) >> 10);
            let a = (((x * falloff) >> 30) * self.c1) >> 36;
            let cube = (square * (x >> 8)) >> 30;
            let b = (cube * self.c2 / 3) >> 27;
            let slope = (((alpha * ((1 << 30) - ((x * 6 / 10) >> 8))) >> 30) * self.c1) >> 35;
            return (stiffness + a + b, (self.k >> 8) + slope);
        }
        let mirrored = angle > PI_Q30 / 2;
        let (sin, cos) = sin_cos(if mirrored { PI_Q30 - angle } else { angle } as i32);
        let cos = if mirrored { -i64::from(cos) } else { i64::from(cos) };
        // sin α / α in Q32.
        let mu = quotient(u64::from(sin.unsigned_abs()) << 32, alpha);
        let t = (1_u64 << 32).saturating_sub(mu);
        let mu2 = (mu * mu) >> 32;
        let mu4 = (mu2 * mu2) >> 32;
        // Q27.
        let lambda = quotient(1 << 59, mu);
        let w = (t * (lambda + (1 << 27))) >> 32;
        // A in Q26, I1 − 3 in Q20, B/2 in Q22.
        let a = (w * ((1 << 30) + (mu2 >> 2) + (mu4 >> 2))) >> 29;
        let excess = (((w * w) >> 30) * ((1 << 31) + (mu2 >> 2))) >> 34;
        let half_b = ((a >> 2) * excess) >> 22;
        let pressure = stiffness + ((a * self.c1) >> 26) + ((half_b * self.c2) >> 21);
        if !SLOPE {
            return (pressure, 0);
        }

        // dλ/dα = λ² (μ − cos α) / α in Q24.
        let bessel = quotient((((mu >> 2) as i64 - cos).max(0) as u64) << 30, alpha);
        let lambda_slope = (((lambda * lambda) >> 30) * bessel) >> 30;
        // dA/dλ in Q24; dP/dλ in Q16.
        let a_slope = (4 << 24) + ((((mu4 * mu2) >> 32) * 20) >> 8);
        let b_slope = ((a_slope * (excess >> 8)) >> 20) + ((a >> 18) * (a >> 18));
        let stretch_slope = ((a_slope * self.c1) >> 32) + ((b_slope * self.c2) >> 23);
        (pressure, (self.k >> 8) + ((lambda_slope * stretch_slope) >> 24))
    }

    /// An angle in Q30 radians near the one of a pressure in Q16 kPa.
    fn start(&self, pressure: i32) -> u32 {
        let below = self.nodes.partition_point(|&node| node <= pressure).clamp(1, NODES) - 1;
        if below == 0 {
            // 2 P / (k + √(k² + 16 c1 P)): the product's largest is below 2⁶², because the first node is below 16 kPa.
            let target = u64::from(pressure.unsigned_abs()) << 8;
            let root = (self.k * self.k + ((self.c1 * target) << 4)).isqrt();
            return quotient(target << 31, self.k + root) as u32;
        }
        let (Some(&low), Some(&high)) = (self.nodes.get(below), self.nodes.get(below + 1)) else { return ANGLE_LIMIT };
        let rise = u64::from(pressure.abs_diff(low));
        // The last interval ends after 2 degrees.
        let width = if below + 1 == NODES { NODE_SPACING / 4 } else { NODE_SPACING };
        (below as u64 * NODE_SPACING + quotient(rise * width, u64::from(high.abs_diff(low)))) as u32
    }
}

impl Method for Cordic {
    const NAME: &'static str = "cordic";
    const SUMMARY: &'static str = "fixed point, sine and cosine by CORDIC, Newton";
    type Pressure = Pressure;
    type Bend = Bend;

    fn prepare(coefficients: &Coefficients) -> Self {
        let exact = F64Newton::prepare(coefficients);
        let mut nodes = [0; NODES + 1];
        for (index, node) in nodes.iter_mut().enumerate() {
            *node = fixed(exact.pressure_from_bend((8.0 * index as f64).min(BEND_LIMIT_DEG)), 16);
        }
        let [k, c1, c2] = [coefficients.k(), coefficients.c1(), coefficients.c2()].map(|c| c.to_bits().max(0) as u64);
        Self { k, c1, c2, nodes }
    }

    fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        let bits = pressure.clamp(Pressure::ZERO, PRESSURE_LIMIT).to_bits();
        if bits == 0 {
            return Bend::ZERO;
        }
        let target = u64::from(bits.unsigned_abs()) << 8;
        let (mut low, mut high) = (1, ANGLE_LIMIT);
        let mut angle = self.start(bits).max(low).min(high);
        for _ in 0..MOST_STEPS {
            let (here, slope) = self.pressure_and_slope::<true>(angle);
            if here <= target {
                low = angle;
            } else {
                high = angle;
            }
            // Q24 over Q16 in Q30; the difference is cut at 2¹⁶ kPa.
            let length = quotient(here.abs_diff(target).min(1 << 40) << 22, slope.max(1));
            let length = u32::try_from(length).unwrap_or(u32::MAX);
            let next = if here <= target { angle.saturating_add(length) } else { angle.saturating_sub(length) };
            let next = next.max(low).min(high);
            let settled = next.abs_diff(angle) <= angle >> 13;
            angle = next;
            if settled {
                break;
            }
        }
        let degrees = (u64::from(angle) * DEGREES_Q26 + (1 << 39)) >> 40;
        Bend::from_bits(degrees as i32).min(BEND_LIMIT)
    }

    fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        let bits = bend.clamp(Bend::ZERO, BEND_LIMIT).to_bits() as u32;
        let angle = ((u64::from(bits) * RADIANS_Q40 + (1 << 25)) >> 26) as u32;
        if angle == 0 {
            return Pressure::ZERO;
        }
        let pressure = (self.pressure_and_slope::<false>(angle).0 + (1 << 7)) >> 8;
        Pressure::from_bits(i32::try_from(pressure).unwrap_or(i32::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check};

    #[test]
    fn errors_against_f64() {
        check::<Cordic>(&[
            Limits { bend_deg: 1.4e-4, pressure_kpa: 6.0e-5 },
            Limits { bend_deg: 3.9e-5, pressure_kpa: 6.3e-5 },
            Limits { bend_deg: 1.5e-4, pressure_kpa: 1.4e-4 },
        ]);
    }

    #[test]
    fn sine_and_cosine_to_the_last_bits() {
        let mut worst = 0.0_f64;
        for step in 0..=10_000 {
            let angle = (f64::from(step) / 10_000.0 * core::f64::consts::FRAC_PI_2 * f64::from(ONE)) as i32;
            let (sin, cos) = sin_cos(angle);
            let exact = (f64::from(angle) / f64::from(ONE)).sin_cos();
            worst = worst.max((f64::from(sin) / f64::from(ONE) - exact.0).abs());
            worst = worst.max((f64::from(cos) / f64::from(ONE) - exact.1).abs());
        }
        println!("sine and cosine to {worst:.1e}");
        assert!(worst < 2e-8);
    }
}
