//! Best polynomials, as in `minimax`, but of s = √(k² + 16 c1 P) − k instead of the pressure: what an integer square root
//! gains them.
//!
//! α ≈ s / (8 c1) near zero for every calibration, so that no segment is worse than the others. 64 uniform segments of s,
//! degree 4; the root is taken of a Q44 number, the result is Q22. s − k cancels for small pressures and large k, but in
//! absolute terms this is 4e-7 degree at most. Pressure from bend is that of `minimax`. State: 1280 + 1785 bytes, and
//! five words.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core minimax_root -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 7.9e-6 | 4.7e-5 |
//! | bare chamber | 8.0e-6 | 2.5e-5 |
//! | worst corner | 2.2e-5 | 6.9e-4 |

use super::minimax::{PressureTable, horner, segment};
use super::remez::grid;
use super::{F64Newton, Method, PRESSURE_LIMIT_KPA, TABLE_LIMIT_DEG, coefficients_kpa, fixed};
use crate::inverse::{BEND_LIMIT, PRESSURE_LIMIT};
use crate::units::{Bend, Coefficients, Pressure};

/// Segments of s.
const ROOTS: usize = 64;
/// Fractional bits of a position in segments.
const POSITION_SHIFT: u32 = 25;

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct MinimaxRoot {
    /// Q22.
    bends: [[i32; 5]; ROOTS],
    pressures: PressureTable,
    /// Q22.
    k: u32,
    /// Q44.
    k_squared: u64,
    /// Q24.
    c1: u32,
    /// Positions, Q25, per s in Q22, times 2³⁰.
    density: u32,
}

impl Method for MinimaxRoot {
    const NAME: &'static str = "minimax-root";
    const SUMMARY: &'static str = "fixed point, best polynomials in the square root of the pressure";
    type Pressure = Pressure;
    type Bend = Bend;

    fn prepare(coefficients: &Coefficients) -> Self {
        let exact = F64Newton::prepare(coefficients);
        let points = grid();
        let [k, c1, _] = coefficients_kpa(coefficients);
        // At least 229 (k = 60, c1 = 5 kPa), so that the density stays below 2³²; a little less, so that the last position is
        // inside the last segment.
        let most = exact.s(PRESSURE_LIMIT_KPA);
        let density = ((1_u64 << 39) as f64 / most) as u32 - 16;
        let width = (1_u64 << 33) as f64 / f64::from(density);
        let mut bends = [[0; 5]; ROOTS];
        for (index, bend) in bends.iter_mut().enumerate() {
            let best =
                segment(&points, index, width, |s| exact.solve(s * (s + 2.0 * k) / (16.0 * c1), TABLE_LIMIT_DEG));
            *bend = best.map(|c: f64| fixed(c, 22));
        }
        let bits = |value: i32| u64::from(value.unsigned_abs());
        let k_q24 = bits(coefficients.k().to_bits());
        Self {
            bends,
            pressures: PressureTable::new(&exact, &points),
            k: (k_q24 >> 2) as u32,
            k_squared: (k_q24 * k_q24) >> 4,
            c1: bits(coefficients.c1().to_bits()) as u32,
            density,
        }
    }

    fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        let bits = pressure.clamp(Pressure::ZERO, PRESSURE_LIMIT).to_bits() as u32;
        if bits == 0 {
            return Bend::ZERO;
        }
        // 16 c1 P in Q44: 640 000 at most, below 2⁶⁴ with k² of 3600.
        let rise = (u64::from(self.c1) * u64::from(bits)) << 8;
        let root = rise.saturating_add(self.k_squared).isqrt();
        let s = (root as u32).saturating_sub(self.k);
        let position = ((u64::from(s) * u64::from(self.density)) >> 30) as u32;
        let Some(segment) = self.bends.get((position >> POSITION_SHIFT) as usize) else { return BEND_LIMIT };
        let bend = horner(segment, position, POSITION_SHIFT).saturating_add(1 << 5) >> 6;
        Bend::from_bits(bend).clamp(Bend::ZERO, BEND_LIMIT)
    }

    fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        self.pressures.pressure(bend)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check};

    #[test]
    fn errors_against_f64() {
        check::<MinimaxRoot>(&[
            Limits { bend_deg: 1.2e-5, pressure_kpa: 7.0e-5 },
            Limits { bend_deg: 1.2e-5, pressure_kpa: 3.7e-5 },
            Limits { bend_deg: 3.4e-5, pressure_kpa: 1.0e-3 },
        ]);
    }
}
