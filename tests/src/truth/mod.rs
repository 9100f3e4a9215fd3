//! The finger's model to 50 digits, from the definition as the paper writes it, in arbitrary precision.
//!
//! Nothing is rearranged against cancellation: the subtractions cancel as they stand, and the working precision has the
//! bits to spare. So this shares no formula with `host_sim::mechanics` or `model_core::inverse`, which it judges.

pub mod table;

use astro_float_num::{BigFloat, Consts, Radix, RoundingMode, Sign};

/// Significant decimal digits of every value in the table.
pub const DIGITS: usize = 50;

/// Bits that a result keeps once nothing cancels: 50 digits are 167, the rest is for the pole (47 bits at 180 − 2⁻⁴⁰
/// degrees, five-fold in B) and for rounding.
const BASE_BITS: usize = 320;

const NEAREST: RoundingMode = RoundingMode::ToEven;

/// Newton's last step, relative, as a power of two: convergence is quadratic, so that what is left is of order 2⁻²⁴⁰.
const LAST_STEP: i32 = -120;

/// Newton with bisection gains at least a bit a step.
const MOST_STEPS: usize = 400;

/// One bend and what the model makes of it, free of any calibration.
#[derive(Clone, Debug)]
pub struct Forward {
    /// α in radians.
    pub alpha: BigFloat,
    /// A = dI1/dλ.
    pub a: BigFloat,
    /// B = 2 A (I1 − 3).
    pub b: BigFloat,
    /// dA/dα per radian.
    pub a_slope: BigFloat,
    /// dB/dα per radian.
    pub b_slope: BigFloat,
}

/// k, c1, c2 in 2⁻²⁴ kPa, as `model_core::units::Coefficients` holds them: exact.
pub type CoefficientBits = [i32; 3];

/// The coefficients in kPa, exact.
#[must_use]
pub fn coefficients_kpa(bits: CoefficientBits) -> [f64; 3] {
    bits.map(|bits| f64::from(bits) / f64::from(1 << 24))
}

/// A computer of true values, with its cache of π.
pub struct Definition {
    constants: Consts,
}

impl Default for Definition {
    fn default() -> Self {
        Self::new()
    }
}

impl Definition {
    /// # Panics
    /// When there is no memory for the constants.
    #[must_use]
    pub fn new() -> Self {
        Self { constants: Consts::new().expect("memory for the constants") }
    }

    /// α, A, B and their slopes at a bend in degrees, above 0 and below 180, taken as the exact number that the f64 is.
    #[must_use]
    pub fn forward(&mut self, bend_deg: f64) -> Forward {
        let bits = working_bits(bend_deg.to_radians());
        let alpha = self.radians(&BigFloat::from_f64(bend_deg, bits), bits);
        self.at(alpha, bits)
    }

    /// The same at an angle in radians, above 0 and below π, taken as the exact number that the f64 is.
    #[must_use]
    pub fn forward_rad(&mut self, alpha: f64) -> Forward {
        let bits = working_bits(alpha);
        self.at(BigFloat::from_f64(alpha, bits), bits)
    }

