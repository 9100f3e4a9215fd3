//! Quantities with their units: newtypes over `fixed`, saturating, totally ordered, `const`-constructible.
//!
//! ```
//! use model_core::units::{Bend, Coefficients, CoefficientError, Millis, Pressure};
//! use fixed::types::I8F24;
//!
//! const HIGHEST: Pressure = Pressure::from_kpa(150);
//! assert_eq!(Pressure::from_milli_kpa(60_500).to_bits(), 60 * 65_536 + 32_768);
//! assert!(HIGHEST - Pressure::from_kpa(30) > Pressure::from_kpa(119));
//! assert_eq!(Bend::MAX + Bend::LSB, Bend::MAX); // saturates
//! assert_eq!(Millis(5).since(Millis(7)), Millis::ZERO);
//!
//! let kpa = |text: f64| I8F24::from_num(text);
//! assert!(Coefficients::new(kpa(0.0), kpa(13.8), kpa(0.34)).is_ok());
//! assert_eq!(Coefficients::new(kpa(0.0), kpa(4.0), kpa(0.34)), Err(CoefficientError::C1)); // c1 is 5..=40 kPa
//! ```

use core::ops::{Add, Sub};
use fixed::types::{I8F24, I16F16};

/// Makes a newtype over I16F16 with saturating arithmetic, named after its quantity and unit.
macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $unit:literal, $whole:ident, $milli:ident, $bits:ident, $host:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct $name(I16F16);

        impl $name {
            /// Zero.
            pub const ZERO: Self = Self(I16F16::ZERO);
            /// The largest representable value, 32767.99998.
            pub const MAX: Self = Self(I16F16::MAX);
            /// The smallest representable value, -32768.
            pub const MIN: Self = Self(I16F16::MIN);
            /// The resolution, 2^-16.
            pub const LSB: Self = Self(I16F16::DELTA);

            #[doc = concat!("From whole ", $unit, ".")]
            #[must_use]
            pub const fn $whole(value: i16) -> Self {
                Self(I16F16::from_bits((value as i32) << 16))
            }

            #[doc = concat!("From thousandths of ", $unit, ", rounded to nearest; saturates beyond 32767.")]
            #[must_use]
            pub const fn $milli(value: i32) -> Self {
                let scaled = value as i64 * 65_536;
                let half = if value < 0 { -500 } else { 500 };
                let bits = (scaled + half) / 1000;
                Self(I16F16::from_bits(if bits > i32::MAX as i64 {
                    i32::MAX
                } else if bits < i32::MIN as i64 {
                    i32::MIN
                } else {
                    bits as i32
                }))
            }

            #[doc = concat!("From raw bits, in 2^-16 ", $unit, ".")]
            #[must_use]
            pub const fn $bits(bits: i32) -> Self {
                Self(I16F16::from_bits(bits))
            }

            #[doc = concat!("Raw bits, in 2^-16 ", $unit, ".")]
            #[must_use]
            pub const fn to_bits(self) -> i32 {
                self.0.to_bits()
            }

            #[doc = concat!("The value in ", $unit, " as I16F16.")]
            #[must_use]
            pub const fn to_fixed(self) -> I16F16 {
                self.0
            }

            #[doc = concat!("From I16F16 in ", $unit, ".")]
            #[must_use]
            pub const fn from_fixed(value: I16F16) -> Self {
                Self(value)
            }

            /// The absolute value; the smallest value saturates.
            #[must_use]
            pub const fn abs(self) -> Self {
                Self(self.0.saturating_abs())
            }

            /// Times a dimensionless factor, saturating, rounded towards minus infinity.
            #[must_use]
            pub fn scaled(self, factor: I16F16) -> Self {
                Self(self.0.saturating_mul(factor))
            }

            /// Half way between two values, without overflow.
            #[must_use]
            pub const fn midpoint(self, other: Self) -> Self {
                Self(I16F16::from_bits(self.0.to_bits().midpoint(other.0.to_bits())))
            }

            /// A tick of a first-order low pass with a time constant of 2^`shift` ticks; rounded towards minus infinity.
            #[must_use]
            pub const fn low_passed(self, input: Self, shift: u32) -> Self {
                // A part of the way between two values lies between them: nothing saturates.
                let way = input.to_bits() as i64 - self.to_bits() as i64;
                Self::$bits((self.to_bits() as i64 + way.unbounded_shr(shift)) as i32)
            }

            #[doc = concat!("From ", $unit, " as f64, to the nearest; saturates, and a NaN gives zero.")]
            #[cfg(any(test, feature = "host"))]
            #[must_use]
            pub fn $host(value: f64) -> Self {
                // `as` saturates and turns NaN into 0.
                Self(I16F16::from_bits((value * 65_536.0).round() as i32))
            }

            #[doc = concat!("In ", $unit, " as f64, exact.")]
            #[cfg(any(test, feature = "host"))]
            #[must_use]
            pub fn to_f64(self) -> f64 {
                self.0.to_num::<f64>()
            }
        }

        impl Add for $name {
            type Output = Self;
            /// Saturating.
            fn add(self, other: Self) -> Self {
                Self(self.0.saturating_add(other.0))
            }
        }

        impl Sub for $name {
            type Output = Self;
            /// Saturating.
            fn sub(self, other: Self) -> Self {
                Self(self.0.saturating_sub(other.0))
            }
        }
    };
}

