//! The methods side by side: measured on host and emulated Cortex-M4, held to the committed baseline, drawn.

mod baseline;
mod figures;
mod plot;

use crate::{command, markers, root, run, toolchain};
use anyhow::{Context, Result, ensure};
use figures::{Direction, Report};
use std::fs;
use std::process::Stdio;

/// What a change is held to.
const BASELINE: &str = "docs/figures/pareto.json";

/// Builds `counted` for the Cortex-M4: target/counted/counted.elf.
fn build() -> Result<()> {
    let (mut cargo, folder) = toolchain::cargo_build(toolchain::set_up()?);
    run(cargo.args(["--quiet", "--package", "counted", "--bin", "counted"]))?;
    let out = root().join("target").join("counted");
    fs::create_dir_all(&out)?;
    fs::copy(folder.join("counted"), out.join("counted.elf")).context("the build left no ELF")?;
    Ok(())
}

fn measurement() -> Result<std::process::Command> {
    toolchain::set_up_emulator()?;
    build()?;
    let mut cargo = command("cargo");
    cargo.args(["run", "--quiet", "--release", "--package", "emulated-board", "--bin", "pareto", "--"]);
    Ok(cargo)
}

/// Measures; returns the figures as JSON text.
fn measure() -> Result<String> {
    let output = measurement()?.arg("--json").stderr(Stdio::inherit()).output()?;
    ensure!(output.status.success(), "the methods could not be measured");
    Ok(String::from_utf8(output.stdout)?)
}

/// Measures and prints; with `write`, renews baseline, pictures and the documents' tables.
pub fn pareto(json: bool, write: bool) -> Result<()> {
    if !write {
        return run(measurement()?.args(json.then_some("--json")));
    }
    let text = measure()?;
    let report = Report::parse(&text)?;
    let path = root().join(BASELINE);
    fs::create_dir_all(path.parent().context("a file in a folder")?)?;
    fs::write(&path, format!("{}\n", text.trim_end()))?;
    eprintln!("{BASELINE}");
    for direction in Direction::BOTH {
        let name = format!("pareto-{}", direction.name());
        let picture = format!("docs/images/{name}.svg");
        fs::write(root().join(&picture), plot::picture(&report, direction)?)?;
        eprintln!("{picture}");
        markers::replace("docs/inverse.md", &name, &report.table(direction))?;
        markers::replace("README.md", &name, &report.front_table(direction))?;
    }
    eprintln!("docs/inverse.md, README.md");
    if json {
        println!("{}", text.trim_end());
    } else {
        for direction in Direction::BOTH {
            println!("{}", report.table(direction));
        }
    }
    Ok(())
}

/// Measures anew and compares with the baseline.
pub fn gate() -> Result<()> {
    let committed = fs::read_to_string(root().join(BASELINE))
        .with_context(|| format!("{BASELINE} is missing: write it with `cargo xtask pareto --write`"))?;
    let comparison = baseline::compare(&committed, &measure()?)?;
    for line in &comparison.better {
        println!("better: {line}");
    }
    if !comparison.better.is_empty() {
        println!("the baseline can be tightened: `cargo xtask pareto --write`");
    }
    ensure!(
        comparison.worse.is_empty(),
        "worse than {BASELINE}:\n  {}\nif that is meant: `cargo xtask pareto --write`",
        comparison.worse.join("\n  ")
    );
    println!("{} figures within their margins of {BASELINE}", comparison.compared);
    Ok(())
}
