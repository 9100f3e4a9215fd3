//! The ways to compute α = f(P) and P = f⁻¹(α) side by side and under one trait: the core's own two, and those that they
//! are compared with.
//!
//! Nothing but the core's own runs on the finger: the feature `methods` is for comparisons (`host-sim pareto`, `cargo xtask pareto`),
//! on the host and on the emulated Cortex-M4, so that all of it is `no_std` too. Floats are allowed here.

use crate::units::{Bend, Coefficients, Pressure};

mod cordic;
mod f32_floating_cubic;
mod f32_micromath;
mod f32_newton;
mod f32_newton_libm;
mod f32_newton_native;
mod f32_root_cubic;
mod f32_segments;
mod f64_newton;
mod fixed_newton;
mod floating;
mod floating_linear;
mod floating_quadratic;
mod minimax;
mod minimax_root;
mod nodes;
mod own;
mod polynomial;
#[cfg(test)]
pub(crate) mod reference;
mod remez;
mod uniform_cubic;
mod uniform_linear;

pub use cordic::Cordic;
pub use f32_floating_cubic::F32FloatingCubic;
pub use f32_micromath::F32Micromath;
pub use f32_newton_libm::F32NewtonLibm;
#[cfg(any(test, feature = "host"))]
pub use f32_newton_native::StdRoot;
pub use f32_newton_native::{F32NewtonNative, SquareRoot};
pub use f32_root_cubic::F32RootCubic;
pub use f64_newton::F64Newton;
pub use fixed_newton::FixedNewton;
pub use floating_linear::FloatingLinear;
pub use floating_quadratic::FloatingQuadratic;
pub use minimax::Minimax;
pub use minimax_root::MinimaxRoot;
pub use own::{FloatingQuartic, SegmentNewton};
pub use uniform_cubic::UniformCubic;
pub use uniform_linear::UniformLinear;

/// How a number travels to and from a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Representation {
    /// I16F16, in a core register.
    Fixed,
    /// IEEE single.
    F32,
    /// IEEE double.
    F64,
}

/// A pressure in kPa or a bend in degrees, in whatever representation a method takes it.
pub trait Quantity: Copy {
    /// Which one.
    const REPRESENTATION: Representation;
    /// The nearest representable value; the fixed-point ones saturate and take a NaN as zero.
    fn from_f64(value: f64) -> Self;
    /// Exact.
    fn to_f64(self) -> f64;
}

/// One way to compute both directions.
pub trait Method: Sized {
    /// On command lines and in tables, such as `fixed-newton`.
    const NAME: &'static str;
    /// One line for people.
    const SUMMARY: &'static str;
    /// kPa.
    type Pressure: Quantity;
    /// Degrees of one segment.
    type Bend: Quantity;

    /// Everything that depends on the calibration alone. What it costs is paid at a change of calibration; what it
    /// returns is the method's state in RAM.
    fn prepare(coefficients: &Coefficients) -> Self;
    /// α = f(P).
    fn bend_from_pressure(&self, pressure: Self::Pressure) -> Self::Bend;
    /// P = f⁻¹(α).
    fn pressure_from_bend(&self, bend: Self::Bend) -> Self::Pressure;
}

/// Calls `$callback! { identifier: Type; ... }` with all methods. The type `Root` in scope where it is called is the
/// square root that `f32-newton-native` is to use.
#[macro_export]
macro_rules! for_each_method {
    ($($callback:ident)::+) => {
        $($callback)::+! {
            segment_newton: $crate::methods::SegmentNewton;
            floating_quartic: $crate::methods::FloatingQuartic;
            fixed_newton: $crate::methods::FixedNewton;
            f64_newton: $crate::methods::F64Newton;
            f32_newton_libm: $crate::methods::F32NewtonLibm;
            f32_newton_native: $crate::methods::F32NewtonNative<Root>;
            f32_micromath: $crate::methods::F32Micromath;
            uniform_linear: $crate::methods::UniformLinear;
            uniform_cubic: $crate::methods::UniformCubic;
            floating_linear: $crate::methods::FloatingLinear;
            floating_quadratic: $crate::methods::FloatingQuadratic;
            minimax: $crate::methods::Minimax;
            minimax_root: $crate::methods::MinimaxRoot;
            cordic: $crate::methods::Cordic;
            f32_floating_cubic: $crate::methods::F32FloatingCubic;
            f32_root_cubic: $crate::methods::F32RootCubic<Root>;
        }
    };
}

