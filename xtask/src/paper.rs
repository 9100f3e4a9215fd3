//! Renews docs/paper.md, docs/kinematics.md and their pictures from `host-sim paper`.

use crate::{host_sim, markers, root};
use anyhow::{Context, Result};
use std::fs;

/// The pictures that the documents show.
const PICTURES: [&str; 5] =
    ["paper-bend.svg", "paper-force.svg", "paper-combinations.svg", "paper-points.svg", "paper-equations.svg"];

/// Computes the paper's tables and curves; renews the documents' parts and pictures.
pub fn paper() -> Result<()> {
    let folder = host_sim::paper()?;
    for name in ["paper", "kinematics"] {
        let file = format!("{name}.md");
        let part = fs::read_to_string(folder.join(&file)).with_context(|| format!("host-sim left no {file}"))?;
        let document = format!("docs/{file}");
        markers::replace(&document, name, &part)?;
        println!("{document}");
    }
    for name in PICTURES {
        let picture = format!("docs/images/{name}");
        fs::copy(folder.join(name), root().join(&picture)).with_context(|| format!("host-sim left no {name}"))?;
        println!("{picture}");
    }
    Ok(())
}