    /// The definition itself, at α in radians.
    fn at(&mut self, alpha: BigFloat, bits: usize) -> Forward {
        let n = |value: u8| BigFloat::from_u8(value, bits);
        let add = |x: &BigFloat, y: &BigFloat| x.add(y, bits, NEAREST);
        let sub = |x: &BigFloat, y: &BigFloat| x.sub(y, bits, NEAREST);
        let mul = |x: &BigFloat, y: &BigFloat| x.mul(y, bits, NEAREST);
        let div = |x: &BigFloat, y: &BigFloat| x.div(y, bits, NEAREST);
        let power = |x: &BigFloat, exponent: usize| x.powi(exponent, bits, NEAREST);
        let sine = alpha.sin(bits, NEAREST, &mut self.constants);
        let cosine = alpha.cos(bits, NEAREST, &mut self.constants);

        let lambda = div(&alpha, &sine);
        // A = 4 (λ − λ⁻⁵), I1 = 2 λ² + λ⁻⁴, B = 2 A (I1 − 3).
        let a = mul(&n(4), &sub(&lambda, &div(&n(1), &power(&lambda, 5))));
        let invariant = add(&mul(&n(2), &power(&lambda, 2)), &div(&n(1), &power(&lambda, 4)));
        let excess = sub(&invariant, &n(3));
        let b = mul(&n(2), &mul(&a, &excess));
        // dλ/dα = (sin α − α cos α) / sin² α, dA/dλ = 4 (1 + 5 λ⁻⁶), dB/dλ = 2 (dA/dλ (I1 − 3) + A²).
        let lambda_slope = div(&sub(&sine, &mul(&alpha, &cosine)), &power(&sine, 2));
        let a_by_lambda = mul(&n(4), &add(&n(1), &div(&n(5), &power(&lambda, 6))));
        let b_by_lambda = mul(&n(2), &add(&mul(&a_by_lambda, &excess), &power(&a, 2)));
        Forward { a_slope: mul(&a_by_lambda, &lambda_slope), b_slope: mul(&b_by_lambda, &lambda_slope), alpha, a, b }
    }

    /// The bend in degrees at which the model holds a pressure in kPa above zero, taken as the exact number that the
    /// f64 is.
    ///
    /// # Panics
    /// When the iteration does not settle, which would be an error in it.
    #[must_use]
    pub fn inverse(&mut self, coefficients: CoefficientBits, pressure_kpa: f64) -> BigFloat {
        let [k, c1, _] = coefficients_kpa(coefficients);
        // The root of 4 c1 α² + k α = P, the model near 0; below π in any case.
        let start = 2.0 * pressure_kpa / (k + (k * k + 16.0 * c1 * pressure_kpa).sqrt());
        let bits = working_bits(start);
        let target = BigFloat::from_f64(pressure_kpa, bits);
        let half = BigFloat::from_f64(0.5, bits);
        let mut alpha = BigFloat::from_f64(start.min(3.0), bits);
        let mut low = BigFloat::new(bits);
        let mut high = self.constants.pi(bits, NEAREST);
        for _ in 0..MOST_STEPS {
            let here = self.at(alpha.clone(), bits);
            let excess = pressure(coefficients, &here).sub(&target, bits, NEAREST);
            let step = excess.div(&slope(coefficients, &here), bits, NEAREST);
            if step.is_zero() || exponent(&step) < exponent(&alpha) + LAST_STEP {
                let alpha = alpha.sub(&step, bits, NEAREST);
                return self.degrees(&alpha, bits);
            }
            if excess.is_positive() {
                high = alpha.clone();
            } else {
                low = alpha.clone();
            }
            let newton = alpha.sub(&step, bits, NEAREST);
            let inside = newton > low && newton < high;
            alpha = if inside { newton } else { low.add(&high, bits, NEAREST).mul(&half, bits, NEAREST) };
        }
        panic!("no bend found at {pressure_kpa} kPa for {coefficients:?}");
    }

    fn radians(&mut self, degrees: &BigFloat, bits: usize) -> BigFloat {
        let pi = self.constants.pi(bits, NEAREST);
        degrees.mul(&pi, bits, NEAREST).div(&BigFloat::from_u8(180, bits), bits, NEAREST)
    }

    fn degrees(&mut self, radians: &BigFloat, bits: usize) -> BigFloat {
        let pi = self.constants.pi(bits, NEAREST);
        radians.mul(&BigFloat::from_u8(180, bits), bits, NEAREST).div(&pi, bits, NEAREST)
    }

