//! The project's chores, in Rust so that they run wherever the project does.
//!
//! ```text
//! cargo xtask help                     every chore with a line
//! cargo xtask help dist                what one writes, installs, and its options
//! cargo xtask test                     the gate: everything must pass
//! cargo xtask new-sequence my-own      a sequence of one's own, to be edited
//! cargo xtask dist                     the release
//! ```
//!
//! A chore of one step is a file; what has several is in `steps.rs`, and which compiler builds for the chip in `toolchain.rs`.

mod baseline;
mod board_figures;
mod campaign;
mod compare;
mod dist;
mod elf;
mod excerpts;
mod firmware;
mod host_sim;
mod image;
mod markers;
mod new_sequence;
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
#[command(
    after_help = "`cargo xtask help CHORE` says what a chore writes, what it installs, and its options. What is installed \
                        comes from rustup and, on Debian as root, from apt-get; otherwise one line says what is missing."
)]
struct Arguments {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    /// Installs what the firmware's build and the emulated board need and is missing.
    ///
    /// Writes nothing. Installs the Cortex-M4 target, or Debian's rustc with the library's source; a C compiler, `CMake` and
    /// libclang.
    Setup,
    /// Sets up, then passes all the tests: format, lints, host, documentation, firmware, no panic path, emulated board, simulator.
    ///
    /// Writes to target/ only. Installs what `setup` does.
    Test,
    /// Builds the firmware: target/firmware/firmware.{elf,bin,hex}, with flash, RAM and stack.
    ///
    /// Writes target/firmware. Installs what `setup` does.
    Firmware {
        /// Prints the sizes as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Makes the release: firmware, checksums, sizes and figures, licences, in target/dist/finger-VERSION.
    ///
    /// Writes target/dist/finger-VERSION; the same sources and compiler give the same bytes. Installs the Cortex-M4 target
    /// as `setup` does.
    Dist {
        /// Builds a copy of the sources in another folder too, and fails when a byte differs; writes target/dist-again
        /// meanwhile, and no release.
        #[arg(long)]
        check: bool,
    },
    /// Starts a sequence of your own: a file that compiles, to be edited.
    ///
    /// Writes model-core/src/sequence/library/NAME.rs, and its lines in mod.rs there; nothing when the name is refused.
    /// Installs nothing.
    NewSequence {
        /// Lower-case letters and digits with single hyphens between, at most 24: pinch-slowly.
        #[arg(allow_hyphen_values = true)]
        name: String,
    },
    /// Measures the firmware on the emulated board: instructions, load, interlock latency, stack.
    ///
    /// Writes docs/figures/firmware.json and README.md with `--write`, otherwise target/firmware only. Installs what
    /// `setup` does.
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
    ///
    /// Writes target/firmware, and what the command line does. Installs what `setup` does.
    Elf {
        /// Folder that relative paths in the arguments start from.
        #[arg(long, value_name = "DIR")]
        from: Option<PathBuf>,
        /// host-sim's arguments.
        #[arg(last = true)]
        arguments: Vec<std::ffi::OsString>,
    },
    /// Proves that model-core cannot panic on the Cortex-M4: links a program that calls all of it.
    ///
    /// Writes to target/ only. Installs the Cortex-M4 target as `setup` does.
    NoPanic,
    /// Computes the table of true values anew: tests/data/truth.csv, 50 digits each.
    ///
    /// Writes tests/data/truth.csv. Installs nothing.
    Truth,
    /// Visits every one of the 2^32 inputs of each fixed-point function; `-- --help` lists its options.
    ///
    /// Writes docs/exhaustive.md with `-- --write`, otherwise nothing. Installs nothing.
    Exhaustive {
        /// Options of the run, such as --calibrations all, --json, --write.
        #[arg(last = true)]
        arguments: Vec<std::ffi::OsString>,
    },
    /// Measures all ways to compute the model: errors on the host, instructions and flash on the emulated Cortex-M4.
    ///
    /// Writes figures, pictures and tables in docs/ and README.md with `--write`, otherwise target/counted only. Installs
    /// what `setup` does.
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
    ///
    /// Writes docs/figures/plant.json, docs/images/plant-pareto.svg and docs/simulator.md with `--write`, otherwise
    /// target/pareto only. Installs nothing.
    Plant {
        /// Renews the baseline docs/figures/plant.json, the picture in docs/images, and the tables in docs/simulator.md.
        #[arg(long)]
        write: bool,
        /// Compares errors and evaluations with the baseline instead, and fails when a figure is worse.
        #[arg(long, conflicts_with = "write")]
        check: bool,
    },
    /// Compares the regulators and renews docs/compare.md and its pictures.
    ///
    /// Writes docs/compare.md, docs/images/compare-*.svg and target/compare. Installs nothing.
    Compare,
    /// Sets the paper's tables beside ours.
    ///
    /// Writes docs/paper.md, docs/kinematics.md, docs/images/paper-*.svg and target/paper. Installs nothing.
    Paper,
    /// Puts the campaign's committed result into docs/campaign.md, with its picture.
    ///
    /// Writes docs/campaign.md and docs/images/detection-matrix.svg, with `--write` docs/figures/campaign.json too.
    /// Installs nothing.
    Campaign {
        /// Runs the 100,000 runs anew first: half an hour on two cores.
        #[arg(long)]
        write: bool,
    },
    /// Makes the pictures that the README shows anew, from a run of the simulator.
    ///
    /// Writes docs/images/{finger,pressures,actuation}.svg. Installs nothing.
    Pictures,
    /// Puts the fault table of the code into docs/faults.md.
    ///
    /// Writes docs/faults.md. Installs nothing.
    Faults,
    /// Puts the source files that documents show into them: examples, what the compiler says, test vectors.
    ///
    /// Writes docs/*.md. Installs nothing.
    Excerpts,
    /// Tests the HTML report in a headless Chromium.
    ///
    /// Writes target/ alone. Installs Chromium (Debian, as root) where none is found.
    Browser,
    /// Renews every figure and picture that the documents show: `pareto --write`, `plant --write`, `compare`, `paper`,
    /// `figures --write`, `campaign`, `pictures`, `faults`, `excerpts`.
    ///
    /// All but what takes long: the exhaustive run's table in docs/exhaustive.md (`cargo xtask exhaustive -- --write`), and the
    /// campaign's runs (`cargo xtask campaign --write`). Writes what those write. Installs what `setup` does.
    Docs,
}

fn main() -> std::process::ExitCode {
    let outcome = match Arguments::parse().chore {
        Chore::Setup => toolchain::set_up_emulator()
            .and_then(|()| toolchain::set_up())
            .map(|route| println!("firmware toolchain: {route}")),
        Chore::Test => steps::test(),
        Chore::Firmware { json } => firmware::build_and_report(json),
        Chore::Dist { check: false } => dist::dist(),
        Chore::Dist { check: true } => dist::check(),
        Chore::NewSequence { name } => new_sequence::new_sequence(&name),
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
        Chore::Excerpts => excerpts::excerpts(),
        Chore::Browser => steps::browser(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn every_chore_says_what_it_is_writes_and_installs() {
        let mut command = Arguments::command();
        command.build();
        let chores: Vec<_> = command.get_subcommands().filter(|chore| chore.get_name() != "help").collect();
        assert!(chores.len() > 15);
        for chore in chores {
            let name = chore.get_name();
            let short = chore.get_about().unwrap_or_else(|| panic!("{name} has no line of help")).to_string();
            assert!(!short.contains('\n'), "{name}: {short}");
            let long = chore.get_long_about().unwrap_or_else(|| panic!("{name} has no second paragraph")).to_string();
            for what in ["Writes ", "Installs "] {
                assert!(
                    long.contains(what),
                    "the help of {name} does not say what the chore {}: {long}",
                    what.to_lowercase()
                );
            }
            for option in chore.get_arguments().filter(|option| option.get_id() != "help") {
                assert!(option.get_help().is_some(), "{name} {}", option.get_id());
            }
        }
    }
}
