//! `host-sim campaign` on the command line.

use super::draw::{Case, Choice};
use super::kind::Kind;
use super::replay as replay_module;
use super::shard::{self, Campaign, Part, Shard};
use crate::cli::{Failure, folder, print};
use crate::metrics::summarise;
use crate::report::{self, Folder};
use anyhow::{Result, anyhow};
use clap::{Args, Subcommand};
use model_core::controller::Controller;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct CampaignArguments {
    #[command(subcommand)]
    merge: Option<CampaignCommand>,
    /// How many runs.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    runs: u64,
    /// Seed: with a run's number it decides everything about that run.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Every run has this fault.
    #[arg(long, value_name = "NAME", value_parser = known_fault)]
    fault: Option<String>,
    /// Every run has this program: a built-in sequence, or by-hand.
    #[arg(long, value_name = "NAME", value_parser = known_program)]
    sequence: Option<String>,
    /// Of N parts of the campaign the I-th, from 1: to be joined by `campaign merge`.
    #[arg(long, value_name = "I/N", value_parser = Shard::parse)]
    shard: Option<Shard>,
    /// Makes these runs once more, with all that happened and the ordinary report of each.
    #[arg(long, value_name = "RUN", num_args = 1.., conflicts_with = "shard")]
    replay: Vec<u64>,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
    /// Where result, tables, picture and reports go.
    #[arg(long, value_name = "DIR", default_value = "target/campaign")]
    out: PathBuf,
}

#[derive(Debug, Subcommand)]
enum CampaignCommand {
    /// Joins the results of all shards: the same counts as of one machine.
    Merge {
        /// The shards' `campaign.json` files, in any order.
        #[arg(value_name = "FILES", required = true)]
        files: Vec<PathBuf>,
        /// Prints JSON.
        #[arg(long)]
        json: bool,
        /// Where result, tables and picture go.
        #[arg(long, value_name = "DIR", default_value = "target/campaign")]
        out: PathBuf,
    },
}

fn known_fault(name: &str) -> Result<String, String> {
    Kind::find(name).map(Kind::name)
}

fn known_program(name: &str) -> Result<String, String> {
    Choice::find(name).map(|choice| choice.name().to_owned())
}

/// Runs, joins or makes again.
pub(crate) fn execute(arguments: &CampaignArguments) -> Result<(), Failure> {
    match &arguments.merge {
        Some(CampaignCommand::Merge { files, json, out }) => merge(files, *json, out),
        None if arguments.replay.is_empty() => run(arguments),
        None => replay(arguments),
    }
}

fn of(arguments: &CampaignArguments) -> Campaign {
    Campaign {
        schema: shard::SCHEMA,
        seed: arguments.seed,
        runs: arguments.runs,
        fault: arguments.fault.clone(),
        sequence: arguments.sequence.clone(),
    }
}

fn run(arguments: &CampaignArguments) -> Result<(), Failure> {
    let folder = folder(&arguments.out)?;
    let campaign = of(arguments);
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let bar = crate::progress::bar(shard.runs(campaign.runs) as usize, "runs");
    let result = super::run_all::<Controller>(&campaign, shard, &bar);
    bar.finish_and_clear();
    tell(&Part { campaign, shard: arguments.shard, result }, arguments.json, &folder)
}

fn merge(files: &[PathBuf], json: bool, out: &Path) -> Result<(), Failure> {
    let folder = folder(out)?;
    let read = |path: &PathBuf| match std::fs::read_to_string(path) {
        Ok(text) => Ok((path.display().to_string(), text)),
        Err(error) => Err(Failure::Input(format!("cannot read {}: {error}", path.display()))),
    };
    let parts = files.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let whole = shard::merge(&parts).map_err(|error| Failure::Input(format!("{error:#}")))?;
    tell(&whole, json, &folder)
}

/// Writes and prints a result; one with violations ends in an error.
fn tell(part: &Part, json: bool, folder: &Folder) -> Result<(), Failure> {
    let data = part.json()?;
    let text = super::text(part);
    folder.write(&[
        ("campaign.json", data.as_str()),
        ("campaign.md", &super::markdown(part)),
        ("campaign.csv", &super::csv(part)?),
        ("campaign.txt", &text),
        ("detection-matrix.svg", &super::picture(part)?),
    ])?;
    print(if json { &data } else { &text })?;
    match part.result.violated() {
        0 => Ok(()),
        violated => Err(Failure::Run(anyhow!("properties were violated {violated} times: see the failing runs"))),
    }
}

fn replay(arguments: &CampaignArguments) -> Result<(), Failure> {
    let filter = of(arguments).filter();
    for &index in &arguments.replay {
        let place = arguments.out.join(format!("run-{index}"));
        let folder = folder(&place)?;
        let case = Case::draw(arguments.seed, index, &filter);
        let (outcome, trace) = replay_module::replay(&case, arguments.seed);
        let files = report::write(&folder, &trace, &summarise(&trace), &case.plant)?;
        let text = replay_module::text(&case, &outcome);
        print(&format!("{text}  report: {}\n", files[0].display()))?;
    }
    Ok(())
}
