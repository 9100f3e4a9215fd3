//! The command line: what it takes, what it prints, and how it ends.
//!
//! It ends with 0 when all went well, 1 when something failed on the way or a fault ended the run, 2 when the input was
//! wrong, a folder that cannot be written to among it.

use crate::calibrate::command::{self as calibrate, CalibrateArguments};
use crate::calibrate::file::admitted;
use crate::campaign::command::{self as campaign, CampaignArguments};
use crate::compare;
use crate::eval::{self, EvalError, Function};
use crate::identify;
use crate::methods::{self, Entry};
use crate::metrics::{Summary, summarise};
use crate::monitor::command::{self as monitor, MonitorArguments};
use crate::monitor::source::Device;
use crate::paper::command::{self as paper, PaperArguments};
use crate::pareto;
use crate::report::command::{self as report_command, ReportArguments};
use crate::report::{self, Folder};
use crate::simulate::{Program, Run};
use crate::trace::Trace;
use anyhow::{Result, anyhow};
use clap::{Args, CommandFactory, Parser, Subcommand};
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

#[derive(Debug, Args)]
struct CompareArguments {
    /// Only this scenario.
    #[arg(long, value_name = "NAME", value_parser = scenario)]
    scenario: Option<compare::scenario::Scenario>,
    /// Seeds of the sensors' errors: 1 to this.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: u64,
    /// Tunes the peers instead, with so many candidates each, and prints what it found.
    #[arg(long, value_name = "CANDIDATES", num_args = 0..=1, default_missing_value = "400", conflicts_with_all = ["scenario", "seeds"])]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=100_000))]
    tune: Option<u32>,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
    /// Where tables and pictures go.
    #[arg(long, value_name = "DIR", default_value = "target/compare")]
    out: PathBuf,
}

fn scenario(name: &str) -> Result<compare::scenario::Scenario, String> {
    compare::scenario::find(name).copied().ok_or_else(|| {
        let known: Vec<_> = compare::scenario::ALL.iter().map(|scenario| scenario.name).collect();
        format!("no scenario is named {name:?}; there are {}", known.join(", "))
    })
}

#[derive(Debug, Args)]
struct IdentifyArguments {
    /// The finger's own coefficients in kPa: given once for all segments, or three times, proximal first. Default: three that
    /// differ, a bare chamber among them.
    #[arg(long, value_name = "K,C1,C2", value_parser = coefficients, allow_hyphen_values = true)]
    finger: Vec<Coefficients>,
    /// Leaves out the bend sensor's gain error of up to 1 %, which no calibration against that sensor can tell.
    #[arg(long)]
    true_gain: bool,
    /// Seed of the sensors' errors: the same seed gives the same bytes.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
    /// Where picture and figures go.
    #[arg(long, value_name = "DIR", default_value = "target/identify")]
    out: PathBuf,
}

#[derive(Debug, Args)]
struct RunArguments {
    /// A built-in sequence; see `list`. Default: reconfigure.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["setpoints", "bends"])]
    sequence: Option<String>,
    /// Gauge pressures of the proximal, middle and distal chamber in kPa, each 0..=150.
    #[arg(long, value_name = "P,M,D", value_parser = setpoints, allow_hyphen_values = true)]
    setpoints: Option<[Pressure; 3]>,
    /// Bends of the proximal, middle and distal segment in degrees, each 0..=110.
    #[arg(long, value_name = "P,M,D", value_parser = bends, allow_hyphen_values = true, conflicts_with = "setpoints")]
    bends: Option<[Bend; 3]>,
    /// Seed of the sensors' errors: the same seed gives the same bytes.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Where the report goes.
    #[arg(long, value_name = "DIR", default_value = "target/finger")]
    out: PathBuf,
    /// What controls the finger: the core, linked in, or the firmware's own ELF on the emulated board. The first run on
    /// the ELF installs and builds what that needs.
    #[arg(long, value_enum, default_value_t = On::Core)]
    on: On,
    /// Prints the figures as JSON.
    #[arg(long)]
    json: bool,
}

/// What controls the finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum On {
    /// The core, linked in.
    Core,
    /// The firmware's ELF on the emulated board.
    Elf,
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

