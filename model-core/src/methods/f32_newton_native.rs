//! Newton in f32 with polynomials of its own and the hardware's square root: the fair float peer on a Cortex-M4F.
//!
//! What the model needs is no sine but t = 1 − sin α / α and μ = sin α / α. With x = α², t = x h(x) below 90 degrees with
//! a polynomial h of degree 4, and above μ = (1 − x/π²) q(x) with a q of degree 5: the factor 1 − x/π² carries the zero at
//! 180 degrees and is exact to f32 when it is written (180 − bend) (180 + bend) / 180². One polynomial of degree 4 gives dt/dα,
//! for Newton's steps alone.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core f32_newton_native -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 1.9e-5 | 4.6e-4 |
//! | bare chamber | 1.7e-5 | 4.1e-4 |
//! | worst corner | 2.1e-5 | 6.5e-4 |

use super::f32_newton::{Arithmetic, F32Newton, RADIANS, Shortening};
use super::polynomial::{chebyshev_points, evaluate, series, through};
use core::fmt::Debug;
use core::marker::PhantomData;

/// A square root in f32 that is as good as the target has it.
pub trait SquareRoot {
    /// √x for x >= 0.
    fn sqrt(x: f32) -> f32;
}

/// The standard library's, which is the host's instruction.
#[cfg(any(test, feature = "host"))]
#[derive(Clone, Copy, Debug)]
pub struct StdRoot;

#[cfg(any(test, feature = "host"))]
impl SquareRoot for StdRoot {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }
}

/// See the module.
pub type F32NewtonNative<Root> = F32Newton<Native<Root>>;

/// Polynomials and `Root`.
#[derive(Clone, Copy, Debug)]
pub struct Native<Root>(PhantomData<Root>);

/// π².
const PI_2: f64 = core::f64::consts::PI * core::f64::consts::PI;
/// x at 90 degrees.
const MIDDLE: f64 = PI_2 / 4.0;
/// x at 170 degrees.
const END: f64 = PI_2 * (17.0 / 18.0) * (17.0 / 18.0);

/// (1 − sin α / α) / x, 0..90 degrees.
const H: [f32; 5] = {
    let points = chebyshev_points(0.0, MIDDLE);
    let mut values = points;
    let mut i = 0;
    while i < points.len() {
        values[i] = series(points[i], 3, false);
        i += 1;
    }
    through(points, values)
};

/// sin α / α / (1 − x/π²), 90..170 degrees.
const Q: [f32; 6] = {
    let points = chebyshev_points(MIDDLE, END);
    let mut values = points;
    let mut i = 0;
    while i < points.len() {
        values[i] = series(points[i], 1, false) / (1.0 - points[i] / PI_2);
        i += 1;
    }
    through(points, values)
};

/// dt/dx, 0..170 degrees.
const SLOPE: [f32; 5] = {
    let points = chebyshev_points(0.0, END);
    let mut values = points;
    let mut i = 0;
    while i < points.len() {
        values[i] = series(points[i], 3, true);
        i += 1;
    }
    through(points, values)
};

impl<Root: SquareRoot> Arithmetic for Native<Root> {
    const NAME: &'static str = "f32-newton-native";
    const SUMMARY: &'static str = "f32, own polynomials, hardware square root, Newton";

    fn sqrt(value: f32) -> f32 {
        Root::sqrt(value)
    }

    fn shortening(bend: f32) -> Shortening {
        let alpha = bend * RADIANS;
        let x = alpha * alpha;
        if bend < 90.0 {
            let t = x * evaluate(&H, x);
            Shortening { mu: 1.0 - t, t }
        } else {
            let mu = (180.0 - bend) * (180.0 + bend) * (1.0 / 32_400.0) * evaluate(&Q, x);
            Shortening { mu, t: 1.0 - mu }
        }
    }

    fn t_slope(bend: f32, _mu: f32) -> f32 {
        let alpha = bend * RADIANS;
        2.0 * alpha * evaluate(&SLOPE, alpha * alpha)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check, check_float_edges};

    #[test]
    fn errors_against_f64() {
        check::<F32NewtonNative<StdRoot>>(&[
            Limits { bend_deg: 2.9e-5, pressure_kpa: 6.9e-4 },
            Limits { bend_deg: 2.6e-5, pressure_kpa: 6.1e-4 },
            Limits { bend_deg: 3.1e-5, pressure_kpa: 9.8e-4 },
        ]);
        check_float_edges::<F32NewtonNative<StdRoot>>();
    }

    #[test]
    fn the_polynomials_are_as_good_as_f32() {
        let (mut worst_t, mut worst_mu, mut worst_slope) = (0.0_f64, 0.0_f64, 0.0_f64);
        for step in 1..=17_000 {
            let bend = step as f32 * 0.01;
            let alpha = f64::from(bend).to_radians();
            let found = Native::<StdRoot>::shortening(bend);
            let t = if alpha < 0.3 {
                alpha.powi(2) / 6.0 - alpha.powi(4) / 120.0 + alpha.powi(6) / 5040.0 - alpha.powi(8) / 362_880.0
            } else {
                1.0 - alpha.sin() / alpha
            };
            worst_t = worst_t.max((f64::from(found.t) / t - 1.0).abs());
            worst_mu = worst_mu.max((f64::from(found.mu) * alpha / alpha.sin() - 1.0).abs());
            if alpha > 0.3 {
                let slope = (alpha.sin() - alpha * alpha.cos()) / (alpha * alpha);
                worst_slope =
                    worst_slope.max((f64::from(Native::<StdRoot>::t_slope(bend, found.mu)) / slope - 1.0).abs());
            }
        }
        println!("t {worst_t:.1e}, mu {worst_mu:.1e}, slope {worst_slope:.1e}");
        assert!(worst_t < 6e-7 && worst_mu < 6e-7 && worst_slope < 1e-4);
    }
}
