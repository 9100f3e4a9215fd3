//! Newton in f32 with libm's `sinf`, `cosf` and `sqrtf`: what a program without further thought would do. On a Cortex-M4F
//! `sinf` computes in software f64 and `sqrtf` bit by bit, so that `f32_newton_native` is the fair peer there.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core f32_newton_libm -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 1.6e-5 | 4.3e-4 |
//! | bare chamber | 1.6e-5 | 4.1e-4 |
//! | worst corner | 1.8e-5 | 6.0e-4 |

use super::f32_newton::{Arithmetic, F32Newton, Shortening, shortening_from, t_slope_from};

/// See the module.
pub type F32NewtonLibm = F32Newton<Libm>;

/// libm's functions.
#[derive(Clone, Copy, Debug)]
pub struct Libm;

impl Arithmetic for Libm {
    const NAME: &'static str = "f32-newton-libm";
    const SUMMARY: &'static str = "f32, libm's sine, cosine and square root, Newton";

    fn sqrt(value: f32) -> f32 {
        libm::sqrtf(value)
    }

    fn shortening(bend: f32) -> Shortening {
        shortening_from(bend, libm::sinf)
    }

    fn t_slope(bend: f32, mu: f32) -> f32 {
        t_slope_from(bend, mu, libm::cosf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check, check_float_edges};

    #[test]
    fn errors_against_f64() {
        check::<F32NewtonLibm>(&[
            Limits { bend_deg: 3.3e-5, pressure_kpa: 6.4e-4 },
            Limits { bend_deg: 2.5e-5, pressure_kpa: 6.8e-4 },
            Limits { bend_deg: 2.9e-5, pressure_kpa: 9.0e-4 },
        ]);
        check_float_edges::<F32NewtonLibm>();
    }
}
