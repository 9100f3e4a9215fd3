//! The ways to compute the model in both directions, side by side: error against the f64 reference of
//! [`crate::mechanics`], time on this host, state.
//!
//! Times are ratios to `f64-newton` in the same run, because nanoseconds of one machine say nothing on another; they
//! say little about a Cortex-M4, for which `cargo xtask pareto` counts instructions.

pub mod hard_cases;
mod plot;
mod samples;
mod truth;

use crate::methods::{self, Direction, Entry, Prepared};
use crate::report::Folder;
use anyhow::Result;
use model_core::calibration;
use model_core::methods::Representation;
use model_core::units::Coefficients;
use serde::ser::{Serialize, SerializeMap, Serializer};
use truth::Truth;

pub use hard_cases::hard_cases_markdown;

/// The method to whose time all times are ratios.
const TIME_REFERENCE: &str = "f64-newton";
/// What the times are.
const HOST_TIME: &str = if cfg!(debug_assertions) {
    "one run on one host: time over that of f64-newton in the same round, median of the rounds; built with overflow \
     checks, which the fixed-point methods pay for: cargo run --release times them without"
} else {
    "one run on one host: time over that of f64-newton in the same round, median of the rounds"
};
/// Rounds of timing; each times every method once.
const ROUNDS: usize = 31;
/// Inputs a round.
const TIMED_INPUTS: usize = 2000;

/// Calibrations other than the default one: the bare chamber, corners of the admitted range, a point beside one.
const OTHER_CALIBRATIONS_KPA: [[f64; 3]; 7] = [
    [35.3, 7.24, 0.831],
    [0.0, 5.0, 0.0],
    [60.0, 40.0, 2.0],
    [0.0, 40.0, 0.0],
    [0.0, 5.0, 2.0],
    [60.0, 5.0, 0.0],
    [0.01, 5.0, 0.0],
];

/// Worst and root-mean-square error, in the result's unit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    /// Over 0..1000 kPa and 0..170 degrees.
    pub max: f64,
    /// Over the same samples, each with the same weight.
    pub rms: f64,
    /// Over 0..150 kPa.
    pub max_working: f64,
    /// Over the same samples.
    pub rms_working: f64,
}

impl Errors {
    fn worst(self, other: Self) -> Self {
        Self {
            max: self.max.max(other.max),
            rms: self.rms.max(other.rms),
            max_working: self.max_working.max(other.max_working),
            rms_working: self.rms_working.max(other.rms_working),
        }
    }
}

/// One method in one direction.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub method: &'static str,
    /// One line about it.
    pub summary: &'static str,
    /// What it takes and gives.
    pub representation: Representation,
    /// Which way.
    pub direction: Direction,
    /// With the default calibration.
    pub errors: Errors,
    /// The worst of all calibrations.
    pub worst_errors: Errors,
    /// Its time over `f64-newton`'s, median of rounds; of this run on this host.
    pub host_time_ratio: f64,
    /// RAM for both directions together.
    pub state_bytes: usize,
}

/// The key with its unit: `max_error_working_deg`.
impl Serialize for Row {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let unit = self.direction.unit();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("method", self.method)?;
        map.serialize_entry("summary", self.summary)?;
        map.serialize_entry("direction", self.direction.name())?;
        map.serialize_entry("representation", &format!("{:?}", self.representation).to_lowercase())?;
        for (prefix, errors) in [("", &self.errors), ("worst_calibration_", &self.worst_errors)] {
            for (name, value) in [
                ("max_error", errors.max),
                ("rms_error", errors.rms),
                ("max_error_working", errors.max_working),
                ("rms_error_working", errors.rms_working),
            ] {
                map.serialize_entry(&format!("{prefix}{name}_{unit}"), &value)?;
            }
        }
        map.serialize_entry("host_time_ratio", &self.host_time_ratio)?;
        map.serialize_entry("state_bytes", &self.state_bytes)?;
        map.end()
    }
}

/// What [`measure`] found.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Report {
    /// k, c1, c2 in kPa; the first is the default one.
    pub calibrations_kpa: Vec<[f64; 3]>,
    /// Samples of each direction, for one calibration.
    pub samples: [usize; 2],
    /// What the times are.
    pub host_time: &'static str,
    /// Both directions of all methods.
    pub rows: Vec<Row>,
}

impl Report {
    /// The rows of one direction.
    pub fn of(&self, direction: Direction) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.direction == direction)
    }
}

