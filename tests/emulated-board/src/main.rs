//! host-sim's command line with the firmware's ELF behind `run --on elf` and `monitor --elf`.

use emulated_board::OnLine;
use host_sim::cli::Emulator;
use std::process::ExitCode;

fn main() -> ExitCode {
    let emulator = Emulator {
        run: emulated_board::simulate::on_elf,
        device: |seed, speed| Ok(Box::new(OnLine::new(seed, speed)?)),
    };
    ExitCode::from(host_sim::cli::main(Some(&emulator)))
}
