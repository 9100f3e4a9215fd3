//! The project's chores, in Rust so that they run wherever the project does: `cargo xtask help`.

mod baseline;
mod board_figures;
mod campaign;
mod compare;
mod elf;
mod firmware;
mod host_sim;
mod image;
mod markers;
mod no_panic;
mod paper;
mod pareto;
mod plant;
mod steps;
mod toolchain;

use anyhow::Result;
use clap::{Parser, Subcommand};
use std::path::{Path, PathBuf};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "The project's chores")]
struct Arguments {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    /// Installs what the firmware's build and the emulated board need and is missing.
    Setup,
    /// Sets up, then passes all the tests: format, lints, host, documentation, firmware, no panic path, emulated board, simulator.
    Test,
    /// Builds the firmware: target/firmware/firmware.{elf,bin,hex}, with flash, RAM and stack.
    Firmware {
        /// Prints the sizes as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Measures the firmware on the emulated board: instructions, load, interlock latency, stack.
    Figures {
        /// Prints JSON.
        #[arg(long)]
        json: bool,
        /// Renews the baseline docs/figures/firmware.json and the README's table.
        #[arg(long)]
        write: bool,
        /// Compares with the baseline instead, and fails when a figure is worse.
        #[arg(long, conflicts_with_all = ["json", "write"])]
        check: bool,
    },
    /// Runs host-sim's command line with the firmware's ELF on the emulated board: what `host-sim run --on elf` starts.
    Elf {
        /// Folder that relative paths in the arguments start from.
        #[arg(long, value_name = "DIR")]
        from: Option<PathBuf>,
        /// host-sim's arguments.
        #[arg(last = true)]
        arguments: Vec<std::ffi::OsString>,
    },
    /// Proves that model-core cannot panic on the Cortex-M4: links a program that calls all of it.
    NoPanic,
    /// Computes the table of true values anew: tests/data/truth.csv, 50 digits each.
    Truth,
    /// Visits every one of the 2^32 inputs of each fixed-point function; `-- --help` lists its options.
    Exhaustive {
        /// Options of the run, such as --calibrations all, --json, --write.
        #[arg(last = true)]
        arguments: Vec<std::ffi::OsString>,
    },
    /// Measures all ways to compute the model: errors on the host, instructions and flash on the emulated Cortex-M4.
    Pareto {
        /// Prints JSON.
        #[arg(long)]
        json: bool,
        /// Renews the baseline docs/figures/pareto.json, the pictures in docs/images, and the tables in README.md,
        /// docs/inverse.md and docs/hard-cases.md.
        #[arg(long)]
        write: bool,
        /// Compares with the baseline instead, and fails when a figure is worse.
        #[arg(long, conflicts_with_all = ["json", "write"])]
        check: bool,
    },
    /// Measures the simulated plant's integrators: error against the reference, evaluations, speed on this host.
    Plant {
        /// Renews the baseline docs/figures/plant.json, the picture in docs/images, and the tables in docs/simulator.md.
        #[arg(long)]
        write: bool,
        /// Compares errors and evaluations with the baseline instead, and fails when a figure is worse.
        #[arg(long, conflicts_with = "write")]
        check: bool,
    },
    /// Compares the regulators and renews docs/compare.md and its pictures.
    Compare,
    /// Sets the paper's tables beside ours: renews docs/paper.md, docs/kinematics.md and their pictures.
    Paper,
    /// Puts the campaign's committed result into docs/campaign.md, with its picture.
    Campaign {
        /// Runs the 30,000 runs anew first: some minutes on two cores.
        #[arg(long)]
        write: bool,
    },
    /// Makes the pictures that the README shows anew, from a run of the simulator.
    Pictures,
    /// Puts the fault table of the code into docs/faults.md.
    Faults,
    /// Renews every figure and picture that the documents show: `pareto --write`, `plant --write`, `compare`, `paper`,
    /// `figures --write`, `campaign`, `pictures`, `faults`.
    ///
    /// All but what takes long: the exhaustive run's table in docs/exhaustive.md (`cargo xtask exhaustive -- --write`), and the
    /// campaign's runs (`cargo xtask campaign --write`).
    Docs,
}

fn main() -> std::process::ExitCode {
    let outcome = match Arguments::parse().chore {
        Chore::Setup => toolchain::set_up_emulator()
            .and_then(|()| toolchain::set_up())
            .map(|route| println!("firmware toolchain: {route}")),
        Chore::Test => steps::test(),
        Chore::Firmware { json } => firmware::build_and_report(json),
        Chore::Figures { check: true, .. } => board_figures::gate(),
        Chore::Figures { json, write, .. } => board_figures::figures(json, write),
        Chore::Elf { from, arguments } => return elf::run(from, &arguments),
        Chore::NoPanic => no_panic::check(),
        Chore::Truth => steps::cargo(&["run", "--quiet", "--package", "finger-tests", "--bin", "truth"]),
        Chore::Exhaustive { arguments } => steps::exhaustive(&arguments),
        Chore::Pareto { check: true, .. } => pareto::gate(),
        Chore::Pareto { json, write, .. } => pareto::pareto(json, write),
        Chore::Plant { check: true, .. } => plant::gate(),
        Chore::Plant { write, .. } => plant::plant(write),
        Chore::Compare => compare::compare(),
        Chore::Paper => paper::paper(),
        Chore::Campaign { write } => campaign::campaign(write),
        Chore::Pictures => steps::pictures(),
        Chore::Faults => steps::faults(),
        Chore::Docs => steps::docs(),
    };
    match outcome {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            std::process::ExitCode::FAILURE
        }
    }
}

/// The workspace's root.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the workspace").to_path_buf()
}

/// A command in the workspace's root, free of what the `cargo` that runs this has set for its own children.
fn command(program: &str) -> std::process::Command {
    let mut command = std::process::Command::new(program);
    command.current_dir(root());
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy();
        let inherited = name.starts_with("CARGO_PKG_")
            || name.starts_with("CARGO_BIN_")
            || ["CARGO", "CARGO_MANIFEST_DIR", "CARGO_MANIFEST_PATH", "CARGO_PRIMARY_PACKAGE", "RUSTC"]
                .contains(&name.as_ref());
        if inherited {
            command.env_remove(name.as_ref());
        }
    }
    command
}

/// Runs a command to its end.
fn run(command: &mut std::process::Command) -> Result<()> {
    // Not `{command:?}`: it lists every variable that was removed.
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let line = words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
    let status = command.status().map_err(|error| anyhow::anyhow!("cannot start {line}: {error}"))?;
    anyhow::ensure!(status.success(), "{line} ended with {status}");
    Ok(())
}
