//! The ways to compute α = f(P) and P = f⁻¹(α) that the core's own is compared with, side by side and under one trait.
//!
//! Nothing here runs on the finger: the feature `methods` is for comparisons (`host-sim pareto`, `cargo xtask pareto`),
//! on the host and on the emulated Cortex-M4, so that all of it is `no_std` too. Floats are allowed here.

use crate::units::{Bend, Coefficients, Pressure};

mod fixed_newton;

pub use fixed_newton::FixedNewton;

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
    ($callback:path) => {
        $callback! {
            fixed_newton: $crate::methods::FixedNewton;
        }
    };
}

macro_rules! fixed_quantity {
    ($name:ident) => {
        impl Quantity for $name {
            const REPRESENTATION: Representation = Representation::Fixed;
            fn from_f64(value: f64) -> Self {
                // `as` truncates, saturates and turns NaN into 0; a half towards its own sign rounds to nearest.
                let scaled = value * 65_536.0;
                Self::from_bits((if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i32)
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
