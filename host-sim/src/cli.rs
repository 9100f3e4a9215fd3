//! The command line: what it takes, what it prints, and how it ends.
//!
//! It ends with 0 when all went well, 1 when something failed on the way or a fault ended the run, 2 when the input was
//! wrong, a folder that cannot be written to among it.

use crate::calibrate::command::{self as calibrate, CalibrateArguments};
use crate::calibrate::file::admitted;
use crate::campaign::command::{self as campaign, CampaignArguments};
use crate::compare::command::{self as compare, CompareArguments};
use crate::eval::{self, EvalError, Function};
use crate::identify::command::{self as identify, IdentifyArguments};
use crate::methods::{self, Entry};
use crate::monitor::command::{self as monitor, MonitorArguments};
use crate::monitor::source::Device;
use crate::paper::command::{self as paper, PaperArguments};
use crate::pareto::command as pareto;
use crate::report::Folder;
use crate::report::command::{self as report_command, ReportArguments};
use crate::run::{self, RunArguments};
use crate::simulate::Run;
use crate::trace::Trace;
use anyhow::{Result, anyhow};
use clap::{CommandFactory, Parser, Subcommand};
use model_core::calibration;
use model_core::sequence::{self, library};
use model_core::units::{Bend, Coefficients, Pressure};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The command line.
#[derive(Debug, Parser)]
#[command(name = "host-sim", version, about = "The soft rehabilitation finger on a desk")]
#[command(args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: RunArguments,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Runs a sequence, or a step to setpoints, on the simulated finger and writes its report.
    Run(RunArguments),
    /// Lists the built-in sequences.
    List {
        /// Prints JSON.
        #[arg(long)]
        json: bool,
    },
    /// Evaluates the controller's fixed-point model: a number a line on stdin, a result a line on stdout.
    Eval {
        /// Which direction.
        function: Function,
        /// Another way to compute it, by its name in `pareto`; the controller's own otherwise.
        #[arg(long, value_name = "METHOD", value_parser = methods::find)]
        method: Option<Entry>,
        /// Coefficients of the model in kPa; the fitted ones otherwise.
        #[arg(long, value_name = "K,C1,C2", value_parser = coefficients, allow_hyphen_values = true)]
        calibration: Option<Coefficients>,
        /// Prints a JSON object a line.
        #[arg(long)]
        json: bool,
    },
    /// Compares speed against error: the ways to compute the model, in error, time on this host and state. Writes table and
    /// pictures.
    Pareto {
        /// The simulated plant's integrators instead.
        #[arg(long)]
        plant: bool,
        /// Prints JSON.
        #[arg(long)]
        json: bool,
        /// Where picture and table go.
        #[arg(long, value_name = "DIR", default_value = "target/pareto")]
        out: PathBuf,
    },
    /// Compares regulators on the same plant, noise, seeds and scenarios. Writes tables and pictures.
    Compare(CompareArguments),
    /// Calibrates the controller to a simulated finger that it does not know: bends before and after the sequence
    /// `calibrate`, and what it identified.
    Identify(IdentifyArguments),
    /// Runs random plants, programs and faults by the thousand, and judges what the supervisor makes of them.
    Campaign(CampaignArguments),
    /// Shows a device, the emulated board or a recording on the terminal, drives it by keys, and records everything.
    Monitor(MonitorArguments),
    /// Sets the paper's tables and curves beside what this project computes, with the errors. Writes tables and pictures.
    Paper(PaperArguments),
    /// Opens a recording, or the table of a run, as the same report that a run has.
    Report(ReportArguments),
    /// Fits the model's coefficients to measurements of pressure and bend: confidence intervals, warnings, pictures, and the
    /// file that loads them into the device.
    Calibrate(CalibrateArguments),
}

/// Simulates a run on the ELF; hears milliseconds done and in all.
pub type OnElf = fn(&Run, &mut dyn FnMut(u32, u32)) -> Result<Trace>;

