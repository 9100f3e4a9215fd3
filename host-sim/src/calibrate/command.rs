//! `host-sim calibrate`: what it takes, prints and leaves.

use super::estimate::Estimate;
use super::warning::NAMES;
use super::{Report, calibrate, file, measurement, picture};
use crate::cli::{Failure, folder, print};
use anyhow::anyhow;
use clap::Args;
use std::path::PathBuf;

/// What `host-sim calibrate` takes.
#[derive(Debug, Args)]
pub struct CalibrateArguments {
    /// Measurements: a table with the columns `pressure_kpa` and `bend_deg`, and if need be segment (proximal, middle, distal,
    /// finger, all) and repeat, `#` before comments; or a recording of the sequence calibrate or staircase.
    #[arg(value_name = "FILE.csv")]
    measurements: PathBuf,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
    /// Where calibration.toml, figures and pictures go.
    #[arg(long, value_name = "DIR", default_value = "target/calibrate")]
    out: PathBuf,
}

/// Fits, writes and prints. A calibration that the device would not take is not written: one from before goes.
///
/// # Errors
/// Bad measurements or a folder that cannot be written to are wrong input; a fit that the device would not take is a
/// failure on the way, with its pictures there to look at.
pub(crate) fn execute(arguments: &CalibrateArguments) -> Result<(), Failure> {
    let input = |error: anyhow::Error| Failure::Input(format!("{error:#}"));
    let measurements = measurement::read(&arguments.measurements).map_err(input)?;
    let name = arguments.measurements.file_name().unwrap_or_default().to_string_lossy();
    let report = calibrate(&name, &measurements)
        .map_err(|error| Failure::Input(format!("{}: {error:#}", arguments.measurements.display())))?;
    let folder = folder(&arguments.out)?;
    let pictures = [picture::fit(&report)?, picture::residuals(&report)?];
    let data = format!("{:#}\n", serde_json::to_value(&report).map_err(anyhow::Error::from)?);
    let mut contents =
        vec![("fit.svg", pictures[0].as_str()), ("residuals.svg", &pictures[1]), ("calibration.json", &data)];
    let toml = report.calibration().map(|calibration| file::write(&calibration)).transpose()?;
    match &toml {
        Some(toml) => contents.insert(0, ("calibration.toml", toml)),
        None => folder.remove("calibration.toml")?,
    }
    let files = folder.write(&contents)?;
    let names: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    if arguments.json {
        let mut json = serde_json::to_value(&report).map_err(anyhow::Error::from)?;
        json["files"] = names.into();
        json["loadable"] = toml.is_some().into();
        print(&format!("{json:#}\n"))?;
    } else {
        print(&text(&report))?;
        print(&format!("files: {}\n", names.join(", ")))?;
        if toml.is_some() {
            print(&next_steps(&report, &names[0]))?;
        }
    }
    match report.refusals().first() {
        None => Ok(()),
        Some(refusal) => {
            Err(Failure::Run(anyhow!("segment {}: {}; there is no calibration.toml", refusal.segment, refusal.message)))
        }
    }
}

/// `K,C1,C2` as `eval --calibration` takes them.
fn argument(found: &Estimate) -> String {
    found.coefficients_kpa.map(|value| format!("{value:.6}")).join(",")
}

fn next_steps(report: &Report, calibration: &str) -> String {
    let mut out = String::from("\nlook at it:\n");
    for found in &report.segments {
        out += &format!("  host-sim eval angle-from-pressure --calibration {}", argument(found));
        out += &if found.segment == "all" { "\n".to_owned() } else { format!("   # {}\n", found.segment) };
    }
    out + &format!("load it into the device:\n  host-sim monitor --port auto --calibration {calibration}\n")
}

/// The report for people.
fn text(report: &Report) -> String {
    let mut out = String::new();
    for found in &report.segments {
        let [low, high] = found.range_kpa();
        let repeats = found.levels.iter().map(|level| level.points);
        let (fewest, most) = (repeats.clone().min().unwrap_or(0), repeats.max().unwrap_or(0));
        let repeats = if fewest == most { format!("{most}") } else { format!("{fewest} to {most}") };
        out += &format!(
            "segment {}, from {}: {} points, {} pressures from {low:.0} to {high:.0} kPa, {repeats} at each\n",
            found.segment,
            report.source,
            found.points.len(),
            found.levels.len(),
        );
        out += &format!("{:<6}{:>12}    {}\n", "", "kPa", "95 % confidence interval");
        for (index, name) in NAMES.iter().enumerate() {
            let interval = found.ci95_kpa.map_or_else(
                || "-".to_owned(),
                |intervals| format!("{:.4} to {:.4}", intervals[index][0], intervals[index][1]),
            );
            out += &format!("{name:<6}{:>12.4}    {interval}\n", found.coefficients_kpa[index]);
        }
        let worst = found.worst().map_or_else(String::new, |point| {
            format!(", {:+.2} at most ({}, {:.0} kPa)", point.residual_deg, point.place, point.pressure_kpa)
        });
        let curve =
            found.curve_ci95_deg.map_or_else(String::new, |deg| format!("; the curve is known to ±{deg:.2} (95 %)"));
        out +=
            &format!("bend, degrees: {:.2} root mean square off the curve{worst}{curve}\n\n", found.residual_rms_deg);
    }
    for warning in &report.warnings {
        out += &format!("warning: segment {}: {}\n", warning.segment, warning.message);
    }
    for left_out in &report.left_out {
        out += &format!("not used: {left_out}\n");
    }
    if !report.warnings.is_empty() || !report.left_out.is_empty() {
        out.push('\n');
    }
    out
}
