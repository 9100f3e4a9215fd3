//! Measurements of pressure and bend, and the table that a lab writes them into.
//!
//! ```csv
//! # finger 7, 2026-03-02, digital protractor; anything after a # at a line's start is a comment
//! segment,repeat,pressure_kpa,bend_deg
//! proximal,1,30.0,46.1
//! proximal,1,60.0,70.9
//! ```
//!
//! | Column | | |
//! |---|---|---|
//! | `pressure_kpa` | needed | gauge pressure in the chamber, 0..=165 kPa |
//! | `bend_deg` | needed | bend of the segment, below 170 degrees; above 0 when the chamber is filled |
//! | `segment` | may be left out | `proximal`, `middle`, `distal`; `all` or empty: a chamber that stands for all three; `finger`: all three at this pressure, and their bends' sum, of which a third is taken |
//! | `repeat` | may be left out | number of the run, from 1: tells a drift from scatter |
//!
//! Their order is free. Points below [`EMPTY_KPA`] check the bend's zero and are not fitted: every curve of the model
//! goes through zero, and steeply, so that they would say more of the gauge than of the finger.

use crate::report::csv as recording_table;
use anyhow::{Context, Result, anyhow, bail, ensure};
use core::fmt;
use core::str::FromStr;
use csv::{ReaderBuilder, StringRecord, Trim};
use model_core::actuation::Segment;
use model_core::paper::CHAMBERS;
use std::fs;
use std::path::Path;

use super::recording;

/// A chamber below this is empty, kPa: twice the pressure sensor's resolution.
pub const EMPTY_KPA: f64 = 2.0;
/// The highest pressure that a chamber may ever have, kPa (`model_core::supervisor`): more is another unit.
pub const MAX_KPA: f64 = 165.0;
/// The model's domain ends below this, degrees of one segment.
pub const MAX_DEG: f64 = 170.0;
/// The lowest bend that an empty segment may be measured at, degrees: the exoskeleton stops it near zero.
pub const MIN_DEG: f64 = -10.0;

/// What coefficients are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scope {
    /// All three segments.
    All,
    /// The proximal, middle or distal segment (0, 1, 2).
    One(u8),
}

impl Scope {
    /// Of one segment.
    #[must_use]
    pub const fn of(segment: Segment) -> Self {
        Self::One(segment as u8)
    }

    /// The name in tables and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::One(index) => Segment::ALL.get(usize::from(index)).map_or("", |segment| segment.name()),
        }
    }
}

/// Where a measurement stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Line of a table, from 1.
    Line(u64),
    /// End of a hold in a recording, s.
    Time(f64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Time(seconds) => write!(f, "{seconds:.1} s"),
        }
    }
}

/// One pressure and the bend that was measured at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Where it stands.
    pub place: Place,
    /// What it is of.
    pub scope: Scope,
    /// Number of the run.
    pub repeat: Option<u32>,
    /// Gauge pressure, kPa.
    pub pressure_kpa: f64,
    /// Bend of one segment, degrees.
    pub bend_deg: f64,
}

/// All that a file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurements {
    /// In the file's order.
    pub all: Vec<Measurement>,
    /// What was not used, and why, one sentence each.
    pub left_out: Vec<String>,
}

/// Reads a table of measurements, or a recording (`host-sim run`, `host-sim monitor`) with holds in it.
///
/// # Errors
/// Names file, line, value, limit and what to do.
pub fn read(path: &Path) -> Result<Measurements> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    parse(&bytes).with_context(|| path.display().to_string())
}

/// Reads a file's bytes.
///
/// # Errors
/// Names line, value, limit and what to do.
pub fn parse(bytes: &[u8]) -> Result<Measurements> {
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let first = bytes.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let is_recording = first.split(|&byte| byte == b',').any(|name| name.trim_ascii() == b"schema");
    let measurements =
        if is_recording { recording::measurements(&recording_table::read(bytes)?)? } else { table(bytes)? };
    let whole = measurements.all.iter().find(|m| m.scope == Scope::All);
    let single = measurements.all.iter().find(|m| m.scope != Scope::All);
    if let (Some(whole), Some(single)) = (whole, single) {
        bail!(
            "{} is of all segments, {} of the {} one alone: fit them from two files",
            whole.place,
            single.place,
            single.scope.name()
        );
    }
    Ok(measurements)
}

/// The table's columns, by where they stand.
struct Columns {
    pressure: usize,
    bend: usize,
    segment: Option<usize>,
    repeat: Option<usize>,
}

