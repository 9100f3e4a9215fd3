//! `host-sim report` on the command line.

use super::recording;
use crate::cli::{Failure, folder, print};
use crate::run::text;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct ReportArguments {
    /// The recording: of `monitor`, or the samples.csv of a run. A cut file will do.
    #[arg(value_name = "FILE.csv")]
    file: PathBuf,
    /// Prints the figures as JSON.
    #[arg(long)]
    json: bool,
    /// Where the report goes.
    #[arg(long, value_name = "DIR", default_value = "target/report")]
    out: PathBuf,
}

/// Opens a recording and writes its report.
pub(crate) fn execute(arguments: &ReportArguments) -> Result<(), Failure> {
    let opened = recording::open(&arguments.file).map_err(|error| Failure::Input(format!("{error:#}")))?;
    let folder = folder(&arguments.out)?;
    let files = opened.write(&folder)?;
    if arguments.json {
        let mut json = serde_json::to_value(&opened.summary).map_err(anyhow::Error::from)?;
        json["rows"] = opened.recording.records.len().into();
        json["torn"] = opened.recording.torn.into();
        json["bad_lines"] = opened.recording.bad_lines.into();
        json["true_pressures"] = opened.true_pressures.into();
        json["notes"] = opened.notes.into();
        json["files"] = files.iter().map(|path| path.display().to_string()).collect();
        print(&format!("{json:#}\n"))?;
    } else {
        print(&text(&opened.name, &opened.description(), &opened.summary))?;
        let notes = opened.notes.iter().map(|note| format!("note: {note}\n")).collect::<Vec<_>>().concat();
        print(&format!("{notes}report: {}\n", files[0].display()))?;
    }
    Ok(())
}
