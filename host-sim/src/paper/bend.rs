//! Table 2 beside the model: each row with the calibration fitted to it, computed by the controller's own fixed-point
//! function.

use crate::calibrate::file::admitted;
use anyhow::{Result, anyhow};
use model_core::calibration::fit;
use model_core::inverse::bend_from_pressure;
use model_core::paper;
use model_core::units::{Coefficients, Pressure};
use serde::Serialize;

/// A bend that Table 2 gives is to be met within this share of it, percent.
pub const TARGET_PERCENT: f64 = 1.0;

/// One row of Table 2.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What bends.
    pub name: &'static str,
    /// How many chambers one after the other: each bends by an equal part.
    pub segments: f64,
    /// k, c1, c2 fitted to this row.
    pub coefficients_kpa: [f64; 3],
    /// The measured points.
    pub points: Vec<Point>,
    /// The largest error in percent of the measured bend.
    pub worst_percent: f64,
    /// Whether that is within [`TARGET_PERCENT`].
    pub passed: bool,
    /// The paper's finite elements at 150 kPa.
    pub fem_150_deg: f64,
    /// Finite elements against its own measurement, percent.
    pub fem_against_measured_percent: f64,
}

/// One measured bend.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Gauge pressure.
    pub pressure_kpa: f64,
    /// Table 2.
    pub measured_deg: f64,
    /// The controller's model.
    pub ours_deg: f64,
    /// Ours less the measured one.
    pub error_deg: f64,
    /// The same in percent of the measured one.
    pub error_percent: f64,
    /// The error of a fit to the other four points, at this one.
    pub left_out_error_deg: f64,
    /// The same in percent of the measured one.
    pub left_out_error_percent: f64,
}

/// The rows that Table 2 has.
///
/// # Errors
/// When a row cannot be fitted.
pub fn rows() -> Result<Vec<Row>> {
    [
        ("chamber, bare", 1.0, paper::CHAMBER_BARE_DEG, paper::FEM_CHAMBER_BARE_DEG),
        ("chamber, exoskeleton", 1.0, paper::CHAMBER_EXO_DEG, paper::FEM_CHAMBER_EXO_DEG),
        ("finger", paper::CHAMBERS, paper::FINGER_DEG, paper::FEM_FINGER_DEG),
    ]
    .into_iter()
    .map(|(name, segments, measured, fem)| row(name, segments, &measured, fem))
    .collect()
}

fn row(name: &'static str, segments: f64, measured_deg: &[f64; 5], fem_150_deg: f64) -> Result<Row> {
    let points: Vec<(f64, f64)> =
        paper::PRESSURE_KPA.iter().zip(measured_deg).map(|(&kpa, &deg)| (kpa, deg / segments)).collect();
    let fitted = fit(&points).map_err(|error| anyhow!("{name}: {error}"))?;
    let coefficients = coefficients(fitted.coefficients_kpa)?;
    let points: Vec<Point> = paper::PRESSURE_KPA
        .iter()
        .zip(measured_deg)
        .zip(&fitted.leave_one_out_deg)
        .map(|((&pressure_kpa, &measured_deg), left_out)| {
            let ours_deg = segments * bend_deg(&coefficients, pressure_kpa);
            let error_deg = ours_deg - measured_deg;
            let left_out_error_deg = segments * left_out;
            Point {
                pressure_kpa,
                measured_deg,
                ours_deg,
                error_deg,
                error_percent: 100.0 * error_deg / measured_deg,
                left_out_error_deg,
                left_out_error_percent: 100.0 * left_out_error_deg / measured_deg,
            }
        })
        .collect();
    let worst_percent = points.iter().map(|point| point.error_percent.abs()).fold(0.0, f64::max);
    let [.., measured_150] = *measured_deg;
    Ok(Row {
        name,
        segments,
        coefficients_kpa: coefficients.to_f64_kpa(),
        points,
        worst_percent,
        passed: worst_percent <= TARGET_PERCENT,
        fem_150_deg,
        fem_against_measured_percent: 100.0 * (fem_150_deg - measured_150) / measured_150,
    })
}

/// As the controller takes them.
///
/// # Errors
/// When they are outside what it admits.
pub fn coefficients(coefficients_kpa: [f64; 3]) -> Result<Coefficients> {
    admitted(coefficients_kpa).map_err(|error| anyhow!(error))
}

/// One segment's bend by the controller's model.
#[must_use]
pub fn bend_deg(coefficients: &Coefficients, pressure_kpa: f64) -> f64 {
    bend_from_pressure(coefficients, Pressure::from_f64_kpa(pressure_kpa)).to_f64()
}

/// One small cavity: the paper gives a single figure, by finite elements.
#[derive(Clone, Debug, Serialize)]
pub struct SmallCavity {
    /// The paper's finite elements at 150 kPa.
    pub fem_150_deg: f64,
    /// The paper's finite elements of the whole chamber, by its number of small cavities.
    pub fem_chamber_share_deg: f64,
    /// Our chamber's bend at 150 kPa by the same number.
    pub ours_deg: f64,
    /// Ours against the finite elements, percent.
    pub error_percent: f64,
}

/// One small cavity as an equal part of the chamber with exoskeleton.
///
/// # Errors
/// When the calibration of `chamber` is outside what the controller admits.
pub fn small_cavity(chamber: &Row) -> Result<SmallCavity> {
    let ours_deg = bend_deg(&coefficients(chamber.coefficients_kpa)?, 150.0) / paper::SMALL_CAVITIES;
    Ok(SmallCavity {
        fem_150_deg: paper::FEM_SMALL_CAVITY_DEG,
        fem_chamber_share_deg: paper::FEM_CHAMBER_EXO_DEG / paper::SMALL_CAVITIES,
        ours_deg,
        error_percent: 100.0 * (ours_deg - paper::FEM_SMALL_CAVITY_DEG) / paper::FEM_SMALL_CAVITY_DEG,
    })
}