impl Columns {
    const NAMES: [&str; 4] = ["pressure_kpa", "bend_deg", "segment", "repeat"];

    fn of(header: &StringRecord) -> Result<Self> {
        let place = |column: &str| header.iter().position(|name| name == column);
        let needed = |column: &str| {
            place(column).ok_or_else(|| {
                let found: Vec<&str> = header.iter().collect();
                anyhow!(
                    "there is no column {column}: the first line must name {}, with commas between, and may name {}; \
                     it is {:?}",
                    Self::NAMES[..2].join(" and "),
                    Self::NAMES[2..].join(" and "),
                    found.join(",").chars().take(80).collect::<String>()
                )
            })
        };
        Ok(Self {
            pressure: needed("pressure_kpa")?,
            bend: needed("bend_deg")?,
            segment: place("segment"),
            repeat: place("repeat"),
        })
    }
}

fn table(bytes: &[u8]) -> Result<Measurements> {
    let mut reader = ReaderBuilder::new().comment(Some(b'#')).trim(Trim::All).flexible(true).from_reader(bytes);
    let header = reader.headers().context("the first line is no text in UTF-8")?.clone();
    let columns = Columns::of(&header)?;
    let mut found = Measurements::default();
    for unknown in header.iter().filter(|name| !Columns::NAMES.contains(name)) {
        found.left_out.push(format!("column {unknown:?} is not used: the columns are {}", Columns::NAMES.join(", ")));
    }
    let mut row = StringRecord::new();
    loop {
        let line = line_of(bytes, reader.position().byte() as usize);
        if !reader.read_record(&mut row).with_context(|| format!("line {line}"))? {
            break;
        }
        let (fields, named) = (row.len(), header.len());
        ensure!(fields == named, "line {line}: {fields} fields, where the first line names {named}");
        found.all.push(measurement(&columns, &row, line).with_context(|| format!("line {line}"))?);
    }
    ensure!(!found.all.is_empty(), "there is not one measurement below the first line");
    Ok(found)
}

/// The line of the row that is read next, from 1. The reader's own position stands before the blank lines and comments that it
/// skips, and a message must name the line that the lab has to look at.
fn line_of(bytes: &[u8], from: usize) -> u64 {
    let (before, after) = bytes.split_at(from.min(bytes.len()));
    // A reader that stopped between the two bytes of a line's end is still on that line.
    let rows = after.split_inclusive(|&byte| byte == b'\n');
    let skipped = rows.take_while(|row| row.starts_with(b"#") || matches!(*row, b"\n" | b"\r\n")).count();
    (before.split(|&byte| byte == b'\n').count() + skipped) as u64
}

fn measurement(columns: &Columns, row: &StringRecord, line: u64) -> Result<Measurement> {
    let field = |place: usize| row.get(place).unwrap_or_default();
    let pressure_kpa = number("pressure_kpa", field(columns.pressure))?;
    let mut bend_deg = number("bend_deg", field(columns.bend))?;
    ensure!(
        (0.0..=MAX_KPA).contains(&pressure_kpa),
        "pressure_kpa is {pressure_kpa}, outside 0..={MAX_KPA}: give gauge pressure in kPa, or remove the line"
    );
    let segment = columns.segment.map_or("", field);
    let scope = match segment {
        "" | "all" | "finger" => Scope::All,
        name => Segment::ALL
            .into_iter()
            .find(|segment| segment.name() == name)
            .map(Scope::of)
            .ok_or_else(|| anyhow!("segment is {name:?}: it must be proximal, middle, distal, finger or all"))?,
    };
    let chambers = if segment == "finger" { CHAMBERS } else { 1.0 };
    let most = MAX_DEG * chambers;
    ensure!(
        bend_deg > MIN_DEG && bend_deg < most,
        "bend_deg is {bend_deg}, outside {MIN_DEG}..{most}: give degrees, {}",
        if segment == "finger" {
            "the three segments' sum"
        } else {
            "of one segment (segment finger: the sum of three)"
        }
    );
    ensure!(
        bend_deg > 0.0 || pressure_kpa < EMPTY_KPA,
        "bend_deg is {bend_deg} at {pressure_kpa} kPa: a filled segment bends by more than 0; check the sign, or remove \
         the line"
    );
    bend_deg /= chambers;
    let repeat = match columns.repeat.map_or("", field) {
        "" => None,
        text => Some(u32::from_str(text).map_err(|_| anyhow!("repeat is {text:?}: it must be a whole number"))?),
    };
    Ok(Measurement { place: Place::Line(line), scope, repeat, pressure_kpa, bend_deg })
}

