//! `host-sim pareto` on the command line.

use crate::cli::{Failure, folder, print};
use std::path::Path;

/// The ways to compute the model.
pub(crate) fn inverse(json: bool, out: &Path) -> Result<(), Failure> {
    let folder = folder(out)?;
    print(&super::inverse::run(json, &folder)?)?;
    Ok(())
}

/// The plant's integrators.
pub(crate) fn plant(json: bool, out: &Path) -> Result<(), Failure> {
    let folder = folder(out)?;
    let bar = crate::progress::bar(1, "measurements");
    let report = super::plant::measure(|done, total| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    })?;
    bar.finish_and_clear();
    let picture = super::plant::picture(&report)?;
    let table = super::plant::csv(&report)?;
    let markdown = super::plant::markdown(&report);
    let data = format!("{:#}\n", serde_json::to_value(&report).map_err(anyhow::Error::from)?);
    folder.write(&[
        ("plant-pareto.svg", picture.as_str()),
        ("plant-pareto.csv", &table),
        ("plant-pareto.md", &markdown),
        ("plant-pareto.json", &data),
    ])?;
    print(&if json { data } else { super::plant::text(&report) })?;
    Ok(())
}
