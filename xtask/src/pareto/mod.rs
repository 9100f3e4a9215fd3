//! The methods side by side: measured on host and emulated Cortex-M4, held to the committed baseline, drawn; and what they
//! do in the hard cases.

mod figures;
mod hard_cases;
mod labels;
mod plot;

use crate::baseline::{Baseline, Margin};
use crate::{command, markers, root, run, toolchain};
use anyhow::{Context, Result, ensure};
pub use figures::grouped;
use figures::{Direction, Report};
use std::fs;
use std::process::Stdio;

/// What a change is held to.
const BASELINE: Baseline = Baseline {
    file: "docs/figures/pareto.json",
    renew: "cargo xtask pareto --write",
    lists: &["methods", "references"],
    words: &["method", "direction", "function"],
    margin,
};

/// The margin of a figure by its name; `None` for what is no figure. Errors are computed on the host and should not
/// move at all, but for the last digits of the reference in f64 itself, which are those of the host's sine;
/// instructions and sizes differ between the compilers of xtask's two routes.
fn margin(name: &str) -> Option<Margin> {
    if name.starts_with("max_error") || name.starts_with("rms_error") {
        Some(Margin { part: 0.01, amount: 1e-9 })
    } else if name.contains("instructions") {
        Some(Margin { part: 0.1, amount: 4.0 })
    } else if name.contains("flash") {
        Some(Margin { part: 0.1, amount: 64.0 })
    } else if name == "ram_bytes" || name == "calls_that_differ_from_host" {
        Some(Margin { part: 0.0, amount: 0.0 })
    } else {
        None
    }
}

/// Builds `counted` for the Cortex-M4: target/counted/counted.elf.
pub fn build() -> Result<()> {
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
    cargo.args(["run", "--quiet", "--package", "emulated-board", "--bin", "pareto", "--"]);
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
    BASELINE.write(&text)?;
    for direction in Direction::BOTH {
        let name = format!("pareto-{}", direction.name());
        let picture = format!("docs/images/{name}.svg");
        fs::write(root().join(&picture), plot::picture(&report, direction)?)?;
        eprintln!("{picture}");
        markers::replace("docs/inverse.md", &name, &report.table(direction))?;
        markers::replace("README.md", &name, &report.front_table(direction))?;
    }
    markers::replace("docs/kinematics.md", "functions", &report.functions_table()?)?;
    eprintln!("docs/inverse.md, docs/kinematics.md, README.md");
    hard_cases::write()?;
    if json {
        println!("{}", text.trim_end());
    } else {
        for direction in Direction::BOTH {
            println!("{}", report.table(direction));
        }
    }
    Ok(())
}

/// Measures anew and compares with the baselines.
pub fn gate() -> Result<()> {
    BASELINE.gate(&measure()?)?;
    hard_cases::gate()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::tests::assert_holds;
    use serde_json::json;

    #[test]
    fn each_figure_fails_just_beyond_its_margin() {
        let report = json!({
            "methods": [{
                "method": "newton", "direction": "bend", "summary": "words", "calls": 7, "host_time_ratio": 0.5,
                "max_error_deg": 1e-5, "rms_error_working_deg": 1e-6, "instructions_cortex_m4_worst": 1000,
                "prepare_instructions_cortex_m4": 20, "flash_code_bytes": 2000, "flash_table_bytes": 0, "ram_bytes": 12,
                "calls_that_differ_from_host": 0,
            }],
            "references": [{ "function": "cossin", "max_error_full_scale": 1e-5 }],
        });
        let edges = [
            ("max_error_deg", json!(1.0099e-5), json!(1.0103e-5)),
            ("rms_error_working_deg", json!(1.0109e-6), json!(1.0112e-6)),
            ("max_error_full_scale", json!(1.0099e-5), json!(1.0103e-5)),
            ("instructions_cortex_m4_worst", json!(1104), json!(1105)),
            ("prepare_instructions_cortex_m4", json!(26), json!(27)),
            ("flash_code_bytes", json!(2264), json!(2265)),
            ("flash_table_bytes", json!(64), json!(65)),
            ("ram_bytes", json!(12), json!(13)),
            ("calls_that_differ_from_host", json!(0), json!(1)),
        ];
        assert_holds(&BASELINE, &report, &edges);
    }

    /// What the documents show is the baseline, not what somebody typed.
    #[test]
    fn documents_and_pictures_show_the_baseline() {
        let report = Report::parse(&BASELINE.committed().expect("committed")).expect("complete");
        let read = |file: &str| fs::read_to_string(root().join(file)).expect(file);
        let kinematics = read("docs/kinematics.md");
        let functions = markers::content(&kinematics, "functions").expect("docs/kinematics.md");
        assert_eq!(functions, report.functions_table().expect("complete").trim_end());
        for direction in Direction::BOTH {
            let name = format!("pareto-{}", direction.name());
            let shown = |file: &str| markers::content(&read(file), &name).expect(file).to_owned();
            assert_eq!(shown("docs/inverse.md"), report.table(direction).trim_end());
            assert_eq!(shown("README.md"), report.front_table(direction).trim_end());
            let picture = plot::picture(&report, direction).expect("draws");
            assert!(read(&format!("docs/images/{name}.svg")) == picture, "{name}: cargo xtask pareto --write");
        }
    }
}
