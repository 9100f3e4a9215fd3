//! The finger's model in f64, by its own route: the reference that the fixed-point core is held against, and the
//! plant's mechanics.
//!
//! With alpha the bend of one segment (rad) and lambda = alpha / sin(alpha),
//! `P(alpha) = k alpha + c1 A + c2 B` in kPa, `A = 4 (lambda - lambda^-5)`, `B = 2 A (I1 - 3)`,
//! `I1 = 2 lambda^2 + lambda^-4`.
//!
//! Near alpha = 0 the differences `lambda - lambda^-5` and `I1 - 3` cancel in all but their last digits. Written in
//! `mu = sin(alpha) / alpha` and `t = 1 - mu` they factor, and nothing is subtracted any more: with
//! `w = lambda - mu = lambda t (2 - t)`, `A = 4 w (1 + mu^2 + mu^4)` and `I1 - 3 = w^2 (2 + mu^2)`; `t` itself comes
//! from its series where `1 - mu` would cancel.
//!
//! Near alpha = pi the sine is that of the distance to pi, which is formed from a pi of two parts, or from the distance
//! to 180 degrees, which is exact.
//!
//! What is in between is carried as pairs of f64, so that a pressure is off by little more than its last rounding.
//! Against 50 digits (`cargo test -p finger-tests --test truth --
//! --nocapture`) every function here stays within 4 units of the last place from 1e-18 degree to 180 - 1e-12 degrees;
//! docs/truth.md has the figures.

use core::f64::consts::PI;

/// Below this angle (rad) `t` comes from its series, from here on from the distance to the pole: just above pi/2.
const SERIES_BELOW: f64 = 1.6;

/// The same for angles in degrees, a little below: the switch need not be at the very same place.
const SERIES_BELOW_DEG: f64 = 91.0;

/// Terms of the series that leave less than 1e-17 of the sum below [`SERIES_BELOW`].
const TERMS: usize = 12;

/// pi less its nearest f64.
const PI_LOW: f64 = 1.224_646_799_147_353_2e-16;

/// One degree in radians.
const DEGREE: f64 = PI / 180.0;

/// What [`DEGREE`] leaves out.
const DEGREE_LOW: f64 = 2.948_652_270_870_168_5e-19;

/// `(1 - sin(a)/a) = x/6 (1 - x sum(SINC[n] x^n))` with `x = a^2`: `SINC[n] = 3! (-1)^n / (2n + 5)!`.
const SINC: [f64; TERMS] = alternating(4, 5);

/// `(sin a - a cos a)/a^2 = a/3 (1 - x sum(BESSEL[n] x^n))`: each coefficient is the one before over
/// `-(2n + 2) (2n + 5)`.
const BESSEL: [f64; TERMS] = alternating(2, 5);

/// `1 / (low high)`, and from each to the next the factor `-1 / ((low + 2n) (high + 2n))`.
const fn alternating(low: usize, high: usize) -> [f64; TERMS] {
    let mut series = [0.0; TERMS];
    let mut term = -1.0;
    let mut n = 0;
    while n < TERMS {
        term /= -(((low + 2 * n) * (high + 2 * n)) as f64);
        series[n] = term;
        n += 1;
    }
    series
}

fn polynomial(coefficients: &[f64; TERMS], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// A number as the sum of two f64, the second at most about an ulp of the first.
#[derive(Clone, Copy)]
struct Double {
    high: f64,
    low: f64,
}

impl Double {
    /// The exact product of two f64.
    fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        Self { high, low: a.mul_add(b, -high) }
    }

    fn times(self, other: Self) -> Self {
        let Self { high, low } = Self::product(self.high, other.high);
        Self { high, low: low + (self.high * other.low + self.low * other.high) }
    }

    fn scaled(self, factor: f64) -> Self {
        let Self { high, low } = Self::product(self.high, factor);
        Self { high, low: low + self.low * factor }
    }

    /// `constant + self`, where the constant is the larger of the two.
    fn plus(self, constant: f64) -> Self {
        let high = constant + self.high;
        Self { high, low: ((constant - high) + self.high) + self.low }
    }

    /// `constant - self`, where the constant is the larger of the two.
    fn taken_from(self, constant: f64) -> Self {
        let high = constant - self.high;
        Self { high, low: ((constant - high) - self.high) - self.low }
    }

    /// The quotient of two pairs.
    fn over(self, other: Self) -> Self {
        let high = self.high / other.high;
        let remainder = (-high).mul_add(other.high, self.high) + (self.low - high * other.low);
        Self { high, low: remainder / other.high }
    }

    /// The sum of two pairs, whichever is the larger.
    fn added(self, other: Self) -> Self {
        let high = self.high + other.high;
        let back = high - self.high;
        let low = (self.high - (high - back)) + (other.high - back);
        Self { high, low: low + (self.low + other.low) }
    }

    fn rounded(self) -> f64 {
        self.high + self.low
    }
}

