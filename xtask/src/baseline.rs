//! Committed figures, and the comparison of newly measured ones with them: each may move by its margin and no further.

use crate::root;
use anyhow::{Context, Result, bail, ensure};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fs;

/// A committed file of figures, and what it is held to.
pub struct Baseline {
    /// Its path in the workspace.
    pub file: &'static str,
    /// The command that renews it.
    pub renew: &'static str,
    /// Names of the lists that it consists of; none: the whole is one entry.
    pub lists: &'static [&'static str],
    /// What tells an entry from the others.
    pub words: &'static [&'static str],
    /// The margin of a figure by its name; `None` for what is no figure.
    pub margin: fn(&str) -> Option<Margin>,
}

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
pub struct Margin {
    /// Part of the baseline's figure: 0.1 is ten per cent.
    pub part: f64,
    /// In the figure's unit.
    pub amount: f64,
}

impl Baseline {
    /// The committed text.
    ///
    /// # Errors
    /// When there is none.
    pub fn committed(&self) -> Result<String> {
        fs::read_to_string(root().join(self.file))
            .with_context(|| format!("{} is missing: write it with `{}`", self.file, self.renew))
    }

    /// Makes `text` the baseline.
    ///
    /// # Errors
    /// When it is no such report, or the file cannot be written.
    pub fn write(&self, text: &str) -> Result<()> {
        ensure!(!self.entries(text)?.is_empty(), "nothing was measured");
        let path = root().join(self.file);
        fs::create_dir_all(path.parent().context("a file in a folder")?)?;
        fs::write(&path, format!("{}\n", text.trim_end())).with_context(|| format!("cannot write {}", self.file))?;
        eprintln!("{}", self.file);
        Ok(())
    }

    /// Holds what was measured to the committed baseline, and says what can be tightened.
    ///
    /// # Errors
    /// When a figure is worse by more than its margin, or missing on either side.
    pub fn gate(&self, measured: &str) -> Result<()> {
        let Comparison { worse, better, compared } = self.compare(&self.committed()?, measured)?;
        for line in &better {
            println!("better: {line}");
        }
        if !better.is_empty() {
            println!("the baseline can be tightened: `{}`", self.renew);
        }
        let Self { file, renew, .. } = self;
        ensure!(worse.is_empty(), "worse than {file}:\n  {}\nif that is meant: `{renew}`", worse.join("\n  "));
        println!("{compared} figures within their margins of {file}");
        Ok(())
    }

    /// Compares two reports, both JSON.
    ///
    /// # Errors
    /// When one of them is no such report.
    pub fn compare(&self, baseline: &str, measured: &str) -> Result<Comparison> {
        let old = self.entries(baseline).with_context(|| format!("{} cannot be read", self.file))?;
        let new = self.entries(measured).context("what was measured cannot be read")?;
        let mut comparison = Comparison::default();
        for (name, figures) in &old {
            match new.get(name) {
                Some(measured) => self.compare_figures(name, figures, measured, &mut comparison),
                None => comparison.worse.push(format!("{name}: in the baseline, but not measured any more")),
            }
        }
        for name in new.keys().filter(|name| !old.contains_key(*name)) {
            comparison.worse.push(format!("{name}: measured, but not in the baseline"));
        }
        Ok(comparison)
    }

    /// Each entry's name with its figures.
    fn entries(&self, text: &str) -> Result<BTreeMap<String, Map<String, Value>>> {
        let report: Value = serde_json::from_str(text)?;
        let mut all = Vec::new();
        for list in self.lists {
            all.extend(report[list].as_array().cloned().with_context(|| format!("no list '{list}'"))?);
        }
        if self.lists.is_empty() {
            all.push(report);
        }
        let mut entries = BTreeMap::new();
        for entry in all {
            let Value::Object(figures) = entry else { bail!("an entry is no object") };
            let words = self.words.iter().filter_map(|word| figures.get(*word)?.as_str());
            let name = words.collect::<Vec<_>>().join(" ");
            ensure!(!entries.contains_key(&name), "'{name}' is there twice");
            entries.insert(name, figures);
        }
        Ok(entries)
    }

