//! `host-sim paper` on the command line.

use super::{measure, picture, table};
use crate::cli::{Failure, folder, print};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct PaperArguments {
    /// Prints JSON.
    #[arg(long)]
    json: bool,
    /// Where tables and pictures go.
    #[arg(long, value_name = "DIR", default_value = "target/paper")]
    out: PathBuf,
}

pub(crate) fn execute(arguments: &PaperArguments) -> Result<(), Failure> {
    let folder = folder(&arguments.out)?;
    let report = measure()?;
    let data = format!("{:#}\n", serde_json::to_value(&report).map_err(anyhow::Error::from)?);
    folder.write(&[
        ("paper.json", data.as_str()),
        ("paper.md", &table::paper(&report)),
        ("kinematics.md", &table::kinematics(&report.kinematics)),
        ("paper-bend.svg", &picture::bend(&report)?),
        ("paper-force.svg", &picture::force(&report)?),
        ("paper-combinations.svg", &picture::combinations(&report)?),
        ("paper-points.svg", &picture::points(&report)?),
        ("paper-equations.svg", &picture::equations()?),
    ])?;
    print(&if arguments.json { data } else { table::text(&report) })?;
    Ok(())
}
