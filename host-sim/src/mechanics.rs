//! The finger's model in f64, by its own route: the reference that the fixed-point core is held against, and the
//! plant's mechanics.
//!
//! With alpha the bend of one segment (rad) and lambda = alpha / sin(alpha),
//! `P(alpha) = k alpha + c1 A + c2 B` in kPa, `A = 4 (lambda - lambda^-5)`, `B = 2 A (I1 - 3)`,
//! `I1 = 2 lambda^2 + lambda^-4`.
//!
//! Near alpha = 0 the differences `lambda - lambda^-5` and `I1 - 3` cancel in all but their last digits. Written in
//! `mu = sin(alpha) / alpha` and `t = 1 - mu` they factor, and nothing is subtracted any more:
//! `A = 4 lambda (1 - mu^6) = 4 lambda t (1 + mu) (1 + mu^2 + mu^4)` and
//! `I1 - 3 = lambda^2 t^2 (2 - t)^2 (2 + mu^2)`; `t` itself comes from its series where `1 - mu` would cancel.

use core::f64::consts::PI;

/// Below this angle (rad) `t` and `dlambda/dalpha` come from their series: eight terms leave less than 1e-16 there.
const SERIES_BELOW: f64 = 1.0;

/// `1 - sin(a) / a`, to full relative precision.
fn one_minus_sinc(alpha: f64) -> f64 {
    if alpha >= SERIES_BELOW {
        return 1.0 - alpha.sin() / alpha;
    }
    // a^2/3! - a^4/5! + a^6/7! - ...: each term is the one before times -a^2 / ((2n)(2n + 1)).
    let x = alpha * alpha;
    let inner = [16.0 * 17.0, 14.0 * 15.0, 12.0 * 13.0, 10.0 * 11.0, 8.0 * 9.0, 6.0 * 7.0, 4.0 * 5.0];
    inner.iter().fold(1.0, |sum, divisor| 1.0 - x / divisor * sum) * x / 6.0
}

/// `(sin a - a cos a) / a^2`, the spherical Bessel function j1; `dlambda/dalpha = lambda^2 j1(alpha)`.
fn spherical_bessel_1(alpha: f64) -> f64 {
    if alpha >= SERIES_BELOW {
        return (alpha.sin() - alpha * alpha.cos()) / (alpha * alpha);
    }
    // a/3 (1 - x/(2*5) (1 - x/(4*7) (1 - x/(6*9) ...))) with x = a^2.
    let x = alpha * alpha;
    let inner = [14.0 * 17.0, 12.0 * 15.0, 10.0 * 13.0, 8.0 * 11.0, 6.0 * 9.0, 4.0 * 7.0, 2.0 * 5.0];
    inner.iter().fold(1.0, |sum, divisor| 1.0 - x / divisor * sum) * alpha / 3.0
}

/// Pressure (kPa) and its slope (kPa/rad) at a bend of `alpha` rad, for the coefficients k, c1, c2 in kPa.
///
/// Meant for 0 < alpha < pi; at and below zero both are those of alpha = 0 (pressure 0, slope k), from pi on the
/// pressure is infinite (the model's pole).
#[must_use]
pub fn pressure_and_slope(coefficients: &[f64; 3], alpha: f64) -> (f64, f64) {
    let [k, c1, c2] = *coefficients;
    if alpha <= 0.0 {
        return (0.0, k);
    }
    if alpha >= PI {
        return (f64::INFINITY, f64::INFINITY);
    }
    let t = one_minus_sinc(alpha);
    let mu = 1.0 - t;
    let lambda = 1.0 / mu;
    let mu2 = mu * mu;
    let mu4 = mu2 * mu2;
    let a = 4.0 * lambda * t * (1.0 + mu) * (1.0 + mu2 + mu4);
    let spread = lambda * t * (2.0 - t);
    let i1_minus_3 = spread * spread * (2.0 + mu2);
    let pressure = k * alpha + a * (c1 + 2.0 * c2 * i1_minus_3);

    let a_slope = 4.0 + 20.0 * mu4 * mu2;
    let lambda_slope = lambda * lambda * spherical_bessel_1(alpha);
    // dB/dlambda = 2 A' (I1 - 3) + 2 A^2, because dI1/dlambda is A.
    let slope = k + lambda_slope * (c1 * a_slope + 2.0 * c2 * (a_slope * i1_minus_3 + a * a));
    (pressure, slope)
}

/// The gauge pressure in kPa that holds one segment at `angle_deg` (0..180 degrees), for k, c1, c2 in kPa.
///
/// Zero at and below zero degrees, infinite from 180 degrees on.
#[must_use]
pub fn pressure_from_angle_kpa(coefficients: &[f64; 3], angle_deg: f64) -> f64 {
    pressure_and_slope(coefficients, angle_deg.to_radians()).0
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
    // The bits of positive floats are ordered as the floats are. Halving them reaches neighbouring floats in at most
    // 62 steps, at every scale: halving the angle itself would take a thousand steps for the smallest pressures.
    let (mut low, mut high) = (0_u64, PI.to_bits());
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
            // At 2.9 rad the sine itself has lost two digits.
            let allowed = if alpha > 2.5 { 1e-13 } else { 3e-15 };
            assert!((pressure / expected - 1.0).abs() < allowed, "{alpha}: {pressure} not {expected}");
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
        let below = SERIES_BELOW.next_down();
        assert!((one_minus_sinc(below) / one_minus_sinc(SERIES_BELOW) - 1.0).abs() < 1e-14);
        assert!((spherical_bessel_1(below) / spherical_bessel_1(SERIES_BELOW) - 1.0).abs() < 1e-14);
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