    fn compare_figures(
        &self,
        name: &str,
        old: &Map<String, Value>,
        new: &Map<String, Value>,
        comparison: &mut Comparison,
    ) {
        // The one entry of a flat report has no name.
        let of = |figure: &str| if name.is_empty() { figure.to_owned() } else { format!("{name}: {figure}") };
        for (figure, value) in old {
            let Some(Margin { part, amount }) = (self.margin)(figure) else { continue };
            // JSON has no infinity; serde_json writes null.
            let number = |value: &Value| if value.is_null() { Some(f64::INFINITY) } else { value.as_f64() };
            let (Some(was), Some(is)) = (number(value), new.get(figure).and_then(number)) else {
                comparison.worse.push(format!("{} is in the baseline, but not measured any more", of(figure)));
                continue;
            };
            comparison.compared += 1;
            let allowed = was * (1.0 + part) + amount;
            let line = || format!("{} is {is}, the baseline {was}", of(figure));
            // Four digits are written: the last one may round either way.
            let rounding = 1.0 + 1e-9;
            if is > allowed * rounding {
                comparison.worse.push(format!("{}, allowed up to {}", line(), readable(allowed)));
            } else if is * (1.0 + part) * rounding + amount < was {
                comparison.better.push(line());
            }
        }
        for figure in new.keys().filter(|figure| (self.margin)(figure).is_some() && !old.contains_key(*figure)) {
            comparison.worse.push(format!("{} is measured, but not in the baseline", of(figure)));
        }
    }
}

/// Four digits, so that a file changes only when a figure does; whole numbers and words as they are.
pub fn rounded(value: &Value) -> Value {
    match value.as_f64() {
        Some(number) if value.is_f64() => format!("{number:.3e}").parse::<f64>().map_or(Value::Null, Value::from),
        _ => value.clone(),
    }
}