fn number(column: &str, text: &str) -> Result<f64> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| {
        let hint = if text.contains(',') { " (write a decimal point, not a comma)" } else { "" };
        anyhow!("{column} is {text:?}: it must be a number{hint}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        format!("{:#}", parse(text.as_bytes()).expect_err(text))
    }

    #[test]
    fn columns_in_any_order_comments_and_blanks() {
        let text =
            "\u{feff}# by hand\nbend_deg , pressure_kpa,repeat,segment\n\n46.3, 30 ,2,middle\n# no\n-0.5,0,,middle\r\n";
        let found = parse(text.as_bytes()).expect("read");
        assert_eq!(found.left_out, Vec::<String>::new());
        let [first, second] = found.all.as_slice() else { panic!("{found:?}") };
        assert_eq!(
            *first,
            Measurement {
                place: Place::Line(4),
                scope: Scope::of(Segment::Middle),
                repeat: Some(2),
                pressure_kpa: 30.0,
                bend_deg: 46.3
            }
        );
        assert_eq!((second.place, second.repeat, second.bend_deg), (Place::Line(6), None, -0.5));
    }

    #[test]
    fn of_a_whole_finger_a_third_is_taken() {
        let found =
            parse(b"pressure_kpa,bend_deg,segment\n150,338.7,finger\n150,112.6,all\n150,112.7,\n").expect("read");
        assert!((found.all[0].bend_deg - 112.9).abs() < 1e-9);
        assert!(found.all.iter().all(|m| m.scope == Scope::All));
    }

    #[test]
    fn a_column_that_is_not_known_is_told() {
        let found = parse(b"pressure_kpa,bend_deg,segmnt\n30,46.3,distal\n").expect("read");
        assert!(found.left_out[0].contains("segmnt") && found.left_out[0].contains("segment"), "{:?}", found.left_out);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line_value_and_limit() {
        let head = "pressure_kpa,bend_deg,segment,repeat\n30,46.3,all,1\n";
        for (row, named) in [
            ("180,99,all,1", vec!["line 3", "pressure_kpa is 180", "0..=165", "kPa"]),
            ("-1,99,all,1", vec!["line 3", "pressure_kpa is -1", "0..=165"]),
            ("sixty,99,all,1", vec!["line 3", "pressure_kpa is \"sixty\"", "number"]),
            ("nan,99,all,1", vec!["line 3", "pressure_kpa is \"nan\""]),
            ("60,\"70,9\",all,1", vec!["line 3", "70,9", "decimal point"]),
            ("60,,all,1", vec!["line 3", "bend_deg is \"\""]),
            ("60,170,all,1", vec!["line 3", "bend_deg is 170", "-10..170", "finger"]),
            ("60,510,finger,1", vec!["line 3", "bend_deg is 510", "-10..510", "sum"]),
            ("60,-3,all,1", vec!["line 3", "bend_deg is -3", "60 kPa", "sign"]),
            ("60,70,thumb,1", vec!["line 3", "\"thumb\"", "proximal, middle, distal"]),
            ("60,70,all,first", vec!["line 3", "repeat is \"first\"", "whole number"]),
            ("60,70,all", vec!["line 3", "3 fields", "names 4"]),
            ("\r\n# no\r\n\r\n180,99,all,1", vec!["line 6", "pressure_kpa is 180"]),
            ("60,70,distal,1", vec!["line 2 is of all", "line 3 of the distal", "two files"]),
        ] {
            let error = refused(&format!("{head}{row}\n"));
            assert!(named.iter().all(|part| error.contains(part)), "{row}: {error}");
            assert_eq!(error.lines().count(), 1, "{error}");
        }
        for (text, named) in [
            ("pressure_kpa;bend_deg\n30;46.3\n", vec!["no column pressure_kpa", "commas", "pressure_kpa;bend_deg"]),
            ("pressure_kpa,angle\n30,46.3\n", vec!["no column bend_deg", "pressure_kpa,angle"]),
            ("pressure_kpa,bend_deg\n# nothing\n", vec!["not one measurement"]),
            ("", vec!["no column pressure_kpa"]),
        ] {
            let error = refused(text);
            assert!(named.iter().all(|part| error.contains(part)), "{text}: {error}");
        }
        let error = format!("{:#}", parse(b"pressure_kpa,bend_deg\n30,\xff\xfe\n").expect_err("no text"));
        assert!(error.contains("line"), "{error}");
        let error = format!("{:#}", read(Path::new("no-such.csv")).expect_err("not there"));
        assert!(error.contains("no-such.csv"), "{error}");
    }
}