fn coefficients(text: &str) -> Result<Coefficients, String> {
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
        None => run(&arguments.run, on_elf),
        Some(Command::Run(run_arguments)) => run(&run_arguments, on_elf),
        Some(Command::List { json }) => list(json),
        Some(Command::Eval { function, method, calibration, json }) => {
            evaluate(function, method, calibration.unwrap_or(calibration::DEFAULT), json)
        }
        Some(Command::Pareto { plant: true, json, out }) => pareto_plant(json, &out),
        Some(Command::Pareto { plant: false, json, out }) => pareto_inverse(json, &out),
        Some(Command::Report(arguments)) => report_command::execute(&arguments),
        Some(Command::Calibrate(arguments)) => calibrate::execute(&arguments),
        Some(Command::Campaign(arguments)) => campaign::execute(&arguments),
        Some(Command::Monitor(arguments)) => monitor::execute(&arguments, emulator),
        Some(Command::Paper(arguments)) => paper::execute(&arguments),
        Some(Command::Compare(arguments)) => compare_regulators(&arguments),
        Some(Command::Identify(arguments)) => identify_finger(&arguments),
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

fn run(arguments: &RunArguments, on_elf: Option<OnElf>) -> Result<(), Failure> {
    let name = arguments.sequence.as_deref().unwrap_or("reconfigure");
    let program = match (arguments.setpoints, arguments.bends) {
        (Some(setpoints), _) => Program::Setpoints(setpoints),
        (None, Some(bends)) => Program::Bends(bends),
        (None, None) => Program::Sequence(library::find(name).ok_or_else(|| Failure::Input(unknown_sequence(name)))?),
    };
    if arguments.on == On::Elf && on_elf.is_none() {
        return start_elf();
    }
    let folder = folder(&arguments.out)?;
    let run = Run::new(program, arguments.seed);
    let bar = crate::progress::bar(1, "ms simulated");
    let mut progress = |done, total| {
        bar.set_length(u64::from(total));
        bar.set_position(u64::from(done));
    };
    let trace = match (arguments.on, on_elf) {
        (On::Elf, Some(on_elf)) => on_elf(&run, &mut progress)?,
        _ => run.simulate(progress)?,
    };
    bar.finish_and_clear();
    let summary = summarise(&trace);
    let files = report::write(&folder, &trace, &summary, &run.parameters)?;
    if arguments.json {
        let mut json = serde_json::to_value(&summary).map_err(anyhow::Error::from)?;
        json["sequence"] = trace.name.into();
        json["seed"] = trace.seed.into();
        json["on"] = format!("{:?}", arguments.on).to_lowercase().into();
        json["files"] = files.iter().map(|path| path.display().to_string()).collect();
        print(&format!("{json:#}\n"))?;
    } else {
        print(&text(&trace.name, &trace.description, &summary))?;
        print(&format!("report: {}\n", files[0].display()))?;
    }
    // The report is there, but a run that ended in a fault did not do what was asked.
    if let [fault, ..] = summary.faults.as_slice() {
        return Err(Failure::Run(anyhow!("the run ended in the fault {fault}: see the report")));
    }
    Ok(())
}

/// The summary for people.
pub(crate) fn text(name: &str, description: &str, summary: &Summary) -> String {
    let optional = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"));
    let mut out = format!(
        "{name}: {description}\n\n{:<10}{:>11}{:>11}{:>11}{:>10}{:>11}{:>10}{:>9}{:>9}\n",
        "segment", "hold mean", "hold worst", "overshoot", "settling", "switchings", "highest", "vented", "bend"
    );
    out += &format!(
        "{:<10}{:>11}{:>11}{:>11}{:>10}{:>11}{:>10}{:>9}{:>9}\n",
        "", "kPa", "kPa", "kPa", "s", "", "kPa", "kPa", "deg"
    );
    for segment in &summary.segments {
        out += &format!(
            "{:<10}{:>11}{:>11}{:>11.2}{:>10}{:>11}{:>10.1}{:>9.2}{:>9.1}\n",
            segment.segment,
            optional(segment.hold_mean_abs_error_kpa),
            optional(segment.hold_worst_abs_error_kpa),
            segment.overshoot_kpa,
            optional(segment.settling_time_s),
            segment.valve_switchings,
            segment.peak_chamber_kpa,
            segment.vented_residual_kpa,
            segment.peak_bend_deg,
        );
    }
    out += &format!(
        "\npump {} starts, {:.2} s on; dump valve {} switchings; finger's largest bend {:.1} deg\n",
        summary.pump_starts, summary.pump_on_s, summary.dump_switchings, summary.peak_bend_deg
    );
    if summary.holds_not_reached > 0 || summary.holds_not_settled > 0 {
        out += &format!(
            "holds not reached: {}; not settled within 2 kPa at their end: {}\n",
            summary.holds_not_reached, summary.holds_not_settled
        );
    }
    for fault in &summary.faults {
        out += &format!("fault: {fault}\n");
    }
    out
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

fn pareto_inverse(json: bool, out: &Path) -> Result<(), Failure> {
    let folder = folder(out)?;
    print(&pareto::inverse::run(json, &folder)?)?;
    Ok(())
}

fn pareto_plant(json: bool, out: &Path) -> Result<(), Failure> {
    let folder = folder(out)?;
    let bar = crate::progress::bar(1, "measurements");
    let report = pareto::plant::measure(|done, total| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    })?;
    bar.finish_and_clear();
    let picture = pareto::plant::picture(&report)?;
    let table = pareto::plant::csv(&report)?;
    let markdown = pareto::plant::markdown(&report);
    let data = format!("{:#}\n", serde_json::to_value(&report).map_err(anyhow::Error::from)?);
    folder.write(&[
        ("plant-pareto.svg", picture.as_str()),
        ("plant-pareto.csv", &table),
        ("plant-pareto.md", &markdown),
        ("plant-pareto.json", &data),
    ])?;
    print(&if json { data } else { pareto::plant::text(&report) })?;
    Ok(())
}

fn identify_finger(arguments: &IdentifyArguments) -> Result<(), Failure> {
    let finger_kpa = match arguments.finger.as_slice() {
        [] => identify::MIXED_KPA,
        [all] => [all.to_f64_kpa(); 3],
        [proximal, middle, distal] => [*proximal, *middle, *distal].map(Coefficients::to_f64_kpa),
        other => {
            return Err(Failure::Input(format!(
                "--finger is given {} times: give it once or three times",
                other.len()
            )));
        }
    };
    let folder = folder(&arguments.out)?;
    let bar = crate::progress::bar(1, "runs");
    let report = identify::run(finger_kpa, !arguments.true_gain, arguments.seed, |done, total| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    })?;
    bar.finish_and_clear();
    let files = identify::write(&folder, &report)?;
    if arguments.json {
        print(&format!("{:#}\n", serde_json::to_value(&report).map_err(anyhow::Error::from)?))?;
    } else {
        print(&identify::text(&report))?;
        print(&format!("picture: {}\n", files[0].display()))?;
    }
    Ok(())
}