/// Whole numbers as they are, small ones with four digits.
fn readable(value: f64) -> String {
    if value < 1.0 { format!("{value:.3e}") } else { format!("{value:.1}") }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use serde_json::json;

    /// One newly measured figure of a report, with a value that is just within its margin and one just beyond.
    pub type Edge = (&'static str, Value, Value);

    /// Changes a figure of the report's first entry that has it.
    fn changed(report: &Value, lists: &[&str], figure: &str, value: Option<&Value>) -> String {
        let mut report = report.clone();
        let mut entries: Vec<&mut Value> = if lists.is_empty() {
            vec![&mut report]
        } else {
            let all = report.as_object_mut().expect("an object").iter_mut();
            all.filter(|(name, _)| lists.contains(&name.as_str()))
                .flat_map(|(_, list)| list.as_array_mut().expect("a list"))
                .collect()
        };
        let entry = entries.iter_mut().filter_map(|entry| entry.as_object_mut());
        let mut entry = entry.filter(|entry| entry.contains_key(figure));
        let entry = entry.next().expect("an entry with the figure");
        match value {
            Some(value) => drop(entry.insert(figure.to_owned(), value.clone())),
            None => drop(entry.remove(figure)),
        }
        report.to_string()
    }

    /// What every baseline must do: pass what is equal, name what is just beyond its margin or missing, and only tell
    /// what is better. `edges` has every figure that counts.
    pub fn assert_holds(baseline: &Baseline, report: &Value, edges: &[Edge]) {
        let text = report.to_string();
        let compare = |old: &str, new: &str| baseline.compare(old, new).expect("two reports");
        let same = compare(&text, &text);
        assert_eq!(same, Comparison { compared: same.compared, ..Comparison::default() });
        assert!(same.compared >= edges.len(), "{} figures compared", same.compared);
        for (figure, within, beyond) in edges {
            let with = |value: Option<&Value>| changed(report, baseline.lists, figure, value);
            assert_eq!(compare(&text, &with(Some(within))).worse, Vec::<String>::new(), "{figure}");
            for (name, new) in
                [("is", with(Some(beyond))), ("is", with(Some(&Value::Null))), ("not measured", with(None))]
            {
                let worse = compare(&text, &new).worse;
                assert!(
                    worse.len() == 1 && worse[0].contains(figure) && worse[0].contains(name),
                    "{figure}: {worse:?}"
                );
            }
            let worse = compare(&with(None), &text).worse;
            assert!(worse.len() == 1 && worse[0].contains("not in the baseline"), "{figure}: {worse:?}");
            let told = compare(&with(Some(beyond)), &text);
            assert_eq!(told.worse, Vec::<String>::new(), "{figure}");
        }
    }

    const BASELINE: Baseline = Baseline {
        file: "docs/figures/none.json",
        renew: "cargo xtask none",
        lists: &["methods", "references"],
        words: &["method", "direction", "function"],
        margin: |name| {
            let margin = match name {
                "instructions" => Margin { part: 0.1, amount: 4.0 },
                "bytes" => Margin { part: 0.0, amount: 0.0 },
                "error_deg" => Margin { part: 0.01, amount: 1e-9 },
                _ => return None,
            };
            Some(margin)
        },
    };

    fn report() -> Value {
        json!({
            "methods": [
                { "method": "newton", "direction": "bend", "instructions": 1000, "bytes": 12, "calls": 7 },
                { "method": "newton", "direction": "pressure", "instructions": 10, "bytes": 12, "calls": 7 },
            ],
            "references": [{ "function": "cossin", "error_deg": 1e-5 }],
        })
    }

    #[test]
    fn figures_hold_to_their_margins() {
        let edges = [
            ("instructions", json!(1104), json!(1105)),
            ("bytes", json!(12), json!(13)),
            ("error_deg", json!(1.0100e-5), json!(1.0102e-5)),
        ];
        assert_holds(&BASELINE, &report(), &edges);
    }

    #[test]
    fn a_line_names_entry_figure_and_limit() {
        let new = changed(&report(), BASELINE.lists, "instructions", Some(&json!(1105)));
        let worse = BASELINE.compare(&report().to_string(), &new).expect("two reports").worse;
        assert_eq!(worse, ["newton bend: instructions is 1105, the baseline 1000, allowed up to 1104.0"]);
    }

    #[test]
    fn what_is_better_by_more_than_the_margin_is_told() {
        let told = |value: u32| {
            let new = changed(&report(), BASELINE.lists, "instructions", Some(&json!(value)));
            let Comparison { worse, better, .. } = BASELINE.compare(&report().to_string(), &new).expect("two reports");
            (worse.len(), better.len())
        };
        assert_eq!(told(906), (0, 0));
        assert_eq!(told(905), (0, 1));
    }

    #[test]
    fn an_entry_that_is_missing_on_either_side_fails() {
        let mut renamed = report();
        renamed["methods"][0]["method"] = json!("other");
        // One gone, another one come.
        let worse = BASELINE.compare(&report().to_string(), &renamed.to_string()).expect("two reports").worse;
        let lines = [
            "newton bend: in the baseline, but not measured any more",
            "other bend: measured, but not in the baseline",
        ];
        assert_eq!(worse, lines);
    }

    #[test]
    fn other_json_is_no_report() {
        let mut doubled = report();
        doubled["methods"][1]["direction"] = json!("bend");
        let texts = ["", "{}", "[]", r#"{"methods": [], "references": 1}"#, r#"{"methods": [1], "references": []}"#];
        for text in texts.into_iter().chain([doubled.to_string().as_str()]) {
            let report = report().to_string();
            assert!(BASELINE.compare(text, &report).is_err() && BASELINE.compare(&report, text).is_err(), "{text}");
        }
    }
}