/// The default calibration and the others.
fn calibrations() -> Vec<Coefficients> {
    let others = OTHER_CALIBRATIONS_KPA.iter().filter_map(|&[k, c1, c2]| Coefficients::from_f64_kpa(k, c1, c2).ok());
    core::iter::once(calibration::DEFAULT).chain(others).collect()
}

fn errors(method: &dyn Prepared, direction: Direction, truth: &Truth) -> Errors {
    let mut errors = Errors::default();
    let (mut squares, mut squares_working, mut count, mut count_working) = (0.0, 0.0, 0.0, 0.0);
    for sample in truth.samples(direction) {
        let error = (method.evaluate(direction, sample.input) - sample.exact).abs();
        errors.max = errors.max.max(error);
        squares += error * error;
        count += 1.0;
        if sample.working {
            errors.max_working = errors.max_working.max(error);
            squares_working += error * error;
            count_working += 1.0;
        }
    }
    errors.rms = f64::sqrt(squares / f64::max(count, 1.0));
    errors.rms_working = f64::sqrt(squares_working / f64::max(count_working, 1.0));
    errors
}

/// Each method's time over the reference's in the same round, median of the rounds, so that a disturbance of the
/// machine falls on few of them.
fn time_ratios(entries: &[Entry], direction: Direction) -> Vec<f64> {
    let inputs = samples::timed(direction, TIMED_INPUTS);
    let methods: Vec<_> = entries.iter().map(|entry| (entry.prepare)(&calibration::DEFAULT)).collect();
    let reference = entries.iter().position(|entry| entry.name == TIME_REFERENCE).unwrap_or(0);
    let mut ratios = vec![Vec::with_capacity(ROUNDS); entries.len()];
    // The first round warms up and does not count.
    for round in 0..=ROUNDS {
        let times: Vec<f64> =
            methods.iter().map(|method| method.time(direction, &inputs).as_secs_f64().max(1e-9)).collect();
        if round > 0 {
            for (ratios, time) in ratios.iter_mut().zip(&times) {
                ratios.push(time / times[reference]);
            }
        }
    }
    let median = |mut ratios: Vec<f64>| {
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    };
    ratios.into_iter().map(median).collect()
}