fn compare_regulators(arguments: &CompareArguments) -> Result<(), Failure> {
    if let Some(budget) = arguments.tune {
        return tune_peers(budget as usize, arguments.json);
    }
    let folder = folder(&arguments.out)?;
    let scenarios = arguments.scenario.map_or_else(|| compare::scenario::ALL.to_vec(), |one| vec![one]);
    let trials = scenarios.len() * compare::contender::Kind::ALL.len() * arguments.seeds as usize;
    let bar = crate::progress::bar(trials, "trials");
    let report = compare::measure(&scenarios, arguments.seeds, || bar.inc(1))?;
    bar.finish_and_clear();
    let mut json = serde_json::to_value(&report).map_err(anyhow::Error::from)?;
    json["targets"] = serde_json::to_value(report.targets()).map_err(anyhow::Error::from)?;
    let data = format!("{json:#}\n");
    let shown = arguments.scenario.or_else(|| compare::scenario::find("60-30-60").copied());
    let traces = shown.map(|scenario| compare::traces(&scenario)).transpose()?.unwrap_or_default();
    folder.write(&[
        ("compare.json", data.as_str()),
        ("compare.csv", &compare::csv(&report)?),
        ("compare.md", &compare::markdown(&report)),
        ("compare-traces.svg", &traces),
        ("compare-switchings.svg", &compare::error_against_switchings(&report)?),
    ])?;
    print(&if arguments.json { data } else { compare::text(&report) })?;
    Ok(())
}

fn tune_peers(budget: usize, json: bool) -> Result<(), Failure> {
    let peers = compare::contender::Kind::PEERS;
    let bar = crate::progress::bar(budget * peers.len(), "candidates");
    let all =
        peers.map(|peer| compare::tune::tune(peer, budget, || bar.inc(1))).into_iter().collect::<Result<Vec<_>>>()?;
    bar.finish_and_clear();
    let data = serde_json::to_value(&all).map_err(anyhow::Error::from)?;
    print(&if json { format!("{data:#}\n") } else { compare::tune::text(&all) })?;
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
