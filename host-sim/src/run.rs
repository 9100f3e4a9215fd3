//! `host-sim run`: one run, its report and its summary.

use crate::cli::{Failure, OnElf, bends, folder, print, setpoints, start_elf, unknown_sequence};
use crate::metrics::{Summary, summarise};
use crate::report;
use crate::simulate::{Program, Run};
use anyhow::anyhow;
use clap::Args;
use model_core::sequence::library;
use model_core::units::{Bend, Pressure};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct RunArguments {
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

/// Runs, and writes the report.
pub(crate) fn execute(arguments: &RunArguments, on_elf: Option<OnElf>) -> Result<(), Failure> {
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
