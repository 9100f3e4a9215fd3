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
use std::path::Path;
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "cargo xtask exhaustive", about = "Visits every input of the fixed-point functions")]
struct Arguments {
    /// The default calibration over all 2^32 inputs; with `all`, twelve others over their domain as well.
    #[arg(long, value_enum, default_value_t = Calibrations::Default)]
    calibrations: Calibrations,
    /// Prints JSON in place of the table.
    #[arg(long)]
    json: bool,
    /// Writes the table to docs/exhaustive.md.
    #[arg(long)]
    write: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Calibrations {
    Default,
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
    let mut plan: Vec<_> =
        subjects(&calibration::DEFAULT).into_iter().map(|subject| (subject, every_input())).collect();
    if arguments.calibrations == Calibrations::All {
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
