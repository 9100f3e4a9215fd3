//! The campaign's tables and picture in docs/campaign.md, from its committed result.

use crate::{command, markers, root};
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::Path;
use std::process::Stdio;

/// The committed result.
const RESULT: &str = "docs/figures/campaign.json";
/// How many runs it has, and with which seed.
const RUNS: &str = "30000";
const SEED: &str = "2026";

/// Starts `host-sim campaign`; one that found violations has its result all the same.
fn host_sim(arguments: &[&str], out: &Path) -> Result<()> {
    let mut cargo = command("cargo");
    cargo.args(["run", "--release", "--quiet", "--package", "host-sim", "--", "campaign"]).args(arguments);
    cargo.arg("--out").arg(out).stdout(Stdio::null());
    let status = cargo.status().context("cannot start cargo")?;
    ensure!(matches!(status.code(), Some(0 | 1)), "host-sim campaign ended with {status}");
    Ok(())
}

/// Renews docs/campaign.md and its picture from the committed result; with `write`, the result too, in some minutes.
pub fn campaign(write: bool) -> Result<()> {
    let out = root().join("target").join("campaign-docs");
    if write {
        host_sim(&["--runs", RUNS, "--seed", SEED], &out)?;
        fs::copy(out.join("campaign.json"), root().join(RESULT)).context("host-sim left no campaign.json")?;
        eprintln!("{RESULT}");
    }
    host_sim(&["merge", RESULT], &out)?;
    let tables = fs::read_to_string(out.join("campaign.md")).context("host-sim left no campaign.md")?;
    markers::replace("docs/campaign.md", "campaign", &tables)?;
    eprintln!("docs/campaign.md");
    let picture = "docs/images/detection-matrix.svg";
    fs::copy(out.join("detection-matrix.svg"), root().join(picture)).context("host-sim left no picture")?;
    eprintln!("{picture}");
    Ok(())
}