/// Runs every method in both directions over the samples of all calibrations, and times it.
#[must_use]
pub fn measure() -> Report {
    let entries = methods::all();
    let calibrations = calibrations();
    let bar = crate::progress::bar(calibrations.len() + Direction::ALL.len(), "steps");
    let mut found = vec![[(Errors::default(), Errors::default()); 2]; entries.len()];
    let mut samples = [0; 2];
    for (index, coefficients) in calibrations.iter().enumerate() {
        let truths = [Representation::Fixed, Representation::F32].map(|rounding| Truth::new(coefficients, rounding));
        samples = Direction::ALL.map(|direction| truths[0].samples(direction).len());
        for (entry, found) in entries.iter().zip(&mut found) {
            let method = (entry.prepare)(coefficients);
            // f64 holds every number of the fixed-point grid.
            let truth = &truths[usize::from(entry.representation == Representation::F32)];
            for (direction, (default, worst)) in Direction::ALL.into_iter().zip(found) {
                let errors = errors(method.as_ref(), direction, truth);
                if index == 0 {
                    *default = errors;
                }
                *worst = worst.worst(errors);
            }
        }
        bar.inc(1);
    }
    let mut rows = Vec::new();
    for (slot, direction) in Direction::ALL.into_iter().enumerate() {
        let ratios = time_ratios(&entries, direction);
        for ((entry, found), host_time_ratio) in entries.iter().zip(&found).zip(ratios) {
            let (errors, worst_errors) = found[slot];
            rows.push(Row {
                method: entry.name,
                summary: entry.summary,
                representation: entry.representation,
                direction,
                errors,
                worst_errors,
                host_time_ratio,
                state_bytes: entry.state_bytes,
            });
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Report {
        calibrations_kpa: calibrations.iter().map(|c| c.to_f64_kpa()).collect(),
        samples,
        host_time: HOST_TIME,
        rows,
    }
}

/// The report for people.
#[must_use]
pub fn table(report: &Report) -> String {
    let mut out = String::new();
    for direction in Direction::ALL {
        let unit = if direction == Direction::BendFromPressure { "degrees" } else { "kPa" };
        out += &format!(
            "{}, errors in {unit}\n{:<20}{:>10}{:>10}{:>10}{:>10}{:>12}{:>12}{:>11}{:>8}\n",
            direction.name(),
            "method",
            "0..150",
            "rms",
            "0..1000",
            "rms",
            "any finger",
            "any finger",
            "host time",
            "state"
        );
        out += &format!(
            "{:<20}{:>10}{:>10}{:>10}{:>10}{:>12}{:>12}{:>11}{:>8}\n",
            "", "kPa", "", "kPa", "", "0..150", "0..1000", "ratio", "bytes"
        );
        for row in report.of(direction) {
            out += &format!(
                "{:<20}{:>10.1e}{:>10.1e}{:>10.1e}{:>10.1e}{:>12.1e}{:>12.1e}{:>11.2}{:>8}\n",
                row.method,
                row.errors.max_working,
                row.errors.rms_working,
                row.errors.max,
                row.errors.rms,
                row.worst_errors.max_working,
                row.worst_errors.max,
                row.host_time_ratio,
                row.state_bytes
            );
        }
        out.push('\n');
    }
    out += &format!(
        "any finger: the worst of {} calibrations. host time: {}.\n",
        report.calibrations_kpa.len(),
        report.host_time
    );
    out
}

/// The report as CSV.
fn csv(report: &Report) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "method",
        "direction",
        "unit",
        "max_error_working",
        "rms_error_working",
        "max_error",
        "rms_error",
        "worst_calibration_max_error_working",
        "worst_calibration_max_error",
        "host_time_ratio",
        "state_bytes",
    ])?;
    for row in &report.rows {
        let numbers = [
            row.errors.max_working,
            row.errors.rms_working,
            row.errors.max,
            row.errors.rms,
            row.worst_errors.max_working,
            row.worst_errors.max,
        ];
        let mut record = vec![row.method.to_owned(), row.direction.name().to_owned(), row.direction.unit().to_owned()];
        record.extend(numbers.map(|value| format!("{value:.3e}")));
        record.extend([format!("{:.3}", row.host_time_ratio), row.state_bytes.to_string()]);
        writer.write_record(record)?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

/// Measures, writes pictures, table, JSON and hard cases to `folder`, and returns what is to be printed.
///
/// # Errors
/// When a picture cannot be drawn or a file not be written.
pub fn run(json: bool, folder: &Folder) -> Result<String> {
    let report = measure();
    let hard_cases = hard_cases::examine();
    let text = serde_json::to_string_pretty(&serde_json::json!({ "report": report, "hard_cases": hard_cases }))? + "\n";
    let bend = plot::picture(&report, Direction::BendFromPressure)?;
    let pressure = plot::picture(&report, Direction::PressureFromBend)?;
    let markdown = hard_cases_markdown(&hard_cases);
    let files = folder.write(&[
        ("pareto-bend-from-pressure.svg", bend.as_str()),
        ("pareto-pressure-from-bend.svg", &pressure),
        ("pareto-inverse.csv", &csv(&report)?),
        ("pareto-inverse.json", &text),
        ("hard-cases.md", &markdown),
    ])?;
    if json {
        return Ok(text);
    }
    let names: Vec<_> = files.iter().map(|path| path.display().to_string()).collect();
    Ok(format!("{}\n{}", table(&report), names.join("\n")) + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_keys_carry_their_units_and_the_figures_hold_together() {
        let report = measure();
        let value = serde_json::to_value(&report).expect("serialises");
        let rows = value["rows"].as_array().expect("rows");
        assert_eq!(rows.len(), 2 * methods::all().len());
        for row in rows {
            let unit = if row["direction"] == "bend-from-pressure" { "deg" } else { "kpa" };
            let number = |name: &str| row[&format!("{name}_{unit}")].as_f64().expect(name);
            assert!(number("rms_error") <= number("max_error") && number("max_error_working") <= number("max_error"));
            assert!(number("max_error") <= number("worst_calibration_max_error"));
            assert!(row["host_time_ratio"].as_f64().expect("ratio") > 0.0);
        }
        // The core's own inverse is within what its page claims; the reference is not the core's.
        let own = report.of(Direction::BendFromPressure).find(|row| row.method == "fixed-newton").expect("there");
        assert!(own.worst_errors.max < 1.6e-5 && own.errors.max > 3e-6, "{:?}", own.errors);
        let text = table(&report);
        assert!(report.rows.iter().all(|row| text.contains(row.method)));
        let lines = csv(&report).expect("writes");
        assert_eq!(lines.lines().count(), report.rows.len() + 1);
    }
}
