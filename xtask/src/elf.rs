//! Starts the program with the emulated board, building what is missing.

use crate::{command, firmware, root, toolchain};
use anyhow::Result;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

/// Builds firmware and emulator, quietly, and passes the arguments on; the exit code is the program's.
pub fn run_program(from: Option<PathBuf>, arguments: &[OsString]) -> Result<ExitCode> {
    toolchain::set_up_emulator()?;
    firmware::build()?;
    crate::run(command("cargo").args(["build", "--quiet", "--release", "--package", "emulated-board"]))?;
    let status = std::process::Command::new(root().join("target/release/emulated-board"))
        .current_dir(from.unwrap_or_else(root))
        .args(arguments)
        .status()?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from))
}

/// The same for the command line.
pub fn run(from: Option<PathBuf>, arguments: &[OsString]) -> ExitCode {
    run_program(from, arguments).unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::FAILURE
    })
}

/// Builds and runs the measurement.
pub fn figures(json: bool) -> Result<()> {
    toolchain::set_up_emulator()?;
    firmware::build()?;
    let mut cargo = command("cargo");
    cargo.args(["run", "--quiet", "--release", "--package", "emulated-board", "--bin", "figures", "--"]);
    crate::run(cargo.args(json.then_some("--json")))
}
