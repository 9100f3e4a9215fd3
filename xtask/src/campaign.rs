//! The campaign's tables and picture in docs/campaign.md, from its committed result.

use crate::{host_sim, markers, root};
use anyhow::{Context, Result};
use std::fs;

/// The committed result.
const RESULT: &str = "docs/figures/campaign.json";
/// How many runs it has, and with which seed.
const RUNS: &str = "100000";
const SEED: &str = "2026";

/// Renews docs/campaign.md and its picture from the committed result; with `write`, the result too, which takes two cores half an hour.
pub fn campaign(write: bool) -> Result<()> {
    if write {
        let out = host_sim::campaign(&["--runs", RUNS, "--seed", SEED])?;
        fs::copy(out.join("campaign.json"), root().join(RESULT)).context("host-sim left no campaign.json")?;
        eprintln!("{RESULT}");
    }
    let out = host_sim::campaign(&["merge", RESULT])?;
    let tables = fs::read_to_string(out.join("campaign.md")).context("host-sim left no campaign.md")?;
    markers::replace("docs/campaign.md", "campaign", &tables)?;
    eprintln!("docs/campaign.md");
    let picture = "docs/images/detection-matrix.svg";
    fs::copy(out.join("detection-matrix.svg"), root().join(picture)).context("host-sim left no picture")?;
    eprintln!("{picture}");
    Ok(())
}
