//! Command line of the simulated finger.

use clap::Parser;
use host_sim::cli::{Arguments, execute};
use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(execute(Arguments::parse()))
}
