//! `host-sim identify` on the command line.

use crate::cli::{Failure, coefficients, folder, print};
use clap::Args;
use model_core::units::Coefficients;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct IdentifyArguments {
    /// The finger's own coefficients in kPa: given once for all segments, or three times, proximal first. Default: three that
    /// differ, a bare chamber among them.
    #[arg(long, value_name = "K,C1,C2", value_parser = coefficients, allow_hyphen_values = true)]
    finger: Vec<Coefficients>,
    /// Leaves out the bend sensor's gain error of up to 1 %, which no calibration against that sensor can tell.
    #[arg(long)]
    true_gain: bool,
    /// Seed of the sensors' errors: the same seed gives the same bytes.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
    /// Where picture and figures go.
    #[arg(long, value_name = "DIR", default_value = "target/identify")]
    out: PathBuf,
}

/// Calibrates a simulated finger.
pub(crate) fn execute(arguments: &IdentifyArguments) -> Result<(), Failure> {
    let finger_kpa = match arguments.finger.as_slice() {
        [] => super::MIXED_KPA,
        [all] => [all.to_f64_kpa(); 3],
        [proximal, middle, distal] => [*proximal, *middle, *distal].map(Coefficients::to_f64_kpa),
        other => {
            return Err(Failure::Input(format!(
                "--finger is given {} times: give it once or three times",
                other.len()
            )));
        }
    };
    let folder = folder(&arguments.out)?;
    let bar = crate::progress::bar(1, "runs");
    let report = super::run(finger_kpa, !arguments.true_gain, arguments.seed, |done, total| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    })?;
    bar.finish_and_clear();
    let files = super::write(&folder, &report)?;
    if arguments.json {
        print(&format!("{:#}\n", serde_json::to_value(&report).map_err(anyhow::Error::from)?))?;
    } else {
        print(&super::text(&report))?;
        print(&format!("picture: {}\n", files[0].display()))?;
    }
    Ok(())
}
