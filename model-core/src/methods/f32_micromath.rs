//! Newton in f32 with micromath's sine, cosine and square root, which are approximations to 1e-3 and 6 %.
//!
//! The sine's error is the model's wherever it is used: above 1 rad, where the series ends. The square root only finds the
//! start. micromath's `inv`, up to 12.5 % off, is left out: the FPU divides exactly in 14 cycles, and every quotient here
//! is a factor of the result.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core f32_micromath -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 1.3e-1 | 9.6e-1 |
//! | bare chamber | 7.3e-2 | 2.0e0 |
//! | worst corner | 1.3e-1 | 3.2e0 |

use super::f32_newton::{Arithmetic, F32Newton, Shortening, shortening_from, t_slope_from};
use micromath::F32;

/// See the module.
pub type F32Micromath = F32Newton<Micromath>;

/// micromath's functions.
#[derive(Clone, Copy, Debug)]
pub struct Micromath;

impl Arithmetic for Micromath {
    const NAME: &'static str = "f32-micromath";
    const SUMMARY: &'static str = "f32, micromath's sine, cosine and square root, Newton";

    fn sqrt(value: f32) -> f32 {
        F32(value).sqrt().0
    }

    fn shortening(bend: f32) -> Shortening {
        shortening_from(bend, |x| F32(x).sin().0)
    }

    fn t_slope(bend: f32, mu: f32) -> f32 {
        t_slope_from(bend, mu, |x| F32(x).cos().0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check, check_float_edges};

    #[test]
    fn errors_against_f64() {
        check::<F32Micromath>(&[
            Limits { bend_deg: 2.0e-1, pressure_kpa: 1.4e0 },
            Limits { bend_deg: 1.1e-1, pressure_kpa: 3.0e0 },
            Limits { bend_deg: 2.0e-1, pressure_kpa: 4.8e0 },
        ]);
        check_float_edges::<F32Micromath>();
    }
}
