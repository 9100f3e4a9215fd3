//! The recording: the one table of simulated runs and of devices on the bench. One row a moment, one column a quantity, the unit
//! in the column's name.
//!
//! It is text that only ever grows at its end, a row a line, so a file that a pulled cable or a lost power has cut at any byte
//! is still readable: a last line without its end is dropped and counted, and so is one that is no row
//! ([`read`](read::read)). The first column is the version of the table ([`SCHEMA`]) in every row, so that rows stay readable
//! when files are cut or joined. Simulated runs have a row a millisecond, devices one a telemetry frame (10 ms).
//!
//! What nobody knows is empty: the true pressures and bends of a device, a failed sensor's reading. Quantities carry
//! four decimals (0.1 Pa, 0.1 millidegree, 0.1 micrometre, 0.1 mN).

mod read;

pub use read::{Recording, read};

use super::record::{PRIORITIES, Record, fault_names, link_mode_name};
use crate::trace::Trace;
use anyhow::{Context, Result, ensure};
use core::fmt::Write as _;
use model_core::actuation::Passage;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Version of the table: raised whenever a column changes its name, its meaning or its place. Version 1 had no `source`,
/// `unix_ms`, `device_ms`, `faults`, `priority`, and nothing after `bend_sensor_deg`; it is read too.
pub const SCHEMA: u32 = 2;

/// The columns, in order. Pressures are gauge, bends are in degrees; `1` is true, running or open.
pub const COLUMNS: [&str; 46] = [
    "schema",
    "source",
    "time_ms",
    "unix_ms",
    "device_ms",
    "mode",
    "faults",
    "priority",
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
    "model_bend_proximal_deg",
    "model_bend_middle_deg",
    "model_bend_distal_deg",
    "fingertip_x_mm",
    "fingertip_y_mm",
    "fingertip_deg",
    "force_n",
    "late_ticks",
    "device_dropped_frames",
    "tick_cycles",
    "worst_tick_cycles",
    "frames_lost",
    "frames_bad",
    "event",
];

/// The first quantity's column, and the first count's of the link.
const QUANTITY: usize = 16;
const LINK: usize = 39;

/// The header's line.
fn header() -> String {
    COLUMNS.join(",") + "\n"
}

/// One row's line.
fn row(record: &Record) -> String {
    let mut out = String::with_capacity(280);
    let a = &record.actuation;
    let open = |passage: Passage| u8::from(passage == Passage::Open);
    let count = |value: Option<u64>| value.map_or_else(String::new, |value| value.to_string());
    // Writing to a string cannot fail.
    let _ = write!(
        out,
        "{SCHEMA},{},{},{},{},{},{},{},{},{},{},{},{}",
        record.source.name(),
        record.time_ms,
        count(record.unix_ms),
        count(record.device_ms.map(u64::from)),
        link_mode_name(record.mode),
        fault_names(record.faults),
        PRIORITIES[usize::from(record.priority.min(3))],
        record.repeat,
        record.step,
        u8::from(record.holding),
        u8::from(a.pump),
        open(a.dump)
    );
    for valve in a.segments {
        let _ = write!(out, ",{}", open(valve));
    }
    for value in record.quantities() {
        // A tiny negative value must not print as -0.0000: it would be another text for the same number.
        let value = if value.abs() < 0.000_05 { 0.0 } else { value };
        let _ = if value.is_finite() { write!(out, ",{value:.4}") } else { write!(out, ",") };
    }
    for value in record.link.to_array() {
        out.push(',');
        out.push_str(&count(value.map(u64::from)));
    }
    out.push(',');
    // Neither a comma nor a quote nor a line's end: a row is one line, and splits at its commas.
    out.extend(record.event.chars().map(|letter| match letter {
        ',' => ';',
        '"' => '\'',
        letter if letter.is_control() => ' ',
        letter => letter,
    }));
    out.push('\n');
    out
}

