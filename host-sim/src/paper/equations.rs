//! The paper's equations as printed and corrected, beside the calibrated model.

use super::bend::bend_deg;
use model_core::calibration;
use model_core::equations::{as_printed, corrected};
use serde::Serialize;

/// One bend of a chamber, and what each form makes of it.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Bend of the segment.
    pub bend_deg: f64,
    /// Principal stretch, eq. (13).
    pub stretch: f64,
    /// Product of the three stretches of eq. (2) as printed: 1 when the volume is kept.
    pub printed_volume: f64,
    /// The same, corrected.
    pub corrected_volume: f64,
    /// dW/dλ of eq. (6), (15) as printed.
    pub printed_energy_slope_mpa: f64,
    /// The same, corrected.
    pub corrected_energy_slope_mpa: f64,
    /// dλ/dα of eq. (16) as printed.
    pub printed_stretch_slope: f64,
    /// The same, corrected.
    pub corrected_stretch_slope: f64,
    /// dW/dα from both, as printed: what the pressure's work is set against, up to the cavity's volume terms.
    pub printed_work_mpa: f64,
    /// The same, corrected.
    pub corrected_work_mpa: f64,
    /// Pressure of the calibrated model (chamber with exoskeleton).
    pub calibrated_pressure_kpa: f64,
}

/// Rows from `from` degrees to `to` in so many steps.
#[must_use]
pub fn rows(from: f64, to: f64, steps: u32) -> Vec<Row> {
    let bends = (0..=steps).map(|step| from + (to - from) * f64::from(step) / f64::from(steps));
    bends.map(row).collect()
}

fn row(bend_deg: f64) -> Row {
    let alpha = bend_deg.to_radians();
    let stretch = corrected::stretch(alpha);
    let [printed_energy, corrected_energy] = [as_printed::energy_slope(stretch), corrected::energy_slope(stretch)];
    let [printed_slope, corrected_slope] = [as_printed::stretch_slope(alpha), corrected::stretch_slope(alpha)];
    Row {
        bend_deg,
        stretch,
        printed_volume: as_printed::stretches(stretch).iter().product(),
        corrected_volume: corrected::stretches(stretch).iter().product(),
        printed_energy_slope_mpa: printed_energy,
        corrected_energy_slope_mpa: corrected_energy,
        printed_stretch_slope: printed_slope,
        corrected_stretch_slope: corrected_slope,
        printed_work_mpa: printed_energy * printed_slope,
        corrected_work_mpa: corrected_energy * corrected_slope,
        calibrated_pressure_kpa: calibration::pressure_kpa(calibration::DEFAULT.to_f64_kpa(), bend_deg),
    }
}

/// What corrected equations would need to give the pressures of Table 2: if all were right but one constant factor in
/// front, the work over the pressure would be the same in each column.
#[must_use]
pub fn work_over_pressure(pressure_kpa: f64) -> [f64; 2] {
    let row = row(bend_deg(&calibration::DEFAULT, pressure_kpa));
    [row.printed_work_mpa, row.corrected_work_mpa].map(|work| 1e3 * work / pressure_kpa)
}
