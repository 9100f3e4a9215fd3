//! The comparison of measured figures with the committed ones.

use anyhow::{Context, Result};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// What came of it.
#[derive(Debug, Default, PartialEq)]
pub struct Comparison {
    /// A line for each figure beyond its margin, and for what is missing on either side.
    pub worse: Vec<String>,
    /// A line for each figure that is better by more than its margin.
    pub better: Vec<String>,
    /// Figures compared.
    pub compared: usize,
}

/// How far a figure may move: a part of it, and an amount on top.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Margin {
    part: f64,
    amount: f64,
}

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

/// Compares two reports, JSON as `pareto --json` prints it.
///
/// # Errors
/// When one of them is no such report.
pub fn compare(baseline: &str, measured: &str) -> Result<Comparison> {
    let old = entries(baseline).context("the baseline cannot be read")?;
    let new = entries(measured).context("what was measured cannot be read")?;
    let mut comparison = Comparison::default();
    for (name, figures) in &old {
        match new.get(name) {
            Some(measured) => compare_figures(name, figures, measured, &mut comparison),
            None => comparison.worse.push(format!("{name}: in the baseline, but not measured any more")),
        }
    }
    for name in new.keys().filter(|name| !old.contains_key(*name)) {
        comparison.worse.push(format!("{name}: measured, but not in the baseline"));
    }
    Ok(comparison)
}

/// Each method's direction and each reference with its figures.
fn entries(text: &str) -> Result<BTreeMap<String, Map<String, Value>>> {
    let report: Value = serde_json::from_str(text)?;
    let list = |name: &str| report[name].as_array().cloned().with_context(|| format!("no list '{name}'"));
    let mut entries = BTreeMap::new();
    for entry in list("methods")?.into_iter().chain(list("references")?) {
        let Value::Object(figures) = entry else { anyhow::bail!("an entry is no object") };
        let words = ["method", "direction", "function"].into_iter().filter_map(|word| figures.get(word)?.as_str());
        let name = words.collect::<Vec<_>>().join(" ");
        entries.insert(name, figures);
    }
    Ok(entries)
}

fn compare_figures(name: &str, old: &Map<String, Value>, new: &Map<String, Value>, comparison: &mut Comparison) {
    for (figure, value) in old {
        let Some(Margin { part, amount }) = margin(figure) else { continue };
        // JSON has no infinity; serde_json writes null.
        let number = |value: &Value| if value.is_null() { Some(f64::INFINITY) } else { value.as_f64() };
        let (Some(was), Some(is)) = (number(value), new.get(figure).and_then(number)) else {
            comparison.worse.push(format!("{name}: {figure} is in the baseline, but not measured any more"));
            continue;
        };
        comparison.compared += 1;
        let allowed = was * (1.0 + part) + amount;
        let line = || format!("{name}: {figure} is {is}, the baseline {was}, allowed up to {}", readable(allowed));
        // Four digits are written: the last one may round either way.
        let rounding = 1.0 + 1e-9;
        if is > allowed * rounding {
            comparison.worse.push(line());
        } else if is * (1.0 + part) * rounding + amount < was {
            comparison.better.push(format!("{name}: {figure} is {is}, the baseline {was}"));
        }
    }
    for figure in new.keys().filter(|figure| margin(figure).is_some() && !old.contains_key(*figure)) {
        comparison.worse.push(format!("{name}: {figure} is measured, but not in the baseline"));
    }
}

/// Whole numbers as they are, small ones with four digits.
fn readable(value: f64) -> String {
    if value < 1.0 { format!("{value:.3e}") } else { format!("{value:.1}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn report(change: impl Fn(&mut Map<String, Value>)) -> String {
        let entry = json!({
            "method": "newton", "direction": "bend", "summary": "words", "calls": 7,
            "max_error_deg": 1e-5, "instructions_cortex_m4_worst": 1000, "prepare_instructions_cortex_m4": 20,
            "flash_code_bytes": 2000, "flash_table_bytes": 0, "ram_bytes": 12, "calls_that_differ_from_host": 0,
        });
        let Value::Object(mut entry) = entry else { unreachable!() };
        change(&mut entry);
        json!({ "methods": [entry], "references": [{ "function": "cossin", "max_error_full_scale": 1e-5 }] })
            .to_string()
    }

    fn compared(figure: &str, value: &Value) -> Comparison {
        let new = report(|entry| drop(entry.insert(figure.to_owned(), value.clone())));
        compare(&report(|_| ()), &new).expect("two reports")
    }

    #[test]
    fn equal_reports_pass() {
        let same = compare(&report(|_| ()), &report(|_| ())).expect("two reports");
        assert_eq!(same, Comparison { compared: 8, ..Comparison::default() });
    }

    #[test]
    fn each_figure_fails_just_beyond_its_margin() {
        let edges = [
            ("max_error_deg", json!(1.0099e-5), json!(1.0103e-5)),
            ("instructions_cortex_m4_worst", json!(1104), json!(1105)),
            ("prepare_instructions_cortex_m4", json!(26), json!(27)),
            ("flash_code_bytes", json!(2264), json!(2265)),
            ("flash_table_bytes", json!(64), json!(65)),
            ("ram_bytes", json!(12), json!(13)),
            ("calls_that_differ_from_host", json!(0), json!(1)),
        ];
        for (figure, within, beyond) in edges {
            assert_eq!(compared(figure, &within).worse, Vec::<String>::new(), "{figure}");
            let worse = compared(figure, &beyond).worse;
            assert_eq!(worse.len(), 1, "{figure}: {worse:?}");
            for part in ["newton bend", figure, &format!("is {beyond}"), "baseline"] {
                assert!(worse[0].contains(part), "'{part}' is not in '{}'", worse[0]);
            }
        }
    }

    #[test]
    fn an_error_without_bound_is_worse() {
        assert_eq!(compared("max_error_deg", &Value::Null).worse.len(), 1);
    }

    #[test]
    fn what_is_better_by_more_than_the_margin_is_told() {
        assert_eq!(compared("instructions_cortex_m4_worst", &json!(1000)).better, Vec::<String>::new());
        let better = compared("instructions_cortex_m4_worst", &json!(500));
        assert_eq!((better.better.len(), better.worse.len()), (1, 0));
    }

    #[test]
    fn what_is_missing_on_either_side_fails() {
        let without_figure = report(|entry| drop(entry.remove("ram_bytes")));
        let renamed = report(|entry| drop(entry.insert("method".into(), json!("other"))));
        for (old, new) in [(&report(|_| ()), &without_figure), (&without_figure, &report(|_| ()))] {
            let worse = compare(old, new).expect("two reports").worse;
            assert!(worse.len() == 1 && worse[0].contains("ram_bytes"), "{worse:?}");
        }
        // One method gone, another one come.
        let worse = compare(&report(|_| ()), &renamed).expect("two reports").worse;
        assert!(worse.len() == 2 && worse[0].contains("newton bend"), "{worse:?}");
    }

    #[test]
    fn other_json_is_no_report() {
        for text in ["", "{}", "[]", r#"{"methods": [], "references": 1}"#, r#"{"methods": [1], "references": []}"#] {
            assert!(compare(text, &report(|_| ())).is_err() && compare(&report(|_| ()), text).is_err(), "{text}");
        }
    }
}