    /// Rounded to [`DIGITS`] significant digits, such as `1.2345e-7`.
    ///
    /// # Panics
    /// On zero, a negative number or one that is not finite: the table has none.
    #[must_use]
    pub fn decimal(&mut self, value: &BigFloat) -> String {
        let (sign, mut digits, mut exponent) =
            value.convert_to_radix(Radix::Dec, NEAREST, &mut self.constants).expect("a finite number");
        assert!(sign == Sign::Pos && digits.first().is_some_and(|&digit| digit > 0), "{value:?}");
        // A half rounds up: with a hundred digits behind it, none is exact.
        let rounds_up = digits.get(DIGITS).is_some_and(|&digit| digit >= 5);
        digits.resize(DIGITS, 0);
        if rounds_up {
            let kept = digits.iter().rposition(|&digit| digit != 9);
            let first_nine = kept.map_or(0, |index| index + 1);
            digits[first_nine..].fill(0);
            if let Some(index) = kept {
                digits[index] += 1;
            } else {
                digits[0] = 1;
                exponent += 1;
            }
        }
        // The library's exponent belongs to 0.ddd.
        let mut text: String = digits.iter().map(|&digit| char::from(b'0' + digit)).collect();
        text.insert(1, '.');
        format!("{text}e{}", exponent - 1)
    }

    /// The number that a decimal of the table stands for, to 256 bits.
    #[must_use]
    pub fn parse(&mut self, decimal: &str) -> BigFloat {
        BigFloat::parse(decimal, Radix::Dec, 256, NEAREST, &mut self.constants)
    }
}

/// λ − 1 is of order α², I1 − 3 of order α⁴: that many bits cancel, once each.
fn working_bits(alpha: f64) -> usize {
    let octaves = (-alpha.log2()).ceil().max(0.0) as usize;
    BASE_BITS + 4 * octaves
}

/// k α + c1 A + c2 B in kPa.
#[must_use]
pub fn pressure(coefficients: CoefficientBits, at: &Forward) -> BigFloat {
    combination(coefficients, &at.alpha, &at.a, &at.b)
}

/// dP/dα in kPa per radian.
#[must_use]
pub fn slope(coefficients: CoefficientBits, at: &Forward) -> BigFloat {
    combination(coefficients, &BigFloat::from_u8(1, 64), &at.a_slope, &at.b_slope)
}

fn combination(coefficients: CoefficientBits, by_k: &BigFloat, by_c1: &BigFloat, by_c2: &BigFloat) -> BigFloat {
    let bits = by_c1.precision().unwrap_or(BASE_BITS);
    let [k, c1, c2] = coefficients_kpa(coefficients).map(|kpa| BigFloat::from_f64(kpa, bits));
    let sum = k.mul(by_k, bits, NEAREST).add(&c1.mul(by_c1, bits, NEAREST), bits, NEAREST);
    sum.add(&c2.mul(by_c2, bits, NEAREST), bits, NEAREST)
}

/// e with 2^(e−1) <= |value| < 2^e.
fn exponent(value: &BigFloat) -> i32 {
    value.exponent().unwrap_or(i32::MIN)
}

/// The nearest f64 but for its last bit; meant for ratios and errors.
#[must_use]
pub fn to_f64(value: &BigFloat) -> f64 {
    let Some((words, _, sign, exponent, _)) = value.as_raw_parts() else { return f64::NAN };
    let Some(&top) = words.last() else { return 0.0 };
    // 0.m times a power of two; two factors, so that neither leaves the range of normal numbers.
    let half = exponent / 2;
    let magnitude = top as f64 * 2.0_f64.powi(-64) * 2.0_f64.powi(half) * 2.0_f64.powi(exponent - half);
    if sign == Sign::Neg { -magnitude } else { magnitude }
}

/// `found` less `exact`, as f64: the difference is taken in full precision.
#[must_use]
pub fn error(found: f64, exact: &BigFloat) -> f64 {
    to_f64(&BigFloat::from_f64(found, 64).sub(exact, 256, NEAREST))
}