/// The end of the model's domain in kPa; above, every method returns the bend here.
const PRESSURE_LIMIT_KPA: f64 = 1000.0;
/// The end of the model's domain in degrees; above, every method returns the pressure here.
const BEND_LIMIT_DEG: f64 = 170.0;

/// Where tables of bends end: beyond the domain, so that no interval inside it has a kink where the bend saturates, and
/// short of the pole.
const TABLE_LIMIT_DEG: f64 = 179.5;

/// `value` inside `low`..`high`; a NaN gives `low`. By comparisons, because a Cortex-M4F has no instructions for a float's `min`
/// and `max`, and calls functions for them.
fn within<Float: PartialOrd>(value: Float, low: Float, high: Float) -> Float {
    if value > low { if value < high { value } else { high } } else { low }
}

/// k, c1 and c2 in kPa, exact.
fn coefficients_kpa(coefficients: &Coefficients) -> [f64; 3] {
    [coefficients.k(), coefficients.c1(), coefficients.c2()].map(|c| f64::from(c.to_bits()) / f64::from(1 << 24))
}

/// The nearest multiple of 2^-`fraction_bits`, as an integer; saturates.
fn fixed(value: f64, fraction_bits: u32) -> i32 {
    let scaled = value * (1_u64 << fraction_bits) as f64;
    (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i32
}

macro_rules! fixed_quantity {
    ($name:ident) => {
        impl Quantity for $name {
            const REPRESENTATION: Representation = Representation::Fixed;
            fn from_f64(value: f64) -> Self {
                // `as` truncates, saturates and turns NaN into 0; a half towards its own sign rounds to nearest.
                Self::from_bits(fixed(value, 16))
            }
            fn to_f64(self) -> f64 {
                f64::from(self.to_bits()) / 65_536.0
            }
        }
    };
}

fixed_quantity!(Pressure);
fixed_quantity!(Bend);

impl Quantity for f32 {
    const REPRESENTATION: Representation = Representation::F32;
    fn from_f64(value: f64) -> Self {
        value as Self
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Quantity for f64 {
    const REPRESENTATION: Representation = Representation::F64;
    fn from_f64(value: f64) -> Self {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fixed::types::I8F24;
    use proptest::prelude::*;

    /// Any bits as an input, of any calibration: no panic, and a result inside the domain.
    fn stays_inside<M: Method>(coefficients: &Coefficients, bits: &[u64]) {
        let method = M::prepare(coefficients);
        for &bits in bits {
            // As a double, a single and a fixed-point number in turn, NaN and infinities among them.
            let values =
                [f64::from_bits(bits), f64::from(f32::from_bits(bits as u32)), f64::from(bits as i32) / 65_536.0];
            for value in values {
                let bend = method.bend_from_pressure(M::Pressure::from_f64(value)).to_f64();
                let pressure = method.pressure_from_bend(M::Bend::from_f64(value)).to_f64();
                assert!((0.0..=170.0).contains(&bend), "{} at {value} kPa: {bend}", M::NAME);
                // 162 000 kPa, and micromath's error.
                assert!((0.0..=170_000.0).contains(&pressure), "{} at {value} degrees: {pressure}", M::NAME);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn every_input_of_every_calibration_stays_inside(
            k in 0..=60_i32 << 24,
            c1 in 5 << 24..=40_i32 << 24,
            c2 in 0..=2_i32 << 24,
            bits in prop::collection::vec(any::<u64>(), 300),
        ) {
            type Root = StdRoot;
            let coefficients =
                Coefficients::new(I8F24::from_bits(k), I8F24::from_bits(c1), I8F24::from_bits(c2)).unwrap();
            macro_rules! all_stay_inside {
                ($($name:ident: $method:ty;)*) => { $(stays_inside::<$method>(&coefficients, &bits);)* };
            }
            for_each_method!(all_stay_inside);
        }
    }
}
