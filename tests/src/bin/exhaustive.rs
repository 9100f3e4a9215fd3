//! Visits every input of the fixed-point functions; started by `cargo xtask exhaustive`.

use anyhow::{Context, Result, ensure};
use clap::{Parser, ValueEnum};
use finger_tests::exhaustive::report::{Outcome, markdown, placed};
use finger_tests::exhaustive::run::{domain, every_input, visit};
use finger_tests::exhaustive::subjects;
use finger_tests::truth::table::calibrations;
use fixed::types::I8F24;
use indicatif::{ProgressBar, ProgressStyle};
use model_core::calibration;
use model_core::units::Coefficients;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "cargo xtask exhaustive", about = "Visits every input of the fixed-point functions")]
struct Arguments {
    /// The default calibration over all 2^32 inputs, twelve others over their domain, or all of that.
    #[arg(long, value_enum, default_value_t = Calibrations::Default)]
    calibrations: Calibrations,
    /// Prints JSON in place of the table.
    #[arg(long)]
    json: bool,
    /// Writes the table to docs/exhaustive.md.
    #[arg(long)]
    write: bool,
    /// Takes the results from the JSON of earlier runs and visits nothing; may be given more than once.
    #[arg(long, value_name = "FILE", conflicts_with = "calibrations")]
    from: Vec<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Calibrations {
    Default,
    Others,
    All,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let outcomes = if arguments.from.is_empty() { visit_all(arguments.calibrations)? } else { read(&arguments.from)? };
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&outcomes)?);
    } else {
        print!("{}", markdown(&outcomes));
    }
    if arguments.write {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/exhaustive.md");
        let page = std::fs::read_to_string(&path).context("cannot read docs/exhaustive.md")?;
        std::fs::write(&path, placed(&page, &outcomes)?).context("cannot write docs/exhaustive.md")?;
    }
    let complaints: Vec<_> = outcomes.iter().map(Outcome::complaint).filter(|text| !text.is_empty()).collect();
    ensure!(complaints.is_empty(), "{}", complaints.join("\n"));
    Ok(())
}

/// The results of earlier runs, one after the other.
fn read(files: &[PathBuf]) -> Result<Vec<Outcome>> {
    let mut outcomes = Vec::new();
    for path in files {
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        let more: Vec<Outcome> = serde_json::from_str(&text)
            .with_context(|| format!("{} is no result of this program's --json", path.display()))?;
        outcomes.extend(more);
    }
    Ok(outcomes)
}

/// Visits everything that belongs to the choice, under a progress bar.
fn visit_all(choice: Calibrations) -> Result<Vec<Outcome>> {
    let mut plan = Vec::new();
    if choice != Calibrations::Others {
        plan.extend(subjects(&calibration::DEFAULT).into_iter().map(|subject| (subject, every_input())));
    }
    if choice != Calibrations::Default {
        for [k, c1, c2] in calibrations() {
            let bits = I8F24::from_bits;
            let coefficients = Coefficients::new(bits(k), bits(c1), bits(c2))
                .map_err(|error| anyhow::anyhow!("a calibration of the list is not admitted: {error:?}"))?;
            if coefficients != calibration::DEFAULT {
                plan.extend(subjects(&coefficients).into_iter().map(|subject| {
                    let range = domain(subject.direction);
                    (subject, range)
                }));
            }
        }
    }
    let count = |range: &RangeInclusive<i32>| (i64::from(*range.end()) - i64::from(*range.start()) + 1) as u64;
    // Nothing is drawn where stderr is no terminal.
    let bar = ProgressBar::new(plan.iter().map(|(_, range)| count(range)).sum());
    bar.set_style(ProgressStyle::with_template("{msg} {wide_bar} {percent} % {eta} left")?);
    let mut outcomes = Vec::new();
    for (subject, range) in &plan {
        bar.set_message(subject.name);
        outcomes.push(visit(subject, range, |inputs| bar.inc(inputs)));
    }
    bar.finish_and_clear();
    Ok(outcomes)
}
