//! Calibration of the model to measurements of pressure and bend: coefficients with confidence intervals, warnings,
//! pictures, and the file that loads them into a device. docs/calibration.md walks through it.
//!
//! ```
//! use host_sim::calibrate::{calibrate, measurement};
//!
//! // The paper's Table 2, one chamber with exoskeleton.
//! let table = b"pressure_kpa,bend_deg\n30,46.3\n60,71.0\n90,89.6\n120,103.7\n150,112.6\n";
//! let report = calibrate("table-2.csv", &measurement::parse(table).unwrap()).unwrap();
//! let [k, c1, c2] = report.segments[0].coefficients_kpa;
//! assert!(k.abs() < 1e-6 && (c1 - 13.8355).abs() < 1e-3 && (c2 - 0.3356).abs() < 1e-3);
//! // One measurement a pressure is too few to judge them by, and the report says so.
//! assert!(report.warnings.iter().any(|warning| warning.message.contains("fewer than 3 measurements")));
//! ```

pub mod command;
pub mod estimate;
pub mod file;
pub mod measurement;
pub mod picture;
mod recording;
pub mod warning;

use anyhow::Result;
use estimate::{Estimate, estimate};
use file::{Calibration, Entry};
use measurement::{Measurement, Measurements, Scope};
use serde::Serialize;
use warning::{Kind, Warning, warnings};

/// All that a file of measurements says.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The file.
    pub source: String,
    /// One estimate for all segments, or one for each that was measured.
    pub segments: Vec<Estimate>,
    /// What to know before loading them.
    pub warnings: Vec<Warning>,
    /// What of the file was not used, and why.
    pub left_out: Vec<String>,
}

/// Fits each segment's measurements.
///
/// # Errors
/// When the measurements of a segment do not determine the coefficients, or are nothing like the model.
pub fn calibrate(source: &str, measurements: &Measurements) -> Result<Report> {
    let mut segments = Vec::new();
    for scope in [Scope::All, Scope::One(0), Scope::One(1), Scope::One(2)] {
        let own: Vec<Measurement> = measurements.all.iter().filter(|m| m.scope == scope).copied().collect();
        if !own.is_empty() {
            segments.push(estimate(scope.name(), &own)?);
        }
    }
    Ok(Report {
        source: source.to_owned(),
        warnings: segments.iter().flat_map(warnings).collect(),
        segments,
        left_out: measurements.left_out.clone(),
    })
}

impl Report {
    /// What goes into `calibration.toml`, rounded to 10⁻⁶ kPa; nothing when the device would not take it.
    #[must_use]
    pub fn calibration(&self) -> Option<Calibration> {
        let mut calibration = Calibration::new(&self.source);
        for found in &self.segments {
            let place = match found.segment {
                "proximal" => &mut calibration.proximal,
                "middle" => &mut calibration.middle,
                "distal" => &mut calibration.distal,
                _ => &mut calibration.all,
            };
            *place = Some(entry(found));
        }
        calibration.segments().is_ok().then_some(calibration)
    }

    /// Why the device does not take it; empty when it does.
    #[must_use]
    pub fn refusals(&self) -> Vec<&Warning> {
        self.warnings.iter().filter(|warning| warning.kind == Kind::OutsideDevice).collect()
    }
}

fn entry(found: &Estimate) -> Entry {
    let round = |value: f64| (value * 1e6).round() / 1e6;
    let interval = |index: usize| found.ci95_kpa.map(|intervals| intervals[index].map(round));
    Entry {
        k_ci95_kpa: interval(0),
        c1_ci95_kpa: interval(1),
        c2_ci95_kpa: interval(2),
        points: Some(found.points.len()),
        residual_deg: Some(round(found.residual_rms_deg)),
        ..Entry::new(found.coefficients_kpa.map(round))
    }
}
