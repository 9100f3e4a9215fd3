//! Reading a recording back, cut, joined or damaged as it may be.

use super::super::record::{LinkQuality, PRIORITIES, QUANTITIES, Record, Source, faults_of, link_mode_of};
use super::{COLUMNS, LINK, QUANTITY, SCHEMA};
use anyhow::{Result, anyhow, ensure};
use core::str::FromStr;
use model_core::actuation::{Actuation, Passage};
use model_core::protocol::LinkMode;
use model_core::supervisor::fault::{Fault, FaultSet};

/// A recording as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Version of the table.
    pub schema: u32,
    /// The rows, in order of time.
    pub records: Vec<Record>,
    /// The file's last line had no end, and was dropped: the file was cut.
    pub torn: bool,
    /// Other lines that were dropped, because they are no row or their time does not rise.
    pub bad_lines: usize,
    /// The first of them: its number from 1, and what is wrong with it.
    pub first_bad: Option<(usize, String)>,
}

/// Reads a recording: whole rows as they stand; what is no row is dropped and counted.
///
/// # Errors
/// When it is no recording (its first line is not the header), of a newer version, has not one whole row, or more lines
/// are bad than good.
pub fn read(bytes: &[u8]) -> Result<Recording> {
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let mut lines = bytes.split(|&byte| byte == b'\n').map(|line| line.strip_suffix(b"\r").unwrap_or(line));
    // What follows the last line's end: nothing, or a line that was cut.
    let torn = lines.next_back().is_some_and(|rest| !rest.is_empty());
    let mut lines = lines.zip(1..);
    let first = lines.next().map(|(line, _)| line).unwrap_or_default();
    let layout = Layout::of(&String::from_utf8_lossy(first))?;
    let mut recording = Recording { schema: 0, records: Vec::new(), torn, bad_lines: 0, first_bad: None };
    for (line, number) in lines {
        // Joined files have the header in the middle.
        if line == first || line.is_empty() {
            continue;
        }
        let row = str::from_utf8(line).map_err(|_| "it is no text".to_owned()).and_then(|line| layout.row(line));
        let row = row.and_then(|(schema, record)| match recording.records.last() {
            Some(last) if record.time_ms <= last.time_ms => Err(format!("time_ms {} does not rise", record.time_ms)),
            _ => Ok((schema, record)),
        });
        match row {
            Ok((schema, _)) if schema > SCHEMA => {
                return Err(anyhow!(
                    "line {number}: schema {schema} is newer than {SCHEMA}, the newest that this program reads"
                ));
            }
            Ok((schema, record)) => {
                recording.schema = recording.schema.max(schema);
                recording.records.push(record);
            }
            Err(why) => {
                recording.bad_lines += 1;
                recording.first_bad.get_or_insert((number, why));
            }
        }
    }
    let why = recording.first_bad.as_ref().map_or_else(String::new, |(number, why)| format!(" (line {number}: {why})"));
    ensure!(!recording.records.is_empty(), "it has not one whole row{why}");
    ensure!(
        recording.bad_lines <= recording.records.len(),
        "of its lines {} are no rows{why}, and only {} are",
        recording.bad_lines,
        recording.records.len()
    );
    Ok(recording)
}

/// Where each of [`COLUMNS`] stands in a file.
struct Layout {
    places: [Option<usize>; COLUMNS.len()],
    /// Columns of the file.
    width: usize,
}

impl Layout {
    fn of(header: &str) -> Result<Self> {
        let names: Vec<&str> = header.split(',').collect();
        let places = COLUMNS.map(|column| names.iter().position(|&name| name == column));
        // What every version has, and what nothing can be drawn without.
        for needed in ["schema", "time_ms", "mode"] {
            ensure!(
                names.contains(&needed),
                "it is no recording: its first line has no column {needed:?}; `host-sim run` and `host-sim monitor` write \
                 recordings"
            );
        }
        Ok(Self { places, width: names.len() })
    }

