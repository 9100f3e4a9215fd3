//! host-sim's command line with the firmware's ELF behind `run --on elf`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(host_sim::cli::main(Some(emulated_board::simulate::on_elf)))
}
