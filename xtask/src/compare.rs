//! Renews docs/compare.md and its pictures from `host-sim compare`.

use crate::{host_sim, markers, root};
use anyhow::{Context, Result};
use std::fs;

/// Runs the comparison; renews the document's part and the pictures in docs/images.
pub fn compare() -> Result<()> {
    let folder = host_sim::compare()?;
    let read = |name: &str| fs::read_to_string(folder.join(name)).with_context(|| format!("host-sim left no {name}"));
    markers::replace("docs/compare.md", "compare", &read("compare.md")?)?;
    println!("docs/compare.md");
    for name in ["compare-traces.svg", "compare-switchings.svg"] {
        let picture = format!("docs/images/{name}");
        fs::write(root().join(&picture), read(name)?).with_context(|| format!("cannot write {picture}"))?;
        println!("{picture}");
    }
    Ok(())
}
