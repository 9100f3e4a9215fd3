//! `host-sim compare` on the command line.

use super::contender::Kind;
use super::scenario::{self, Scenario};
use super::tune;
use crate::cli::{Failure, folder, print};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct CompareArguments {
    /// Only this scenario.
    #[arg(long, value_name = "NAME", value_parser = known)]
    scenario: Option<Scenario>,
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

fn known(name: &str) -> Result<Scenario, String> {
    scenario::find(name).copied().ok_or_else(|| {
        let known: Vec<_> = scenario::ALL.iter().map(|scenario| scenario.name).collect();
        format!("no scenario is named {name:?}; there are {}", known.join(", "))
    })
}

/// Compares, or tunes the peers.
pub(crate) fn execute(arguments: &CompareArguments) -> Result<(), Failure> {
    if let Some(budget) = arguments.tune {
        return tune_peers(budget as usize, arguments.json);
    }
    let folder = folder(&arguments.out)?;
    let scenarios = arguments.scenario.map_or_else(|| scenario::ALL.to_vec(), |one| vec![one]);
    let trials = scenarios.len() * Kind::ALL.len() * arguments.seeds as usize;
    let bar = crate::progress::bar(trials, "trials");
    let report = super::measure(&scenarios, arguments.seeds, || bar.inc(1))?;
    bar.finish_and_clear();
    let mut json = serde_json::to_value(&report).map_err(anyhow::Error::from)?;
    json["targets"] = serde_json::to_value(report.targets()).map_err(anyhow::Error::from)?;
    let data = format!("{json:#}\n");
    let shown = arguments.scenario.or_else(|| scenario::find("60-30-60").copied());
    let traces = shown.map(|scenario| super::traces(&scenario)).transpose()?.unwrap_or_default();
    folder.write(&[
        ("compare.json", data.as_str()),
        ("compare.csv", &super::csv(&report)?),
        ("compare.md", &super::markdown(&report)),
        ("compare-traces.svg", &traces),
        ("compare-switchings.svg", &super::error_against_switchings(&report)?),
    ])?;
    print(&if arguments.json { data } else { super::text(&report) })?;
    Ok(())
}

fn tune_peers(budget: usize, json: bool) -> Result<(), Failure> {
    let peers = Kind::PEERS;
    let bar = crate::progress::bar(budget * peers.len(), "candidates");
    let all = peers.map(|peer| tune::tune(peer, budget, || bar.inc(1))).into_iter().collect::<Result<Vec<_>>>()?;
    bar.finish_and_clear();
    let data = serde_json::to_value(&all).map_err(anyhow::Error::from)?;
    print(&if json { format!("{data:#}\n") } else { tune::text(&all) })?;
    Ok(())
}