/// What the program with the emulated board can do beside.
pub struct Emulator {
    /// Simulates a run.
    pub run: OnElf,
    /// The board with the simulated finger as a device on a line, by the seed of its sensors, so many times as fast as a
    /// clock, or as fast as can be.
    pub device: fn(u64, Option<f64>) -> Result<Box<dyn Device>>,
}

/// How a command failed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The input was wrong.
    Input(String),
    /// Something failed on the way.
    Run(anyhow::Error),
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Run(error)
    }
}

/// Three numbers with commas between.
fn three(text: &str, what: &str) -> Result<[f64; 3], String> {
    let parts: Vec<&str> = text.split(',').collect();
    let [a, b, c] = parts.as_slice() else {
        return Err(format!("{} values where {what} takes three with commas between", parts.len()));
    };
    let number = |part: &str| {
        let value = part.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        value.ok_or_else(|| format!("{part:?} is not a number"))
    };
    Ok([number(a)?, number(b)?, number(c)?])
}

pub(crate) fn setpoints(text: &str) -> Result<[Pressure; 3], String> {
    let values = three(text, "P,M,D")?;
    let limit = sequence::MAX_PRESSURE.to_f64();
    for value in values {
        if !(0.0..=limit).contains(&value) {
            return Err(format!("{value} kPa is outside 0..={limit} kPa, the finger's working range"));
        }
    }
    Ok(values.map(Pressure::from_f64_kpa))
}

pub(crate) fn bends(text: &str) -> Result<[Bend; 3], String> {
    let values = three(text, "P,M,D")?;
    let limit = sequence::MAX_BEND.to_f64();
    for value in values {
        if !(0.0..=limit).contains(&value) {
            return Err(format!("{value} degrees is outside 0..={limit} degrees, the finger's working range"));
        }
    }
    Ok(values.map(Bend::from_f64_deg))
}

pub(crate) fn coefficients(text: &str) -> Result<Coefficients, String> {
    admitted(three(text, "K,C1,C2")?)
}

/// The command line as clap has it, for what checks or shows it.
#[must_use]
pub fn command() -> clap::Command {
    Arguments::command()
}

/// Parses and runs the command line; returns the exit code.
///
/// `emulator` does what `run --on elf` and `monitor --elf` ask for. The emulator's engine needs more than Rust to build and
/// has a licence of its own, so host-sim is without it (`None`) and starts the program that has it.
#[must_use]
pub fn main(emulator: Option<&Emulator>) -> u8 {
    match Arguments::try_parse() {
        Ok(arguments) => execute(arguments, emulator),
        // Help and version are no errors, and go to stdout.
        Err(answer) if !answer.use_stderr() => u8::from(answer.print().is_err()),
        Err(error) => {
            eprintln!("{}", one_line(&error.to_string()));
            2
        }
    }
}

/// The parser's message without its usage and hints: the first paragraph, on one line.
fn one_line(message: &str) -> String {
    message.lines().map(str::trim).take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Runs the command; returns the exit code.
fn execute(arguments: Arguments, emulator: Option<&Emulator>) -> u8 {
    let on_elf = emulator.map(|emulator| emulator.run);
    let outcome = match arguments.command {
        None => run::execute(&arguments.run, on_elf),
        Some(Command::Run(run_arguments)) => run::execute(&run_arguments, on_elf),
        Some(Command::List { json }) => list(json),
        Some(Command::Eval { function, method, calibration, json }) => {
            evaluate(function, method, calibration.unwrap_or(calibration::DEFAULT), json)
        }
        Some(Command::Pareto { plant: true, json, out }) => pareto::plant(json, &out),
        Some(Command::Pareto { plant: false, json, out }) => pareto::inverse(json, &out),
        Some(Command::Report(arguments)) => report_command::execute(&arguments),
        Some(Command::Calibrate(arguments)) => calibrate::execute(&arguments),
        Some(Command::Campaign(arguments)) => campaign::execute(&arguments),
        Some(Command::Monitor(arguments)) => monitor::execute(&arguments, emulator),
        Some(Command::Paper(arguments)) => paper::execute(&arguments),
        Some(Command::Compare(arguments)) => compare::execute(&arguments),
        Some(Command::Identify(arguments)) => identify::execute(&arguments),
    };
    match outcome {
        Ok(()) => 0,
        Err(Failure::Input(message)) => {
            eprintln!("error: {message}");
            2
        }
        Err(Failure::Run(error)) => {
            eprintln!("error: {error:#}");
            1
        }
    }
}

/// The folder for a command's files; one that cannot be written to is wrong input.
pub(crate) fn folder(place: &Path) -> Result<Folder, Failure> {
    Folder::prepare(place).map_err(|error| Failure::Input(format!("{error:#}")))
}

/// Writes to stdout; a reader that has gone away (`| head`) is no error.
pub(crate) fn print(text: &str) -> Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(anyhow!("cannot write to stdout: {error}")),
        _ => Ok(()),
    }
}