/// Newton's steps at most; five or six are enough in the working range.
const MOST_STEPS: u32 = 12;

/// Newton's start (rad) where the root of the model's leading terms lies beyond the pole. To the right of the solution
/// convergence is monotone.
const FAR_START: f64 = 3.0;

/// `1 - sin(a) / a` from its series, for angles below [`SERIES_BELOW`].
fn one_minus_sinc(angle: Double) -> Double {
    let square = angle.times(angle);
    // The sum is below 0.13: its own rounding counts for an eighth.
    let rest = square.high * polynomial(&SINC, square.high);
    square.over(Double { high: 6.0, low: 0.0 }).times(Double { high: rest, low: 0.0 }.taken_from(1.0))
}

/// What the angle alone decides.
struct Shape {
    alpha: Double,
    /// `mu = sin(alpha) / alpha`.
    mu: Double,
    /// `t = 1 - mu`.
    t: Double,
    /// `(sin a - a cos a) / a^2`, the spherical Bessel function j1; `dlambda/dalpha = lambda^2 j1(alpha)`.
    bessel: f64,
}

impl Shape {
    /// For angles below [`SERIES_BELOW`].
    fn near(alpha: Double) -> Self {
        let t = one_minus_sinc(alpha);
        let x = alpha.high * alpha.high;
        let bessel = alpha.high / 3.0 * (1.0 - x * polynomial(&BESSEL, x));
        Self { alpha, mu: t.taken_from(1.0), t, bessel }
    }

    /// From the distance to the pole, for angles from [`SERIES_BELOW`] on. The sine is that of the distance, from the
    /// same series.
    fn far(distance: Double) -> Self {
        let alpha = Double { high: distance.high, low: distance.low - PI_LOW }.taken_from(PI);
        let mu = distance.times(one_minus_sinc(distance).taken_from(1.0)).over(alpha);
        let bessel = (mu.high + distance.high.cos()) / alpha.high;
        Self { alpha, mu, t: mu.taken_from(1.0), bessel }
    }

    /// Pressure (kPa) and its slope (kPa/rad).
    fn pressure_and_slope(&self, coefficients: &[f64; 3]) -> (f64, f64) {
        let [k, c1, c2] = *coefficients;
        let Self { alpha, mu, t, bessel } = *self;
        let lambda = Double { high: 1.0, low: 0.0 }.over(mu);
        let mu2 = mu.times(mu);
        let w = lambda.times(t.times(t.taken_from(2.0)));
        // 1 + mu^2 + mu^4
        let series = mu2.times(mu2.plus(1.0)).plus(1.0);
        let a = w.times(series).scaled(4.0);
        let excess = w.times(w).times(mu2.plus(2.0));
        let wall = a.times(excess.scaled(2.0 * c2)).added(a.scaled(c1));
        let pressure = alpha.scaled(k).added(wall).rounded();

        let a_slope = mu2.times(mu2.times(mu2)).scaled(20.0).added(Double { high: 4.0, low: 0.0 });
        // dB/dlambda = 2 A' (I1 - 3) + 2 A^2, because dI1/dlambda is A.
        let b_slope = a_slope.times(excess).added(a.times(a));
        let wall_slope = b_slope.scaled(2.0 * c2).added(a_slope.scaled(c1));
        let slope = wall_slope.times(lambda.times(lambda).scaled(bessel)).rounded() + k;
        (pressure, slope)
    }
}

/// Pressure (kPa) and its slope (kPa/rad) at a bend of `alpha` rad, for the coefficients k, c1, c2 in kPa.
///
/// Meant for 0 < alpha < pi; at and below zero both are those of alpha = 0 (pressure 0, slope k), from the f64 nearest
/// to pi on the pressure is infinite (the model's pole).
#[must_use]
pub fn pressure_and_slope(coefficients: &[f64; 3], alpha: f64) -> (f64, f64) {
    if alpha <= 0.0 {
        return (0.0, coefficients[0]);
    }
    if alpha >= PI {
        return (f64::INFINITY, f64::INFINITY);
    }
    let shape = if alpha < SERIES_BELOW {
        Shape::near(Double { high: alpha, low: 0.0 })
    } else {
        // Exact: the two differ by less than a factor of two.
        let distance = PI - alpha;
        let high = distance + PI_LOW;
        Shape::far(Double { high, low: (distance - high) + PI_LOW })
    };
    shape.pressure_and_slope(coefficients)
}

