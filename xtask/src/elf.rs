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
    crate::run(command("cargo").args(["build", "--quiet", "--package", "emulated-board"]))?;
    let status = std::process::Command::new(root().join("target/debug/emulated-board"))
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

fn measurement() -> Result<std::process::Command> {
    toolchain::set_up_emulator()?;
    let mut cargo = command("cargo");
    cargo.args(["run", "--quiet", "--package", "emulated-board", "--bin", "figures", "--"]);
    Ok(cargo)
}

/// What `figures --json` of the firmware just built says; an error when a figure is over its limit.
pub fn figures() -> Result<serde_json::Value> {
    let output = measurement()?.arg("--json").stderr(std::process::Stdio::inherit()).output()?;
    anyhow::ensure!(
        output.status.success(),
        "the firmware cannot be measured on the emulated board, or is over a limit"
    );
    Ok(serde_json::from_slice(&output.stdout)?)
}

/// The deepest stack, in bytes, that the firmware just built has on the emulated board.
pub fn stack_bytes() -> Result<u64> {
    let output = measurement()?.arg("--stack").stderr(std::process::Stdio::inherit()).output()?;
    anyhow::ensure!(output.status.success(), "the firmware does not run on the emulated board");
    Ok(String::from_utf8_lossy(&output.stdout).trim().parse()?)
}