/// Writes rows to a file as they come, whole lines at a time.
#[derive(Debug)]
pub struct RecordWriter<W: Write> {
    out: W,
    /// What is not yet written.
    lines: Vec<u8>,
    held: u32,
    flush_every: u32,
}

impl<W: Write> RecordWriter<W> {
    /// Begins a table with its header. What is written is flushed after every `flush_every` rows (at least one).
    ///
    /// # Errors
    /// When the header cannot be written.
    pub fn new(out: W, flush_every: u32) -> io::Result<Self> {
        let mut writer = Self::go_on(out, flush_every);
        writer.lines = header().into_bytes();
        writer.flush()?;
        Ok(writer)
    }

    /// Goes on with a table whose last line has its end.
    fn go_on(out: W, flush_every: u32) -> Self {
        Self { out, lines: Vec::new(), held: 0, flush_every: flush_every.max(1) }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// When rows cannot be written; they are kept, and the next call tries again.
    pub fn write(&mut self, record: &Record) -> io::Result<()> {
        self.lines.extend_from_slice(row(record).as_bytes());
        self.held += 1;
        if self.held >= self.flush_every { self.flush() } else { Ok(()) }
    }

    /// Hands all rows over to the operating system.
    ///
    /// # Errors
    /// When rows cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        while !self.lines.is_empty() {
            match self.out.write(&self.lines) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                // What is written is not written again, whatever becomes of the rest.
                Ok(written) => drop(self.lines.drain(..written)),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.held = 0;
        self.out.flush()
    }
}

impl RecordWriter<File> {
    /// Begins a recording in a new file, or goes on with one of this schema: what a cut has left of a last line goes.
    ///
    /// # Errors
    /// Names the file when it cannot be opened, or is no recording of this schema.
    pub fn append(path: &Path, flush_every: u32) -> Result<Self> {
        let named = || format!("cannot record to {}", path.display());
        let mut options = OpenOptions::new();
        let mut file = options.read(true).write(true).create(true).truncate(false).open(path).with_context(named)?;
        let length = file.seek(SeekFrom::End(0)).with_context(named)?;
        if length == 0 {
            return Self::new(file, flush_every).with_context(named);
        }
        file.rewind().with_context(named)?;
        let mut start = vec![0; header().len()];
        let same = file.read_exact(&mut start).is_ok() && start == header().as_bytes();
        ensure!(same, "{} is no recording of schema {SCHEMA}: choose another file", path.display());
        let whole = whole_length(&mut file, length).with_context(named)?;
        file.set_len(whole).with_context(named)?;
        file.seek(SeekFrom::End(0)).with_context(named)?;
        Ok(Self::go_on(file, flush_every))
    }
}

impl<W: Write> Drop for RecordWriter<W> {
    fn drop(&mut self) {
        // Whoever wants to know calls `flush`.
        let _ = self.flush();
    }
}

/// The file's length up to the end of its last whole line.
fn whole_length(file: &mut File, length: u64) -> io::Result<u64> {
    const BLOCK: u64 = 4096;
    let mut end = length;
    while end > 0 {
        let start = end.saturating_sub(BLOCK);
        let mut block = vec![0; (end - start) as usize];
        file.seek(SeekFrom::Start(start))?;
        file.read_exact(&mut block)?;
        if let Some(last) = block.iter().rposition(|&byte| byte == b'\n') {
            return Ok(start + last as u64 + 1);
        }
        end = start;
    }
    Ok(0)
}

/// A simulated run's whole table as text.
///
/// # Errors
/// Never in practice: memory takes what is written to it.
pub fn table(trace: &Trace) -> Result<String> {
    let mut bytes = Vec::with_capacity(260 * (trace.samples.len() + 2));
    let mut writer = RecordWriter::new(&mut bytes, 1000)?;
    for sample in &trace.samples {
        writer.write(&sample.into())?;
    }
    writer.flush()?;
    drop(writer);
    Ok(String::from_utf8(bytes)?)
}

#[cfg(test)]
mod tests;