/// The gauge pressure in kPa that holds one segment at `angle_deg` (0..180 degrees), for k, c1, c2 in kPa.
///
/// Zero at and below zero degrees, infinite from 180 degrees on. The angle is taken as the exact number that it is:
/// no rounding to radians comes in between.
#[must_use]
pub fn pressure_from_angle_kpa(coefficients: &[f64; 3], angle_deg: f64) -> f64 {
    let radians = |degrees: f64| {
        let Double { high, low } = Double::product(degrees, DEGREE);
        Double { high, low: low + degrees * DEGREE_LOW }
    };
    if angle_deg <= 0.0 {
        return 0.0;
    }
    if angle_deg >= 180.0 {
        return f64::INFINITY;
    }
    let shape = if angle_deg < SERIES_BELOW_DEG {
        Shape::near(radians(angle_deg))
    } else {
        // The difference is exact.
        Shape::far(radians(180.0 - angle_deg))
    };
    shape.pressure_and_slope(coefficients).0
}

/// The bend in radians (0..pi) of one segment under a gauge pressure in kPa, for k, c1, c2 in kPa.
///
/// Zero and vacuum give zero. The result is one of the two neighbouring f64 between which the model crosses the
/// pressure, so it is as good as [`pressure_and_slope`] is.
#[must_use]
pub fn angle_from_pressure_rad(coefficients: &[f64; 3], pressure_kpa: f64) -> f64 {
    if pressure_kpa.is_nan() || pressure_kpa <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0_u64, PI.to_bits());
    let mut try_at = |angle: f64| {
        let (pressure, slope) = pressure_and_slope(coefficients, angle);
        let bits = angle.to_bits();
        if pressure < pressure_kpa {
            low = low.max(bits);
        } else {
            high = high.min(bits);
        }
        angle - (pressure - pressure_kpa) / slope
    };
    // Newton finds the neighbourhood, from the root of 4 c1 a^2 + k a = P, the model near 0 ...
    let [k, c1, _] = *coefficients;
    let start = 2.0 * pressure_kpa / (k + (k * k + 16.0 * c1 * pressure_kpa).sqrt());
    let inside = |angle: f64| angle > 0.0 && angle < PI;
    let mut angle = if inside(start) { start } else { FAR_START };
    for _ in 0..MOST_STEPS {
        let next = try_at(angle);
        let settled = (next - angle).abs() <= 1e-9 * angle;
        angle = next;
        if settled || !inside(angle) {
            break;
        }
    }
    // ... of which both sides are tried ...
    for factor in [1.0 - 2.0 * f64::EPSILON, 1.0 + 2.0 * f64::EPSILON] {
        let beside = angle * factor;
        if inside(beside) {
            try_at(beside);
        }
    }
    // ... and bisection ends it, however far Newton came. The bits of positive floats are ordered as the floats are:
    // halving them reaches neighbouring floats in at most 62 steps, at every scale.
    while high - low > 1 {
        let middle = low.midpoint(high);
        if pressure_and_slope(coefficients, f64::from_bits(middle)).0 < pressure_kpa {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::from_bits(high)
}

/// The bend in degrees (0..180) of one segment under a gauge pressure in kPa, for k, c1, c2 in kPa; see
/// [`angle_from_pressure_rad`].
#[must_use]
pub fn angle_from_pressure_deg(coefficients: &[f64; 3], pressure_kpa: f64) -> f64 {
    angle_from_pressure_rad(coefficients, pressure_kpa).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Chamber with exoskeleton, and bare chamber.
    const EXO: [f64; 3] = [0.0, 13.84, 0.336];
    const BARE: [f64; 3] = [35.3, 7.24, 0.831];

    /// Angle (rad) and pressure (kPa) by 50 digits of mpmath, from the definition as it is written in the paper:
    /// `l = a/sin(a); A = 4*(l - l**-5); B = 2*A*(2*l*l + l**-4 - 3); P = k*a + c1*A + c2*B`.
    const BY_50_DIGITS: [([f64; 3], f64, f64); 16] = [
        (EXO, 1e-9, 5.536_000_000_000_001e-17),
        (EXO, 0.001, 5.535_998_339_200_516_6e-5),
        (EXO, 0.1, 0.551_944_355_473_814_2),
        (EXO, 0.5, 12.879_085_206_827_36),
        (EXO, 1.0, 43.105_456_965_972_33),
        (EXO, 1.5, 82.393_706_299_576_34),
        (EXO, 2.0, 160.058_612_289_041_18),
        (EXO, 2.9, 10_147.453_282_183_45),
        (BARE, 1e-9, 3.530_000_002_896_00e-8),
        (BARE, 0.001, 0.035_328_959_991_312_005),
        (BARE, 0.1, 3.818_735_638_223_042),
        (BARE, 0.5, 24.412_458_193_797_832),
        (BARE, 1.0, 59.158_963_249_696_85),
        (BARE, 1.5, 108.424_312_097_344_78),
        (BARE, 2.0, 231.104_632_285_375_86),
        (BARE, 2.9, 23_890.621_736_273_177),
    ];

    #[test]
    fn agrees_with_fifty_digits() {
        for (coefficients, alpha, expected) in BY_50_DIGITS {
            let pressure = pressure_and_slope(&coefficients, alpha).0;
            assert!((pressure / expected - 1.0).abs() < 1e-15, "{alpha}: {pressure} not {expected}");
        }
    }

    #[test]
    fn nothing_cancels_near_zero() {
        // P / (4 c1 a^2) = 1 - O(a^2): the leading term alone is exact to f64 below 1e-8.
        for exponent in -150..=-9 {
            let alpha = 10_f64.powi(exponent);
            let ratio = pressure_and_slope(&EXO, alpha).0 / (4.0 * EXO[1] * alpha * alpha);
            assert!((ratio - 1.0).abs() < 1e-14, "{alpha}: {ratio}");
        }
    }

    #[test]
    fn the_series_joins_the_closed_form() {
        let distance = (PI - SERIES_BELOW) + PI_LOW;
        let series = Shape::near(Double { high: SERIES_BELOW, low: 0.0 });
        let closed = Shape::far(Double { high: distance, low: 0.0 });
        assert!((series.t.rounded() / closed.t.rounded() - 1.0).abs() < 1e-15);
        assert!((series.mu.rounded() / closed.mu.rounded() - 1.0).abs() < 1e-15);
        assert!((series.bessel / closed.bessel - 1.0).abs() < 1e-15);
    }

    #[test]
    fn ends_of_the_domain() {
        for pressure in [0.0, -0.0, -1e-300, -100.0, f64::NEG_INFINITY, f64::NAN] {
            assert!(angle_from_pressure_deg(&EXO, pressure).abs() <= 0.0);
        }
        assert!(angle_from_pressure_deg(&EXO, f64::MAX) <= 180.0);
        assert!(angle_from_pressure_deg(&EXO, f64::MIN_POSITIVE) > 0.0);
        assert!(pressure_from_angle_kpa(&EXO, -5.0).abs() <= 0.0);
        assert!(pressure_from_angle_kpa(&EXO, 180.0).is_infinite());
    }

    #[test]
    fn agrees_with_the_paper_within_its_fit() {
        // Table 2, chamber with exoskeleton.
        for (pressure, measured) in [(30.0, 46.3), (60.0, 71.0), (90.0, 89.6), (120.0, 103.7), (150.0, 112.6)] {
            let bend = angle_from_pressure_deg(&EXO, pressure);
            assert!((bend / measured - 1.0_f64).abs() < 0.0085, "{pressure} kPa: {bend}");
        }
    }

    proptest! {
        #[test]
        fn round_trip(k in 0.0..60.0, c1 in 5.0..40.0, c2 in 0.0..2.0, exponent in -12.0..2.6) {
            let pressure = 10_f64.powf(exponent);
            let angle = angle_from_pressure_deg(&[k, c1, c2], pressure);
            let back = pressure_from_angle_kpa(&[k, c1, c2], angle);
            prop_assert!((back / pressure - 1.0_f64).abs() < 1e-13, "{} not {}", back, pressure);
        }

        #[test]
        fn the_slope_is_the_derivative(k in 0.0..60.0, c1 in 5.0..40.0, c2 in 0.0..2.0, alpha in 0.01..2.5) {
            let pressure = |alpha| pressure_and_slope(&[k, c1, c2], alpha).0;
            let step = 1e-4 * alpha;
            // Four points: error of order step^4.
            let difference = (8.0 * (pressure(alpha + step) - pressure(alpha - step))
                - (pressure(alpha + 2.0 * step) - pressure(alpha - 2.0 * step)))
                / (12.0 * step);
            let slope = pressure_and_slope(&[k, c1, c2], alpha).1;
            prop_assert!((slope / difference - 1.0_f64).abs() < 1e-8, "{} not {}", slope, difference);
        }
    }
}
