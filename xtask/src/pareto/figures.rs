//! What pictures and tables need of the figures: which methods nothing else beats, and how they read.

use anyhow::{Context, Result, ensure};
use serde_json::Value;

/// The methods that the core itself computes with.
const CHOSEN: [(Direction, &str); 4] = [
    (Direction::Bend, "segment-newton"),
    (Direction::Bend, "floating-quartic"),
    (Direction::Pressure, "segment-newton"),
    (Direction::Pressure, "floating-quartic"),
];

/// Which of the two functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// α = f(P).
    Bend,
    /// P = f⁻¹(α).
    Pressure,
}

impl Direction {
    /// Both.
    pub const BOTH: [Self; 2] = [Self::Bend, Self::Pressure];

    /// As in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bend => "bend",
            Self::Pressure => "pressure",
        }
    }

    /// The result's unit as in JSON keys.
    const fn key(self) -> &'static str {
        match self {
            Self::Bend => "deg",
            Self::Pressure => "kpa",
        }
    }

    /// The result's unit for people.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Bend => "degrees",
            Self::Pressure => "kPa",
        }
    }
}

/// A method in one direction.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Its name.
    pub method: String,
    /// Which function.
    pub direction: Direction,
    /// Worst error in 0..150 kPa over all calibrations: the picture's y.
    pub max_error_working: f64,
    /// The same over the whole domain.
    pub max_error_whole: f64,
    /// Root mean square in 0..150 kPa with the default calibration.
    pub rms_error_working: f64,
    /// Time on the host that measured, over `f64-newton`'s.
    pub host_time_ratio: f64,
    /// Mean over 0..150 kPa: the picture's x.
    pub instructions_mean: f64,
    /// Worst in 0..150 kPa.
    pub instructions_worst_working: u64,
    /// Worst over everything.
    pub instructions_worst: u64,
    /// Worst.
    pub prepare_instructions: u64,
    /// Code.
    pub flash_code_bytes: u64,
    /// Tables.
    pub flash_table_bytes: u64,
    /// State.
    pub ram_bytes: u64,
}

impl Entry {
    /// Whether the core itself uses it.
    pub fn chosen(&self) -> bool {
        CHOSEN.iter().any(|&(direction, method)| direction == self.direction && method == self.method)
    }

    /// At least as good in both and better in one.
    fn beats(&self, other: &Self) -> bool {
        let [mine, theirs] = [self, other].map(|entry| (entry.max_error_working, entry.instructions_mean));
        mine.0 <= theirs.0 && mine.1 <= theirs.1 && mine != theirs
    }
}

/// All methods.
#[derive(Clone, Debug)]
pub struct Report {
    entries: Vec<Entry>,
    functions: Vec<Value>,
}

impl Report {
    /// Reads what `pareto --json` prints.
    ///
    /// # Errors
    /// When a figure is missing, or a chosen method is.
    pub fn parse(text: &str) -> Result<Self> {
        let report: Value = serde_json::from_str(text)?;
        let methods = report["methods"].as_array().context("no list 'methods'")?;
        let entries = methods.iter().map(entry).collect::<Result<Vec<_>>>()?;
        for (direction, method) in CHOSEN {
            let there = entries.iter().any(|entry| entry.direction == direction && entry.method == method);
            ensure!(there, "{method}, which the core uses for {}, was not measured", direction.name());
        }
        let functions = report["references"].as_array().context("no list 'references'")?.clone();
        Ok(Self { entries, functions })
    }

    /// What other functions cost, as a table.
    ///
    /// # Errors
    /// When a figure is missing.
    pub fn functions_table(&self) -> Result<String> {
        let mut table =
            "| Function | Instructions, mean / worst | Flash: code / tables, bytes |\n|---|---|---|\n".to_owned();
        for function in &self.functions {
            let number = |name: &str| {
                let number =
                    function[name].as_f64().with_context(|| format!("no {name} of {}", function["function"]))?;
                Ok::<_, anyhow::Error>(grouped(number.round() as u64))
            };
            let name = function["function"].as_str().context("a function without its name")?;
            let (name, inputs) =
                name.split_once(", ").map_or((name, String::new()), |(name, inputs)| (name, format!(", {inputs}")));
            table += &format!(
                "| `{name}`{inputs} | {} / {} | {} / {} |\n",
                number("instructions_cortex_m4_mean")?,
                number("instructions_cortex_m4_worst")?,
                number("flash_code_bytes")?,
                number("flash_table_bytes")?
            );
        }
        Ok(table)
    }

