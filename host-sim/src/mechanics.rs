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