quantity!(
    /// Gauge pressure in kPa, resolution 2^-16 kPa, range ±32768 kPa.
    Pressure, "kPa", from_kpa, from_milli_kpa, from_bits, from_f64_kpa
);
quantity!(
    /// Bend of one segment in degrees, resolution 2^-16 degree, range ±32768 degrees.
    Bend, "degrees", from_deg, from_milli_deg, from_bits, from_f64_deg
);
quantity!(
    /// Length in millimetres, resolution 2^-16 mm, range ±32768 mm.
    Length, "mm", from_mm, from_um, from_bits, from_f64_mm
);
quantity!(
    /// Force in newtons, resolution 2^-16 N, range ±32768 N.
    Force, "N", from_newtons, from_milli_newtons, from_bits, from_f64_newtons
);

/// A duration or a time since start in milliseconds; one controller tick is one millisecond.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Millis(pub u32);

impl Millis {
    /// No time.
    pub const ZERO: Self = Self(0);

    /// The time from `earlier` to this one; zero when it lies in the future.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Self {
        Self(self.0.saturating_sub(earlier.0))
    }
}

impl Add for Millis {
    type Output = Self;
    /// Saturating, at 49 days.
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

/// The model's three coefficients, in kPa: bending stiffness k (per radian) and the two Yeoh terms c1, c2.
///
/// Resolution 2^-24 kPa, range ±128 kPa. The admitted range is k 0..60, c1 5..40, c2 0..2 kPa; see
/// [`Coefficients::new`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coefficients {
    k: I8F24,
    c1: I8F24,
    c2: I8F24,
}

/// A coefficient outside its admitted range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoefficientError {
    /// k must lie in 0..=60 kPa.
    K,
    /// c1 must lie in 5..=40 kPa.
    C1,
    /// c2 must lie in 0..=2 kPa.
    C2,
}

impl Coefficients {
    /// The admitted ranges of c1, c2 and k, in 2^-24 kPa.
    pub(crate) const RANGES: [[i32; 2]; 3] = [[5 << 24, 40 << 24], [0, 2 << 24], [0, 60 << 24]];

    /// Checks the admitted range.
    ///
    /// # Errors
    /// Names the first coefficient outside k 0..=60, c1 5..=40, c2 0..=2 kPa.
    pub const fn new(k: I8F24, c1: I8F24, c2: I8F24) -> Result<Self, CoefficientError> {
        const fn within(value: I8F24, [low, high]: [i32; 2]) -> bool {
            value.to_bits() >= low && value.to_bits() <= high
        }
        let [c1_range, c2_range, k_range] = Self::RANGES;
        if !within(k, k_range) {
            Err(CoefficientError::K)
        } else if !within(c1, c1_range) {
            Err(CoefficientError::C1)
        } else if !within(c2, c2_range) {
            Err(CoefficientError::C2)
        } else {
            Ok(Self { k, c1, c2 })
        }
    }

