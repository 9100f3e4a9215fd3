//! Starts host-sim's comparisons, which write their files to a folder.

use crate::{command, root};
use anyhow::{Result, ensure};
use std::path::PathBuf;

/// Runs `host-sim pareto` with these arguments; returns the folder of its files.
///
/// # Errors
/// When it cannot be built or ends in an error.
pub fn pareto(arguments: &[&str]) -> Result<PathBuf> {
    run("pareto", arguments)
}

/// Runs `host-sim compare`; returns the folder of its files.
///
/// # Errors
/// As [`pareto`].
pub fn compare() -> Result<PathBuf> {
    run("compare", &[])
}

fn run(comparison: &str, arguments: &[&str]) -> Result<PathBuf> {
    let folder = root().join("target").join(comparison);
    let mut cargo = command("cargo");
    cargo.args(["run", "--release", "--quiet", "--package", "host-sim", "--", comparison]).args(arguments);
    cargo.arg("--out").arg(&folder);
    // What it prints is in the files too.
    let status = cargo.stdout(std::process::Stdio::null()).status()?;
    ensure!(status.success(), "host-sim {comparison} {} ended with {status}", arguments.join(" "));
    Ok(folder)
}