/// `found` less `exact` in units of the last place of an f64 of `exact`'s size.
#[must_use]
pub fn error_ulp(found: f64, exact: &BigFloat) -> f64 {
    // An f64 has 53 bits: its last place, for 2^(e−1) <= x < 2^e, is 2^(e−53).
    error(found, exact) / 2.0_f64.powi(exponent(exact) - 53)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_round_and_carry() {
        let mut definition = Definition::new();
        let mut rounded = |text: &str| {
            let value = BigFloat::parse(text, Radix::Dec, 512, NEAREST, &mut definition.constants);
            definition.decimal(&value)
        };
        let zeros = "0".repeat(48);
        assert_eq!(rounded("1"), format!("1.0{zeros}e0"));
        assert_eq!(rounded(&"9".repeat(60)), format!("1.0{zeros}e60"));
        assert_eq!(rounded(&format!("1.{zeros}149")), format!("1.{zeros}1e0"));
        assert_eq!(rounded(&format!("1.{zeros}951e-7")), format!("1.{}10e-7", "0".repeat(47)));
        assert_eq!(rounded("0.00125"), format!("1.25{}e-3", "0".repeat(47)));
    }

    #[test]
    fn conversions_to_f64_keep_value_and_sign() {
        for value in [1.0, -0.3, 6.02e23, -1.6e-300, f64::MIN_POSITIVE, f64::MAX] {
            let relative = to_f64(&BigFloat::from_f64(value, 128)) / value - 1.0;
            assert!(relative.abs() < 1e-15, "{value}: {relative}");
        }
        assert!(to_f64(&BigFloat::new(128)).abs() <= 0.0);
        // One ulp of a number in 1..2 is 2^-52.
        assert!((error_ulp(1.5_f64.next_up(), &BigFloat::from_f64(1.5, 128)) - 1.0).abs() < 1e-12);
    }

    /// Known in closed form: at 90 degrees λ = π/2, and dλ/dα = 1.
    #[test]
    fn a_right_angle_is_half_pi() {
        let mut definition = Definition::new();
        let here = definition.forward(90.0);
        let half_pi = definition.parse("1.5707963267948966192313216916397514420985846996875529");
        let bits = 256;
        let sixth = half_pi.powi(6, bits, NEAREST).reciprocal(bits, NEAREST);
        let n = |value: u8| BigFloat::from_u8(value, bits);
        let expected_slope = n(4).add(&n(20).mul(&sixth, bits, NEAREST), bits, NEAREST);
        let expected_a = n(4).mul(&half_pi, bits, NEAREST).mul(&n(1).sub(&sixth, bits, NEAREST), bits, NEAREST);
        for (found, expected) in [(&here.alpha, &half_pi), (&here.a_slope, &expected_slope), (&here.a, &expected_a)] {
            assert!((to_f64(&found.sub(expected, bits, NEAREST))).abs() < 1e-49);
        }
    }

    /// The inverse meets the definition: one unit of the 50th digit either way crosses the pressure.
    #[test]
    fn the_inverse_is_bracketed() {
        let mut definition = Definition::new();
        for coefficients in [[0, 5 << 24, 0], [60 << 24, 40 << 24, 2 << 24]] {
            for kpa in [1e-6, 0.37, 30.0, 1000.0] {
                let bits = BASE_BITS + 64;
                let bend = definition.inverse(coefficients, kpa);
                let mut at = |change: f64| {
                    let factor = BigFloat::from_f64(1.0, bits).add(&BigFloat::from_f64(change, bits), bits, NEAREST);
                    let alpha = definition.radians(&bend.mul(&factor, bits, NEAREST), bits);
                    pressure(coefficients, &definition.at(alpha, bits))
                };
                let target = BigFloat::from_f64(kpa, bits);
                assert!(at(-1e-50) < target && target < at(1e-50), "{coefficients:?} {kpa}");
            }
        }
    }
}
