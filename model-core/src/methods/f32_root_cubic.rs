//! Cubics in f32 in the variable in which the model is smooth: one square root and one division take the infinite slope at
//! zero away.
//!
//! With s = √(k² + 16 c1 P) − k = 16 c1 P / (√(k² + 16 c1 P) + k), P = s (s + 2k) / (16 c1), and α ≈ s / (8 c1) near zero for
//! every calibration. α(s) is a table of 96 uniform segments; s(α) one on floating segments of 180 degrees less the bend (see
//! `f32_segments`). State: 1536 + 1328 bytes, and five words.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core f32_root_cubic -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 1.8e-5 | 4.4e-4 |
//! | bare chamber | 1.8e-5 | 3.9e-4 |
//! | worst corner | 6.5e-5 | 2.5e-4 |

use super::f32_newton_native::SquareRoot;
use super::f32_segments::{Cubic, Segments, best};
use super::remez::grid;
use super::{BEND_LIMIT_DEG, F64Newton, Method, PRESSURE_LIMIT_KPA, TABLE_LIMIT_DEG, coefficients_kpa, within};
use crate::units::Coefficients;
use core::marker::PhantomData;

/// Uniform segments of s.
const ROOTS: usize = 96;
/// 180 degrees less the largest bend.
const LEAST_REST: f32 = 180.0 - BEND_LIMIT_DEG as f32;
const RESTS: Segments<5> = Segments::new(3, [3, 4, 4, 5, 5], LEAST_REST, 180.0);

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct F32RootCubic<Root> {
    /// Degrees, in the position within the segment, 0..1.
    bends: [Cubic; ROOTS],
    /// s.
    roots: [Cubic; RESTS.count()],
    k: f32,
    k_squared: f32,
    /// 16 c1 and its reciprocal.
    rise: f32,
    inverse_rise: f32,
    /// Segments per unit of s.
    density: f32,
    root: PhantomData<Root>,
}

impl<Root: SquareRoot> Method for F32RootCubic<Root> {
    const NAME: &'static str = "f32-root-cubic";
    const SUMMARY: &'static str = "f32, best cubics in the square root of the pressure";
    type Pressure = f32;
    type Bend = f32;

    fn prepare(coefficients: &Coefficients) -> Self {
        let [k, c1, _] = coefficients_kpa(coefficients);
        let exact = F64Newton::prepare(coefficients);
        let rise = 16.0 * c1;
        let width = exact.s(PRESSURE_LIMIT_KPA) / ROOTS as f64;
        let mut bends = [[0.0; 4]; ROOTS];
        let points = grid();
        for (index, cubic) in bends.iter_mut().enumerate() {
            let low = index as f64;
            *cubic = best(&points, low, low + 1.0, |position| {
                let s = position * width;
                exact.solve(s * (s + 2.0 * k) / rise, TABLE_LIMIT_DEG)
            })
            .map(|c| c as f32);
        }
        // The first cubic starts at zero exactly, so that small bends are right in proportion.
        if let Some(first) = bends.first_mut() {
            first[0] = 0.0;
        }
        let mut roots = [[0.0; 4]; RESTS.count()];
        RESTS.table(LEAST_REST, &mut roots, |rest| exact.s(exact.pressure_from_bend(180.0 - rest)));
        Self {
            bends,
            roots,
            k: k as f32,
            k_squared: (k * k) as f32,
            rise: rise as f32,
            inverse_rise: (1.0 / rise) as f32,
            density: (1.0 / width) as f32,
            root: PhantomData,
        }
    }

    fn bend_from_pressure(&self, pressure: f32) -> f32 {
        let rise = self.rise * within(pressure, 0.0, PRESSURE_LIMIT_KPA as f32);
        let root = Root::sqrt(self.k_squared + rise) + self.k;
        // Zero only where 16 c1 P is.
        let position = if root > 0.0 { rise / root * self.density } else { 0.0 };
        let index = (position as usize).min(ROOTS - 1);
        let Some([c0, c1, c2, c3]) = self.bends.get(index) else { return 0.0 };
        let offset = position - index as f32;
        within(c0 + offset * (c1 + offset * (c2 + offset * c3)), 0.0, BEND_LIMIT_DEG as f32)
    }

    fn pressure_from_bend(&self, bend: f32) -> f32 {
        let rest = 180.0 - within(bend, 0.0, BEND_LIMIT_DEG as f32);
        let s = RESTS.evaluate(&self.roots, rest).unwrap_or(0.0);
        if s > 0.0 { s * (s + 2.0 * self.k) * self.inverse_rise } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::StdRoot;
    use crate::methods::reference::{Limits, check, check_float_edges};

    #[test]
    fn errors_against_f64() {
        check::<F32RootCubic<StdRoot>>(&[
            Limits { bend_deg: 2.7e-5, pressure_kpa: 6.7e-4 },
            Limits { bend_deg: 2.6e-5, pressure_kpa: 5.8e-4 },
            Limits { bend_deg: 9.8e-5, pressure_kpa: 3.7e-4 },
        ]);
        check_float_edges::<F32RootCubic<StdRoot>>();
    }
}