    /// The row in a line, with its schema; or what is wrong.
    fn row(&self, line: &str) -> Result<(u32, Record), String> {
        let fields: Vec<&str> = line.split(',').collect();
        if fields.len() != self.width {
            return Err(format!("{} fields, where the header has {}", fields.len(), self.width));
        }
        let fields = Fields { fields: &fields, places: &self.places };
        let source = fields.named::<Source>("source", |name| name.parse().ok())?;
        let mut record = Record::unknown(source.unwrap_or(Source::Simulated), fields.needed("time_ms")?);
        record.unix_ms = fields.number("unix_ms")?;
        record.device_ms = fields.number("device_ms")?;
        record.mode = fields.named("mode", link_mode_of)?.ok_or("mode is empty")?;
        record.faults = fields.named("faults", faults_of)?.unwrap_or_else(|| faults_by_mode(record.mode));
        let priority = fields.named("priority", |name| PRIORITIES.iter().position(|&known| known == name))?;
        record.priority = priority.map_or_else(|| priority_of(record.faults), |index| index as u8);
        record.repeat = fields.number("repeat")?.unwrap_or_default();
        record.step = fields.number("step")?.unwrap_or_default();
        record.holding = fields.flag("holding")?;
        let passage = |open| if open { Passage::Open } else { Passage::Closed };
        record.actuation = Actuation {
            pump: fields.flag("pump_on")?,
            dump: passage(fields.flag("dump_open")?),
            segments: [
                passage(fields.flag("valve_proximal_open")?),
                passage(fields.flag("valve_middle_open")?),
                passage(fields.flag("valve_distal_open")?),
            ],
        };
        let mut quantities = [f64::NAN; QUANTITIES];
        for (quantity, column) in quantities.iter_mut().zip(&COLUMNS[QUANTITY..LINK]) {
            *quantity = fields.number(column)?.unwrap_or(f64::NAN);
        }
        record.set_quantities(&quantities);
        let mut link = [None; 6];
        for (count, column) in link.iter_mut().zip(&COLUMNS[LINK..]) {
            *count = fields.number(column)?;
        }
        record.link = LinkQuality::from_array(link);
        fields.field("event").clone_into(&mut record.event);
        Ok((fields.needed("schema")?, record))
    }
}

/// Schema 1 had the fault that vented, in the mode.
fn faults_by_mode(mode: LinkMode) -> FaultSet {
    match mode {
        LinkMode::Faulted(code) => Fault::from_code(code).map_or(FaultSet::EMPTY, FaultSet::of),
        _ => FaultSet::EMPTY,
    }
}

fn priority_of(faults: FaultSet) -> u8 {
    faults.priority().map_or(0, |priority| priority as u8 + 1)
}

/// One line's fields by the names of their columns.
struct Fields<'a> {
    fields: &'a [&'a str],
    places: &'a [Option<usize>; COLUMNS.len()],
}

impl Fields<'_> {
    /// The field's text; empty when the file has no such column.
    fn field(&self, column: &str) -> &str {
        let place = COLUMNS.iter().position(|&name| name == column).and_then(|index| self.places[index]);
        place.and_then(|place| self.fields.get(place)).map_or("", |field| field.trim())
    }

    fn named<T>(&self, column: &str, parse: impl Fn(&str) -> Option<T>) -> Result<Option<T>, String> {
        let text = self.field(column);
        if text.is_empty() {
            return Ok(None);
        }
        parse(text).map(Some).ok_or_else(|| format!("{column} is {text:?}"))
    }

    fn number<T: FromStr>(&self, column: &str) -> Result<Option<T>, String> {
        self.named(column, |text| text.parse().ok())
    }

    fn needed<T: FromStr>(&self, column: &str) -> Result<T, String> {
        self.number(column)?.ok_or_else(|| format!("{column} is empty"))
    }

    fn flag(&self, column: &str) -> Result<bool, String> {
        let flag = self.named(column, |text| match text {
            "0" => Some(false),
            "1" => Some(true),
            _ => None,
        })?;
        Ok(flag.unwrap_or_default())
    }
}
