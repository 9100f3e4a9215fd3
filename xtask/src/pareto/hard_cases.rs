//! What each method returns where such methods go wrong: measured by host-sim, held to the committed baseline, shown in
//! docs/hard-cases.md.

use crate::baseline::{Baseline, Margin, rounded};
use crate::{host_sim, markers};
use anyhow::{Context, Result};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// What a change is held to.
const BASELINE: Baseline = Baseline {
    file: "docs/figures/hard-cases.json",
    renew: "cargo xtask pareto --write",
    lists: &["methods"],
    words: &["method"],
    margin,
};

/// The margin of a figure by its name; `None` for what is no figure. What moves is the last digits of the reference, which
/// are those of the host's sine.
fn margin(name: &str) -> Option<Margin> {
    let amount = match name {
        "largest_bend_jump_lsb" | "largest_pressure_jump_lsb" => 0.05,
        "first_bit_relative_error"
        | "limit_pressure_relative_error"
        | "limit_bend_error_deg"
        | "round_trip_error_kpa"
        | "round_trip_error_deg" => 1e-9,
        // Nothing but zero is right.
        "at_or_below_zero" | "not_a_number" => return Some(Margin { part: 0.0, amount: 0.0 }),
        _ => return None,
    };
    Some(Margin { part: 0.01, amount })
}

/// The figures of host-sim's report: errors, each at least 0, and 0 where all is well.
///
/// # Errors
/// When it is no such report.
fn figures(report: &str) -> Result<String> {
    let report: Value = serde_json::from_str(report)?;
    let cases = &report["hard_cases"];
    let methods = cases["methods"].as_array().context("host-sim's report has no list 'methods' of hard cases")?;
    let of =
        |value: &Value, name: &str| value.as_f64().with_context(|| format!("no number '{name}' in the hard cases"));
    let exact = |name: &str| of(&cases["exact"][name], name);
    let mut entries = Vec::new();
    for method in methods {
        let number = |name: &str| of(&method[name], name);
        let largest = |names: &[&str]| -> Result<f64> {
            let mut largest = 0.0_f64;
            for name in names {
                let values = method[name].as_array().cloned().unwrap_or_else(|| vec![method[name].clone()]);
                for value in values {
                    largest = largest.max(of(&value, name)?.abs());
                }
            }
            Ok(largest)
        };
        let pressure = of(&method["pole_pressure_kpa"][0], "pole_pressure_kpa")?;
        let bend = of(&method["beyond_bend_deg"][0], "beyond_bend_deg")?;
        let mut entry = json!({
            "at_or_below_zero": largest(&["zero_bend_deg", "below_zero_bend_deg", "below_zero_pressure_kpa"])?,
            "first_bit_relative_error": number("first_bit_relative_error")?.abs(),
            "limit_bend_error_deg": (bend - exact("limit_bend_deg")?).abs(),
            "limit_pressure_relative_error": (pressure / exact("limit_pressure_kpa")? - 1.0).abs(),
            "largest_bend_jump_lsb": number("largest_bend_jump_lsb")?,
            "largest_pressure_jump_lsb": number("largest_pressure_jump_lsb")?,
            "round_trip_error_kpa": number("round_trip_error_kpa")?,
            "round_trip_error_deg": number("round_trip_error_deg")?,
        });
        let floats = &method["floats"];
        if !floats.is_null() {
            let bend = of(&floats["nan_bend_deg"], "nan_bend_deg")?.abs();
            entry["not_a_number"] = json!(bend.max(of(&floats["nan_pressure_kpa"], "nan_pressure_kpa")?.abs()));
        }
        for (_, figure) in entry.as_object_mut().context("an object")? {
            *figure = rounded(figure);
        }
        entry["method"] = method["method"].clone();
        entries.push(entry);
    }
    Ok(format!("{:#}", json!({ "methods": entries })))
}

fn read(folder: &Path, name: &str) -> Result<String> {
    fs::read_to_string(folder.join(name)).with_context(|| format!("host-sim left no {name}"))
}

/// Renews baseline and page.
pub fn write() -> Result<()> {
    let folder = host_sim::pareto(&[])?;
    BASELINE.write(&figures(&read(&folder, "pareto-inverse.json")?)?)?;
    markers::replace("docs/hard-cases.md", "hard-cases", &read(&folder, "hard-cases.md")?)?;
    eprintln!("docs/hard-cases.md");
    Ok(())
}

/// Asks anew and compares with the baseline.
pub fn gate() -> Result<()> {
    BASELINE.gate(&figures(&read(&host_sim::pareto(&[])?, "pareto-inverse.json")?)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::tests::assert_holds;

    fn report() -> Value {
        json!({ "hard_cases": {
            "exact": { "limit_bend_deg": 149.8, "limit_pressure_kpa": 27_500.0 },
            "methods": [{
                "method": "f32-newton", "zero_bend_deg": 0.0, "first_bit_relative_error": -0.002,
                "below_zero_bend_deg": [0.0, 0.0, 0.0], "below_zero_pressure_kpa": [0.0, -0.0, 0.0],
                "beyond_bend_deg": [149.7, 149.7, 149.7], "pole_pressure_kpa": [27_527.5, 27_527.5, 27_527.5, 27_527.5],
                "largest_bend_jump_lsb": 1.0, "largest_pressure_jump_lsb": 40.0,
                "round_trip_error_kpa": 1e-4, "round_trip_error_deg": 0.02,
                "floats": { "nan_bend_deg": 0.0, "nan_pressure_kpa": 0.0 },
            }],
        } })
    }

    fn of(report: &Value) -> Value {
        serde_json::from_str(&figures(&report.to_string()).expect("a report")).expect("JSON")
    }

    #[test]
    fn each_figure_fails_just_beyond_its_margin() {
        let edges = [
            ("at_or_below_zero", json!(0.0), json!(1e-9)),
            ("not_a_number", json!(0.0), json!(1e-9)),
            ("first_bit_relative_error", json!(0.002_020), json!(0.002_022)),
            ("limit_bend_error_deg", json!(0.101), json!(0.1011)),
            ("limit_pressure_relative_error", json!(0.001_010), json!(0.001_012)),
            ("largest_bend_jump_lsb", json!(1.059), json!(1.061)),
            ("largest_pressure_jump_lsb", json!(40.44), json!(40.46)),
            ("round_trip_error_kpa", json!(1.01e-4), json!(1.0101e-4)),
            ("round_trip_error_deg", json!(0.0202), json!(0.020_201)),
        ];
        assert_holds(&BASELINE, &of(&report()), &edges);
    }

    #[test]
    fn the_worst_of_several_answers_counts() {
        let mut changed = report();
        changed["hard_cases"]["methods"][0]["below_zero_pressure_kpa"][1] = json!(-3.0);
        assert_eq!(of(&changed)["methods"][0]["at_or_below_zero"], json!(3.0));
        let fixed = &mut changed["hard_cases"]["methods"][0];
        fixed["floats"] = Value::Null;
        assert_eq!(of(&changed)["methods"][0].get("not_a_number"), None);
        changed["hard_cases"]["methods"][0]["round_trip_error_deg"] = json!("far");
        assert!(figures(&changed.to_string()).expect_err("refused").to_string().contains("'round_trip_error_deg'"));
    }
}
