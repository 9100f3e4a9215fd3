//! Starts host-sim's reports, which write their files to a folder.

use crate::{command, root};
use anyhow::{Result, ensure};
use std::path::PathBuf;

/// Runs `host-sim pareto` with these arguments; returns the folder of its files.
///
/// # Errors
/// When it cannot be built or ends in an error.
pub fn pareto(arguments: &[&str]) -> Result<PathBuf> {
    run("pareto", arguments, "pareto", &[0])
}

/// Runs `host-sim compare`; returns the folder of its files.
///
/// # Errors
/// As [`pareto`].
pub fn compare() -> Result<PathBuf> {
    run("compare", &[], "compare", &[0])
}

/// Runs `host-sim paper`; returns the folder of its files.
///
/// # Errors
/// As [`pareto`].
pub fn paper() -> Result<PathBuf> {
    run("paper", &[], "paper", &[0])
}

/// Runs `host-sim campaign` with these arguments; returns the folder of its files. One that found violations has its
/// result all the same.
///
/// # Errors
/// As [`pareto`].
pub fn campaign(arguments: &[&str]) -> Result<PathBuf> {
    run("campaign", arguments, "campaign-docs", &[0, 1])
}

fn run(report: &str, arguments: &[&str], folder: &str, good: &[i32]) -> Result<PathBuf> {
    let folder = root().join("target").join(folder);
    let mut cargo = command("cargo");
    cargo.args(["run", "--release", "--quiet", "--package", "host-sim", "--", report]).args(arguments);
    cargo.arg("--out").arg(&folder);
    // What it prints is in the files too.
    let status = cargo.stdout(std::process::Stdio::null()).status()?;
    let ended_well = status.code().is_some_and(|code| good.contains(&code));
    ensure!(ended_well, "host-sim {report} {} ended with {status}", arguments.join(" "));
    Ok(folder)
}
