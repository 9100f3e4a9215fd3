//! The campaign on the firmware's ELF: `cargo run -p emulated-board --bin campaign -- --runs N --seed S`. The runs
//! are those of `host-sim campaign` with the same seed. `--replay RUN` tells one of them.

use anyhow::Result;
use clap::Parser;
use emulated_board::campaign::{Options, run_all, run_one};
use emulated_board::firmware_elf;
use host_sim::campaign::draw::{Case, Filter};
use host_sim::campaign::replay;
use std::process::ExitCode;

#[derive(Debug, Parser)]
struct Arguments {
    /// How many runs.
    #[arg(long, value_name = "N", default_value_t = 40)]
    runs: u64,
    /// Seed: with a run's number it decides everything about that run.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Makes this run once more, with all that happened.
    #[arg(long, value_name = "RUN")]
    replay: Option<u64>,
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let elf = firmware_elf()?;
    if let Some(index) = arguments.replay {
        let case = Case::draw(arguments.seed, index, &Filter::default());
        print!("{}", replay::text(&case, &run_one(&elf, &case)?));
        return Ok(ExitCode::SUCCESS);
    }
    let part = run_all(&elf, &Options { seed: arguments.seed, runs: arguments.runs, longest_ms: None })?;
    print!("{}", host_sim::campaign::text(&part));
    println!("on the board: cargo run -p emulated-board --bin campaign -- --seed {} --replay RUN", arguments.seed);
    Ok(if part.result.violated() == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