    /// A direction's methods, from the fewest instructions on.
    pub fn of(&self, direction: Direction) -> Vec<&Entry> {
        let mut entries: Vec<_> = self.entries.iter().filter(|entry| entry.direction == direction).collect();
        entries.sort_by(|a, b| {
            let key = |entry: &Entry| (entry.instructions_mean, entry.max_error_working);
            key(a).partial_cmp(&key(b)).unwrap_or(core::cmp::Ordering::Equal)
        });
        entries
    }

    /// Those of them that no other beats in both error and instructions.
    pub fn front(&self, direction: Direction) -> Vec<&Entry> {
        let all = self.of(direction);
        all.iter().filter(|entry| !all.iter().any(|other| other.beats(entry))).copied().collect()
    }

    /// Markdown with everything.
    pub fn table(&self, direction: Direction) -> String {
        let unit = direction.unit();
        let mut text = format!(
            "| Method | Worst error, {unit}, 0-150 kPa | Worst error, whole domain | RMS error, 0-150 kPa | \
             Instructions, mean | worst | worst anywhere | Prepare | Code, bytes | Tables, bytes | RAM, bytes | Host time |\n\
             |---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n"
        );
        let front = self.front(direction);
        for entry in self.of(direction) {
            let on_front = front.iter().any(|other| other.method == entry.method);
            text += &format!(
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.2} |\n",
                styled(entry, on_front),
                scientific(entry.max_error_working),
                scientific(entry.max_error_whole),
                scientific(entry.rms_error_working),
                grouped(entry.instructions_mean.round() as u64),
                grouped(entry.instructions_worst_working),
                grouped(entry.instructions_worst),
                grouped(entry.prepare_instructions),
                grouped(entry.flash_code_bytes),
                grouped(entry.flash_table_bytes),
                grouped(entry.ram_bytes),
                entry.host_time_ratio,
            );
        }
        text
    }

    /// Markdown with what nothing beats, and what was chosen.
    pub fn front_table(&self, direction: Direction) -> String {
        let unit = direction.unit();
        let mut text = format!(
            "| {} | Worst error, {unit}, 0-150 kPa | Instructions, mean / worst | Flash, bytes |\n|---|---|---|---|\n",
            match direction {
                Direction::Bend => "Bend from pressure",
                Direction::Pressure => "Pressure from bend",
            }
        );
        let front = self.front(direction);
        for entry in self.of(direction) {
            let on_front = front.iter().any(|other| other.method == entry.method);
            if on_front || entry.chosen() {
                text += &format!(
                    "| {} | {} | {} / {} | {} |\n",
                    styled(entry, on_front),
                    scientific(entry.max_error_working),
                    grouped(entry.instructions_mean.round() as u64),
                    grouped(entry.instructions_worst_working),
                    grouped(entry.flash_code_bytes + entry.flash_table_bytes),
                );
            }
        }
        text
    }
}

