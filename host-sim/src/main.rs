//! Command line of the simulated finger: `host-sim help`; docs/getting-started.md begins with it.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(host_sim::cli::main(None))
}
