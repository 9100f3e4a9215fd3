//! Command line of the simulated finger.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(host_sim::cli::main(None))
}