fn entry(value: &Value) -> Result<Entry> {
    let method = value["method"].as_str().context("an entry without 'method'")?.to_owned();
    let direction =
        value["direction"].as_str().and_then(|name| Direction::BOTH.into_iter().find(|it| it.name() == name));
    let direction = direction.with_context(|| format!("{method}: no 'direction'"))?;
    let unit = direction.key();
    let number = |name: &str| -> Result<f64> {
        match &value[name] {
            // JSON has no infinity.
            Value::Null if value.get(name).is_some() => Ok(f64::INFINITY),
            other => other.as_f64().with_context(|| format!("{method} {}: no '{name}'", direction.name())),
        }
    };
    let whole = |name: &str| number(name).map(|value| value as u64);
    Ok(Entry {
        direction,
        max_error_working: number(&format!("max_error_working_any_calibration_{unit}"))?,
        max_error_whole: number(&format!("max_error_any_calibration_{unit}"))?,
        rms_error_working: number(&format!("rms_error_working_{unit}"))?,
        host_time_ratio: number("host_time_ratio")?,
        instructions_mean: number("instructions_cortex_m4_mean")?,
        instructions_worst_working: whole("instructions_cortex_m4_worst_working")?,
        instructions_worst: whole("instructions_cortex_m4_worst")?,
        prepare_instructions: whole("prepare_instructions_cortex_m4")?,
        flash_code_bytes: whole("flash_code_bytes")?,
        flash_table_bytes: whole("flash_table_bytes")?,
        ram_bytes: whole("ram_bytes")?,
        method,
    })
}

/// The core's own in bold; those that others beat in brackets.
fn styled(entry: &Entry, on_front: bool) -> String {
    match (entry.chosen(), on_front) {
        (true, _) => format!("**`{}`**", entry.method),
        (false, true) => format!("`{}`", entry.method),
        (false, false) => format!("(`{}`)", entry.method),
    }
}

fn scientific(value: f64) -> String {
    if value.is_infinite() { "none".to_owned() } else { format!("{value:.1e}") }
}

/// With a comma every three digits.
pub fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use serde_json::json;

    /// A report with these methods: name, worst error, mean instructions; in both directions.
    pub fn report(methods: &[(&str, f64, f64)]) -> Report {
        let mut entries = Vec::new();
        for (direction, unit) in [("bend", "deg"), ("pressure", "kpa")] {
            for &(method, error, instructions) in methods {
                let mut entry = json!({
                    "method": method, "direction": direction, "instructions_cortex_m4_mean": instructions,
                    "instructions_cortex_m4_worst_working": 77,
                    "instructions_cortex_m4_worst": 1_234_567, "prepare_instructions_cortex_m4": 999,
                    "flash_code_bytes": 1000, "flash_table_bytes": 24, "ram_bytes": 12, "host_time_ratio": 0.5,
                });
                for name in ["max_error_working_any_calibration", "max_error_any_calibration", "rms_error_working"] {
                    entry[format!("{name}_{unit}")] = json!(error);
                }
                entries.push(entry);
            }
        }
        Report::parse(&json!({ "methods": entries, "references": [] }).to_string()).expect("complete")
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let methods = [
            ("dear", 1e-6, 5000.0),
            ("segment-newton", 1e-5, 1000.0),
            ("beaten", 2e-5, 1000.0),
            ("floating-quartic", 1e-2, 50.0),
            ("no number", f64::INFINITY, 60.0),
        ];
        let report = report(&methods);
        let names: Vec<_> = report.front(Direction::Bend).iter().map(|entry| entry.method.clone()).collect();
        assert_eq!(names, ["floating-quartic", "segment-newton", "dear"]);
    }

    #[test]
    fn tables_have_a_line_each_and_say_who_is_who() {
        let report =
            report(&[("segment-newton", 1e-5, 1000.0), ("beaten", 2e-5, 1000.0), ("floating-quartic", 1e-2, 50.0)]);
        let table = report.table(Direction::Pressure);
        assert_eq!(table.lines().count(), 2 + 3);
        assert!(table.contains("**`segment-newton`** | 1.0e-5 |") && table.contains("(`beaten`)"), "{table}");
        assert!(table.contains("| 1,234,567 | 999 | 1,000 | 24 | 12 | 0.50 |"), "{table}");
        let front = report.front_table(Direction::Bend);
        assert!(front.lines().count() == 2 + 2 && !front.contains("beaten") && front.contains("1,024"), "{front}");
    }

    #[test]
    fn a_chosen_method_must_be_there() {
        let error = Report::parse(r#"{"methods": []}"#).expect_err("nothing measured").to_string();
        assert!(error.contains("segment-newton"), "{error}");
    }
}
