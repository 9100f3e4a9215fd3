//! Cubics in f32 on floating segments (see `f32_segments`): no loop, no division, no square root.
//!
//! Bend from pressure: octaves from 2⁻²³ to 1000 kPa, from 1 segment each at the lower end to 16 at the upper; below, the
//! bend is proportional to the pressure, which is wrong by less than 0.002 degree. Pressure from bend: octaves of 180 degrees
//! less the bend. State: 2036 + 1936 bytes, 2 KiB at most for each direction.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core f32_floating_cubic -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 3.5e-5 | 1.4e-4 |
//! | bare chamber | 3.5e-5 | 1.1e-4 |
//! | worst corner | 1.0e-4 | 8.2e-5 |

use super::f32_segments::{Cubic, Segments};
use super::{BEND_LIMIT_DEG, F64Newton, Method, PRESSURE_LIMIT_KPA, TABLE_LIMIT_DEG, within};
use crate::units::Coefficients;

/// 2⁻²³ kPa, where the first segment begins.
const LEAST_PRESSURE: f32 = 1.0 / 8_388_608.0;
const PRESSURES: Segments<33> = Segments::new(
    -23,
    [0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 4],
    LEAST_PRESSURE,
    PRESSURE_LIMIT_KPA as f32,
);
/// 180 degrees less the largest bend.
const LEAST_REST: f32 = 180.0 - BEND_LIMIT_DEG as f32;
const RESTS: Segments<5> = Segments::new(3, [4, 5, 5, 5, 5], LEAST_REST, 180.0);

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct F32FloatingCubic {
    bends: [Cubic; PRESSURES.count()],
    pressures: [Cubic; RESTS.count()],
    /// Degrees per kPa below the first segment.
    first_slope: f32,
}

impl Method for F32FloatingCubic {
    const NAME: &'static str = "f32-floating-cubic";
    const SUMMARY: &'static str = "f32, floating segments by the exponent, best cubics";
    type Pressure = f32;
    type Bend = f32;

    fn prepare(coefficients: &Coefficients) -> Self {
        let exact = F64Newton::prepare(coefficients);
        let least = f64::from(LEAST_PRESSURE);
        let mut method = Self {
            bends: [[0.0; 4]; PRESSURES.count()],
            pressures: [[0.0; 4]; RESTS.count()],
            first_slope: (exact.bend_from_pressure(least) / least) as f32,
        };
        PRESSURES.table(LEAST_PRESSURE, &mut method.bends, |pressure| exact.solve(pressure, TABLE_LIMIT_DEG));
        RESTS.table(LEAST_REST, &mut method.pressures, |rest| exact.pressure_from_bend(180.0 - rest));
        method
    }

    fn bend_from_pressure(&self, pressure: f32) -> f32 {
        let pressure = within(pressure, 0.0, PRESSURE_LIMIT_KPA as f32);
        PRESSURES
            .evaluate(&self.bends, pressure)
            .map_or(pressure * self.first_slope, |bend| within(bend, 0.0, BEND_LIMIT_DEG as f32))
    }

    fn pressure_from_bend(&self, bend: f32) -> f32 {
        let rest = 180.0 - within(bend, 0.0, BEND_LIMIT_DEG as f32);
        // A bend that vanishes beside 180 degrees has its end, beyond the last segment.
        let pressure = RESTS.evaluate(&self.pressures, rest).unwrap_or(0.0);
        if pressure > 0.0 { pressure } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check, check_float_edges};

    #[test]
    fn errors_against_f64() {
        check::<F32FloatingCubic>(&[
            Limits { bend_deg: 5.2e-5, pressure_kpa: 2.0e-4 },
            Limits { bend_deg: 5.2e-5, pressure_kpa: 1.7e-4 },
            Limits { bend_deg: 1.6e-4, pressure_kpa: 1.2e-4 },
        ]);
        check_float_edges::<F32FloatingCubic>();
    }
}