    /// Bending stiffness in kPa per radian.
    #[must_use]
    pub const fn k(self) -> I8F24 {
        self.k
    }

    /// First Yeoh term in kPa.
    #[must_use]
    pub const fn c1(self) -> I8F24 {
        self.c1
    }

    /// Second Yeoh term in kPa.
    #[must_use]
    pub const fn c2(self) -> I8F24 {
        self.c2
    }

    /// From f64 kPa, each rounded to 2^-24 kPa.
    ///
    /// # Errors
    /// As [`Coefficients::new`]; a NaN is outside every range.
    #[cfg(any(test, feature = "host"))]
    pub fn from_f64_kpa(k: f64, c1: f64, c2: f64) -> Result<Self, CoefficientError> {
        let to_fixed = |value: f64| {
            if value.is_nan() { I8F24::MIN } else { I8F24::saturating_from_num(value) }
        };
        Self::new(to_fixed(k), to_fixed(c1), to_fixed(c2))
    }

    /// As f64 kPa, exact: k, c1, c2.
    #[cfg(any(test, feature = "host"))]
    #[must_use]
    pub fn to_f64_kpa(self) -> [f64; 3] {
        [self.k.to_num(), self.c1.to_num(), self.c2.to_num()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_saturates_at_both_ends() {
        assert_eq!(Pressure::MAX + Pressure::LSB, Pressure::MAX);
        assert_eq!(Pressure::MIN - Pressure::LSB, Pressure::MIN);
        assert_eq!(Pressure::MIN.abs(), Pressure::MAX);
        assert_eq!(Bend::from_milli_deg(i32::MAX), Bend::MAX);
        assert_eq!(Bend::from_milli_deg(i32::MIN), Bend::MIN);
    }

    #[test]
    fn a_low_pass_comes_to_its_input_from_above_and_within_its_last_bits_from_below() {
        let input = Bend::from_deg(30);
        let rest = |from: Bend| (0..2000).fold(from, |state, _| state.low_passed(input, 3));
        assert_eq!(rest(Bend::MAX), input);
        assert_eq!(rest(Bend::MIN), Bend::from_bits(input.to_bits() - 7));
        // An eighth of the way, whatever its length; none of it when the time constant is endless.
        assert_eq!(Bend::MIN.low_passed(Bend::MAX, 3).to_bits(), i32::MIN + (1 << 29) - 1);
        assert_eq!(Bend::ZERO.low_passed(Bend::MAX, 64), Bend::ZERO);
    }

    #[test]
    fn thousandths_round_to_nearest() {
        for milli in [-32_768_000, -1501, -1, 0, 1, 7, 499, 150_000, 32_767_999] {
            let exact = f64::from(milli) / 1000.0;
            assert!((Pressure::from_milli_kpa(milli).to_f64() - exact).abs() <= 0.5 / 65_536.0, "{milli}");
        }
    }

    #[test]
    fn float_conversions_saturate_and_take_nan_as_zero() {
        assert_eq!(Pressure::from_f64_kpa(1e9), Pressure::MAX);
        assert_eq!(Pressure::from_f64_kpa(f64::NEG_INFINITY), Pressure::MIN);
        assert_eq!(Pressure::from_f64_kpa(f64::NAN), Pressure::ZERO);
    }

    #[test]
    fn coefficients_name_the_one_out_of_range() {
        assert_eq!(Coefficients::from_f64_kpa(-0.1, 10.0, 0.3), Err(CoefficientError::K));
        assert_eq!(Coefficients::from_f64_kpa(0.0, 4.9, 0.3), Err(CoefficientError::C1));
        assert_eq!(Coefficients::from_f64_kpa(0.0, 10.0, f64::NAN), Err(CoefficientError::C2));
        assert!(Coefficients::from_f64_kpa(60.0, 40.0, 2.0).is_ok());
    }

    #[test]
    fn time_does_not_run_backwards() {
        assert_eq!(Millis(3).since(Millis(5)), Millis::ZERO);
        assert_eq!(Millis(u32::MAX) + Millis(1), Millis(u32::MAX));
    }
}
