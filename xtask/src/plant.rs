//! The simulated plant's integrators: measured by host-sim, held to the committed baseline, shown in docs/simulator.md.

use crate::baseline::{Baseline, Margin, rounded};
use crate::{host_sim, markers, root};
use anyhow::{Context, Result};
use serde_json::{Map, Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// What a change is held to.
const BASELINE: Baseline = Baseline {
    file: "docs/figures/plant.json",
    renew: "cargo xtask plant --write",
    lists: &["integrators", "stiff_cases", "switches"],
    words: &["integrator", "step", "case", "scene"],
    margin,
};

/// Figures of an integrator that are the same on every machine, and those of a part of the scene that is left out.
const OF_INTEGRATORS: [&str; 5] =
    ["max_error_kpa", "rms_error_kpa", "max_bend_error_deg", "evaluations_per_tick", "closed_drift_nl"];
const OF_SWITCHES: [&str; 3] = ["max_error_kpa", "rms_error_kpa", "max_bend_error_deg"];

/// The margin of a figure by its name; `None` for what is no figure. Errors move with the
/// last digits of the host's sine, through thousands of ticks; the amount is what the reference itself is worth.
fn margin(name: &str) -> Option<Margin> {
    if name.ends_with("error_kpa") || name.ends_with("error_deg") {
        Some(Margin { part: 0.05, amount: 1e-6 })
    } else if name == "evaluations_per_tick" {
        Some(Margin { part: 0.05, amount: 0.01 })
    } else if name == "closed_drift_nl" {
        // Rounding of sums of about 0.1 NL, nothing else.
        Some(Margin { part: 0.0, amount: 1e-14 })
    } else {
        None
    }
}

/// What of host-sim's report is the same on every machine, as the baseline has it. An integrator that is unstable in a
/// stiff case has no error there, `null`: how far it swings is chance.
///
/// # Errors
/// When it is no such report.
fn figures(report: &str) -> Result<String> {
    let report: Value = serde_json::from_str(report)?;
    let rows = |list: &str| report[list].as_array().with_context(|| format!("host-sim's report has no list '{list}'"));
    let (mut integrators, mut stiff_cases, mut switches) = (Vec::new(), Vec::new(), Vec::new());
    for row in rows("integrators")? {
        integrators.push(picked(row, &["integrator", "step"], &OF_INTEGRATORS)?);
        for case in row["stiff"].as_array().context("an integrator without 'stiff'")? {
            let stable = case["stable"].as_bool().context("a stiff case without 'stable'")?;
            stiff_cases.push(json!({
                "integrator": row["integrator"], "step": row["step"], "case": case["case"],
                "max_error_kpa": if stable { rounded(&case["max_error_kpa"]) } else { Value::Null },
            }));
        }
    }
    for row in rows("switches")? {
        let mut entry = picked(row, &[], &OF_SWITCHES)?;
        let left_out = row["left_out"].as_str().context("a switch without 'left_out'")?;
        entry["scene"] = json!(format!("scene, left out: {left_out}"));
        switches.push(entry);
    }
    let lists = json!({ "integrators": integrators, "stiff_cases": stiff_cases, "switches": switches });
    Ok(format!("{lists:#}"))
}

/// An entry of these words and figures.
fn picked(row: &Value, words: &[&str], figures: &[&str]) -> Result<Value> {
    let mut entry = Map::new();
    for name in words.iter().chain(figures) {
        let value = row.get(*name).with_context(|| format!("host-sim's report has a row without '{name}'"))?;
        entry.insert((*name).to_owned(), rounded(value));
    }
    Ok(Value::Object(entry))
}

/// Runs the comparison; returns its folder and the figures.
fn measure() -> Result<(PathBuf, String)> {
    let folder = host_sim::pareto(&["--plant"])?;
    let figures = figures(&read(&folder, "plant-pareto.json")?)?;
    Ok((folder, figures))
}

fn read(folder: &Path, name: &str) -> Result<String> {
    fs::read_to_string(folder.join(name)).with_context(|| format!("host-sim left no {name}"))
}

/// Measures and prints the tables; with `write`, renews baseline, picture and docs/simulator.md's part.
pub fn plant(write: bool) -> Result<()> {
    let (folder, figures) = measure()?;
    let tables = read(&folder, "plant-pareto.md")?;
    println!("{}", tables.trim_end());
    if write {
        BASELINE.write(&figures)?;
        let picture = "docs/images/plant-pareto.svg";
        fs::copy(folder.join("plant-pareto.svg"), root().join(picture)).context("host-sim left no plant-pareto.svg")?;
        eprintln!("{picture}");
        markers::replace("docs/simulator.md", "plant-pareto", &tables)?;
        eprintln!("docs/simulator.md");
    }
    Ok(())
}

/// Measures anew and compares with the baseline.
pub fn gate() -> Result<()> {
    BASELINE.gate(&measure()?.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::tests::assert_holds;

    /// What host-sim writes, in small.
    fn report() -> Value {
        json!({
            "ticks": 16_000, "reference_tolerance": 1e-10,
            "integrators": [{
                "integrator": "ROS2", "step": "1 ms", "default": true, "dominated": false,
                "max_error_kpa": 0.004_800_04, "rms_error_kpa": 1e-4, "max_bend_error_deg": 0.018,
                "evaluations_per_tick": 1.64, "simulated_seconds_per_second": 5800.0,
                "fastest_simulated_seconds_per_second": 5900.0, "closed_drift_nl": 1e-16,
                "stiff": [
                    { "case": "burst", "max_error_kpa": 0.024, "stable": true },
                    { "case": "small manifold", "max_error_kpa": 11.0, "stable": false },
                ],
            }],
            "switches": [{
                "left_out": "finger_lag", "time_ratio": 0.84, "max_error_kpa": 2.3, "rms_error_kpa": 0.34,
                "max_bend_error_deg": 9.8, "rms_pressure_reading_kpa": 0.36, "rms_bend_reading_deg": 3.7,
            }],
        })
    }

    fn of(report: &Value) -> Value {
        serde_json::from_str(&figures(&report.to_string()).expect("a report")).expect("JSON")
    }

    #[test]
    fn only_what_is_the_same_everywhere_is_kept() {
        let kept = of(&report());
        assert_eq!(kept["integrators"][0]["max_error_kpa"], json!(0.0048));
        assert_eq!(kept["stiff_cases"][0]["max_error_kpa"], json!(0.024));
        assert_eq!(
            kept["stiff_cases"][1],
            json!({
                "integrator": "ROS2", "step": "1 ms", "case": "small manifold", "max_error_kpa": null,
            })
        );
        let text = kept.to_string();
        for word in ["second", "time", "dominated", "reading"] {
            assert!(!text.contains(word), "{word}");
        }
    }

    #[test]
    fn each_figure_fails_just_beyond_its_margin() {
        let edges = [
            ("max_error_kpa", json!(0.005_040), json!(0.005_042)),
            ("rms_error_kpa", json!(1.059e-4), json!(1.061e-4)),
            ("max_bend_error_deg", json!(0.018_90), json!(0.018_902)),
            ("evaluations_per_tick", json!(1.731), json!(1.733)),
            ("closed_drift_nl", json!(1.0e-14), json!(1.02e-14)),
        ];
        assert_holds(&BASELINE, &of(&report()), &edges);
    }

    #[test]
    fn an_integrator_that_becomes_unstable_fails_and_one_that_becomes_stable_is_told() {
        let (was, mut now) = (of(&report()).to_string(), report());
        now["integrators"][0]["stiff"][0]["stable"] = json!(false);
        let worse = BASELINE.compare(&was, &of(&now).to_string()).expect("two reports").worse;
        assert!(worse.len() == 1 && worse[0].starts_with("ROS2 1 ms burst: max_error_kpa is inf"), "{worse:?}");
        let told = BASELINE.compare(&of(&now).to_string(), &was).expect("two reports");
        assert_eq!((told.worse.len(), told.better.len()), (0, 1));
    }

    #[test]
    fn a_row_that_went_or_came_is_named() {
        let mut now = report();
        now["integrators"][0]["step"] = json!("0.5 ms");
        let worse = BASELINE.compare(&of(&report()).to_string(), &of(&now).to_string()).expect("two reports").worse;
        assert!(worse.contains(&"ROS2 1 ms: in the baseline, but not measured any more".to_owned()), "{worse:?}");
        assert!(worse.contains(&"ROS2 0.5 ms: measured, but not in the baseline".to_owned()), "{worse:?}");
        // A report of another shape is refused with the name of what is missing.
        now["integrators"][0].as_object_mut().expect("a row").remove("rms_error_kpa");
        assert!(figures(&now.to_string()).expect_err("refused").to_string().contains("'rms_error_kpa'"));
    }
}
