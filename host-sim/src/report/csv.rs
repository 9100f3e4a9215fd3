//! The run as a table: one row a millisecond, one column a quantity, the unit in the column's name.
//!
//! The first column is the version of the table ([`SCHEMA`]) in every row, so that rows stay readable when files are cut or
//! joined. Quantities carry four decimals (0.1 Pa, 0.1 millidegree); a failed sensor's field is empty.

use crate::metrics::mode_name;
use crate::trace::Trace;
use anyhow::{Context, Result, ensure};
use core::fmt::Write as _;
use model_core::actuation::Passage;

/// Version of the table: raised whenever a column changes its name, its meaning or its place.
pub const SCHEMA: u32 = 1;

/// The columns, in order. Pressures are gauge, bends are in degrees; `1` is true, running or open.
pub const COLUMNS: [&str; 27] = [
    "schema",
    "time_ms",
    "mode",
    "repeat",
    "step",
    "holding",
    "pump_on",
    "dump_open",
    "valve_proximal_open",
    "valve_middle_open",
    "valve_distal_open",
    "setpoint_proximal_kpa",
    "setpoint_middle_kpa",
    "setpoint_distal_kpa",
    "estimate_proximal_kpa",
    "estimate_middle_kpa",
    "estimate_distal_kpa",
    "chamber_proximal_kpa",
    "chamber_middle_kpa",
    "chamber_distal_kpa",
    "manifold_kpa",
    "sensor_kpa",
    "bend_proximal_deg",
    "bend_middle_deg",
    "bend_distal_deg",
    "bend_finger_deg",
    "bend_sensor_deg",
];

/// Columns before the first quantity.
const FLAGS: usize = 11;

/// One row as it is read back.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Time since the run's start, ms.
    pub time_ms: u32,
    /// The mode's name.
    pub mode: String,
    /// `repeat` to `valve_distal_open` as they stand: two counts and six flags.
    pub states: [u16; 8],
    /// `setpoint_proximal_kpa` to `bend_sensor_deg` in order; not a number where the field is empty.
    pub quantities: [f64; 16],
}

fn flag(value: bool) -> u8 {
    u8::from(value)
}

fn open(passage: Passage) -> u8 {
    flag(passage == Passage::Open)
}

/// The whole table as text.
#[must_use]
pub fn table(trace: &Trace) -> String {
    let mut out = String::with_capacity(200 * (trace.samples.len() + 2));
    out.push_str(&COLUMNS.join(","));
    out.push('\n');
    for sample in &trace.samples {
        let a = &sample.actuation;
        let mode = mode_name(sample.mode);
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "{SCHEMA},{},{mode},{},{},{},{},{}",
            sample.time_ms,
            sample.repeat,
            sample.step,
            flag(sample.holding),
            flag(a.pump),
            open(a.dump)
        );
        for valve in a.segments {
            let _ = write!(out, ",{}", open(valve));
        }
        let finger: f64 = sample.bends_deg.iter().sum();
        let groups = [sample.setpoints_kpa, sample.estimates_kpa, sample.chambers_kpa];
        let quantities = groups
            .into_iter()
            .flatten()
            .chain([sample.manifold_kpa, sample.sensor_kpa])
            .chain(sample.bends_deg)
            .chain([finger, sample.bend_sensor_deg]);
        for value in quantities {
            // A tiny negative value must not print as -0.0000: it would be another text for the same number.
            let value = if value.abs() < 0.000_05 { 0.0 } else { value };
            let _ = if value.is_finite() { write!(out, ",{value:.4}") } else { write!(out, ",") };
        }
        out.push('\n');
    }
    out
}

/// Reads a table back.
///
/// # Errors
/// Says what is wrong when the header or the version is another one, or a field is no number.
pub fn parse(text: &str) -> Result<Vec<Row>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    ensure!(reader.headers()?.iter().eq(COLUMNS), "the columns are not those of schema {SCHEMA}");
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record?;
        let line = rows.len() + 2;
        let field = |column: usize| record.get(column).unwrap_or_default();
        ensure!(field(0) == SCHEMA.to_string(), "line {line}: schema {} is not {SCHEMA}", field(0));
        let mut row = Row {
            time_ms: field(1).parse().with_context(|| format!("line {line}: time_ms"))?,
            mode: field(2).to_owned(),
            states: [0; 8],
            quantities: [f64::NAN; 16],
        };
        for (offset, state) in row.states.iter_mut().enumerate() {
            *state = field(3 + offset).parse().with_context(|| format!("line {line}: {}", COLUMNS[3 + offset]))?;
        }
        for (offset, quantity) in row.quantities.iter_mut().enumerate() {
            let text = field(FLAGS + offset);
            if !text.is_empty() {
                *quantity = text.parse().with_context(|| format!("line {line}: {}", COLUMNS[FLAGS + offset]))?;
            }
        }
        rows.push(row);
    }
    Ok(rows)
}
