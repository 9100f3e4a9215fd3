//! Both directions at one calibration, tabulated on floating segments by the calibration-free way.
//!
//! The tables hold what the finger's machine can reach: 256 kPa, more than the pump stalls at, and 164 degrees. Beyond,
//! the calibration-free way itself answers.

use super::direct::Model;
use super::floating::{Floating, OCTAVES};
use super::{bend_from_pressure, pressure_from_bend};
use crate::units::{Bend, Coefficients, Pressure};

/// Segments of each octave of pressure, from 2⁻¹⁶ kPa up to 256 kPa: 1, 2, 4, 8.
const PRESSURE_SPLITS: [u8; OCTAVES] = [0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 3, 3, 3];
const PRESSURE_SEGMENTS: usize = 4 + 10 * 2 + 7 * 4 + 3 * 8;

/// Segments of each octave of bend, from 2⁻¹⁶ degree on: one of up to 8 degrees each up to 16, 8 degrees up to 64, 4 up to
/// 128, then 2.
const BEND_SPLITS: [u8; OCTAVES] = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 4, 6];
const BEND_SEGMENTS: usize = 20 + 2 + 4 + 16 + 18;
/// The last octave's segments go up to here.
const BEND_END: u32 = 164 << 16;

/// No table holds a pressure beyond this, in Q32 kPa: its octave would have no bit left below the output's.
const MOST_PRESSURE_Q32: i64 = 8192 << 32;

/// The model of one calibration, prepared: see the [module](super)'s text.
///
/// ```
/// use model_core::{calibration, inverse::Tabulated, units::Pressure};
/// let finger = Tabulated::new(&calibration::DEFAULT);
/// let bend = finger.bend_from_pressure(Pressure::from_kpa(60));
/// assert!((70.0..72.0).contains(&(f64::from(bend.to_bits()) / 65_536.0)));
/// ```
#[derive(Clone, Debug)]
pub struct Tabulated {
    coefficients: Coefficients,
    bends: Floating<PRESSURE_SEGMENTS>,
    pressures: Floating<BEND_SEGMENTS>,
}

impl Tabulated {
    /// Tabulates both directions: some 120,000 instructions on a Cortex-M4, 0.7 ms at 180 MHz with one a cycle
    /// (`cargo xtask pareto`, column "Prepare").
    #[must_use]
    pub fn new(coefficients: &Coefficients) -> Self {
        let model = Model::new(coefficients);
        Self {
            coefficients: *coefficients,
            // From 8 more bits of pressure than the table has, which is Q24, to 2⁻²⁴ degree.
            bends: Floating::tabulate(
                |pressure| i64::from(model.angle_q24(pressure)),
                8,
                &PRESSURE_SPLITS,
                1 << 24,
                i64::MAX,
            ),
            pressures: Floating::tabulate(
                |angle| {
                    let (wide, fraction_bits) = model.pressure(angle);
                    wide >> fraction_bits
                },
                16,
                &BEND_SPLITS,
                BEND_END,
                MOST_PRESSURE_Q32,
            ),
        }
    }

    /// The bend at which the segment rests under `pressure`: as [`bend_from_pressure`], within three LSB of it.
    #[must_use]
    #[inline]
    pub fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        match self.bends.at(pressure.to_bits() as u32) {
            Some(bits) => Bend::from_bits(bits),
            None => self.bend_beyond(pressure),
        }
    }

    /// The pressure that holds the segment at `bend`: as [`pressure_from_bend`].
    #[must_use]
    #[inline]
    pub fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        match self.pressures.at(bend.to_bits() as u32) {
            Some(bits) => Pressure::from_bits(bits),
            None => self.pressure_beyond(bend),
        }
    }

    /// At rest, or beyond the table: by the calibration-free way, and not below the table's last value.
    #[cold]
    #[inline(never)]
    fn bend_beyond(&self, pressure: Pressure) -> Bend {
        let bend = bend_from_pressure(&self.coefficients, pressure);
        if pressure <= Pressure::ZERO { bend } else { bend.max(Bend::from_bits(self.bends.last)) }
    }

    /// Likewise.
    #[cold]
    #[inline(never)]
    fn pressure_beyond(&self, bend: Bend) -> Pressure {
        let pressure = pressure_from_bend(&self.coefficients, bend);
        if bend <= Bend::ZERO { pressure } else { pressure.max(Pressure::from_bits(self.pressures.last)) }
    }
}