/// Hands the command line over to the program with the emulator, which `cargo xtask elf` builds and starts.
pub(crate) fn start_elf() -> Result<(), Failure> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let here = std::env::current_dir().map_err(anyhow::Error::from)?;
    let status = std::process::Command::new("cargo")
        .args(["xtask", "elf", "--from"])
        .arg(here)
        .arg("--")
        .args(std::env::args_os().skip(1))
        .current_dir(root)
        .status()
        .map_err(|error| anyhow!("the emulated board needs cargo and the project's sources: {error}"))?;
    match status.code() {
        Some(0) => Ok(()),
        // It has said why.
        Some(code) => std::process::exit(code),
        None => Err(anyhow!("the emulated board's program was stopped").into()),
    }
}

/// What is said of a name that no sequence has.
pub(crate) fn unknown_sequence(name: &str) -> String {
    let known: Vec<_> = library::ALL.iter().map(|sequence| sequence.name).collect();
    format!("no sequence is named {name:?}; there are {}", known.join(", "))
}

fn list(json: bool) -> Result<(), Failure> {
    if json {
        let all: Vec<_> = library::ALL
            .iter()
            .map(|sequence| {
                serde_json::json!({
                    "name": sequence.name,
                    "description": sequence.description,
                    "steps": sequence.steps().len(),
                    "repeats": sequence.repeats(),
                    "duration_s": f64::from(sequence.duration().0) / 1000.0,
                })
            })
            .collect();
        print(&format!("{:#}\n", serde_json::Value::from(all)))?;
    } else {
        for sequence in library::ALL {
            let seconds = f64::from(sequence.duration().0) / 1000.0;
            print(&format!("{:<16} {:>6.1} s  {}\n", sequence.name, seconds, sequence.description))?;
        }
    }
    Ok(())
}

fn evaluate(function: Function, method: Option<Entry>, coefficients: Coefficients, json: bool) -> Result<(), Failure> {
    let mut output = std::io::BufWriter::new(std::io::stdout().lock());
    let evaluator = eval::Evaluator::new(method, &coefficients);
    match eval::filter(function, &evaluator, json, std::io::stdin().lock(), &mut output) {
        Ok(()) => Ok(()),
        Err(EvalError::Line(message)) => Err(Failure::Input(message)),
        Err(EvalError::Io(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(EvalError::Io(error)) => Err(Failure::Run(anyhow!("cannot read stdin or write stdout: {error}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn setpoints_name_the_value_and_the_limit() {
        assert!(setpoints("60,30,60").is_ok());
        for (text, named) in
            [("60,30", "2 values"), ("60,x,60", "\"x\""), ("0,150.1,0", "150.1"), ("-1,0,0", "-1"), ("NaN,0,0", "NaN")]
        {
            let error = setpoints(text).expect_err(text);
            assert!(error.contains(named), "{text}: {error}");
        }
    }

    #[test]
    fn coefficients_name_the_value_and_the_limit() {
        assert!(coefficients("0,13.84,0.336").is_ok());
        for (text, named) in [("61,10,1", "0..=60"), ("0,1e9,1", "5..=40"), ("0,10,-0.5", "0..=2")] {
            let error = coefficients(text).expect_err(text);
            assert!(error.contains(named), "{text}: {error}");
        }
    }
}
