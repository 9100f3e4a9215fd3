//! A recording, of a device or of a simulated run, as the same report that a simulated run has.
//!
//! A device does not know the true pressures of its chambers: its figures are then of the controller's own estimate, and its bends those
//! that the controller's model has for it. The report says so.

use super::csv::{Recording, read};
use super::record::{Record, Source, link_mode_name};
use super::{Content, Folder, chart, write_content};
use crate::metrics::{Summary, summarise};
use crate::trace::{Sample, Trace};
use anyhow::{Context, Result};
use model_core::controller::Mode;
use model_core::protocol::LinkMode;
use std::fs;
use std::path::{Path, PathBuf};

/// A recording with its figures.
#[derive(Clone, Debug)]
pub struct Opened {
    /// The file's name.
    pub name: String,
    /// What was read.
    pub recording: Recording,
    /// Its figures; what nobody knows is not a number.
    pub summary: Summary,
    /// Whether the figures are of true pressures; of the controller's estimates otherwise.
    pub true_pressures: bool,
    /// What to know of the data.
    pub notes: Vec<String>,
}

/// Opens a recording, cut or damaged as it may be.
///
/// # Errors
/// Names the file when it cannot be read, or is no recording.
pub fn open(path: &Path) -> Result<Opened> {
    let named = || format!("cannot open {}", path.display());
    let recording = fs::read(path).map_err(anyhow::Error::from).and_then(|bytes| read(&bytes)).with_context(named)?;
    let name = path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned());
    Ok(Opened::new(name, recording))
}

impl Opened {
    fn new(name: String, recording: Recording) -> Self {
        let records = &recording.records;
        let true_pressures = records.iter().all(|record| record.chambers_kpa.iter().all(|kpa| kpa.is_finite()));
        let samples = records.iter().map(|record| sample(record, true_pressures)).collect();
        let trace = Trace { name: name.clone(), description: String::new(), seed: 0, samples };
        let mut summary = summarise(&trace);
        // By name: a newer device may have faults that this version knows by their codes only.
        summary.faults = faults(records);
        if !records.iter().any(|record| chart::bend_deg(record, 0).is_finite()) {
            summary.segments.iter_mut().for_each(|segment| segment.peak_bend_deg = f64::NAN);
            let read = records.iter().map(|record| record.bend_sensor_deg).filter(|deg| deg.is_finite());
            summary.peak_bend_deg = read.reduce(f64::max).unwrap_or(f64::NAN);
        }
        let notes = notes(&recording, true_pressures);
        Self { name, recording, summary, true_pressures, notes }
    }

    /// A line on where the rows come from.
    #[must_use]
    pub fn description(&self) -> String {
        let records = &self.recording.records;
        let has = |source: Source| records.iter().any(|record| record.source == source);
        let sources: Vec<&str> = Source::ALL
            .into_iter()
            .filter(|&source| has(source))
            .map(|source| match source {
                Source::Simulated => "a simulated finger",
                Source::Device => "a device",
                Source::Emulated => "the emulated board",
            })
            .collect();
        format!("Recording of {}, {} rows, {:.1} s.", sources.join(" and "), records.len(), self.summary.duration_s)
    }

    /// Writes the report; returns its files, the page first.
    ///
    /// # Errors
    /// When a picture cannot be drawn or a file not be written.
    pub fn write(&self, folder: &Folder) -> Result<Vec<PathBuf>> {
        let content = Content {
            name: &self.name,
            description: self.description(),
            records: &self.recording.records,
            summary: &self.summary,
            parameters: None,
            notes: self.notes.clone(),
        };
        write_content(folder, &content, &[])
    }
}

/// As figures take it; without true pressures the controller's estimates stand for them.
fn sample(record: &Record, true_pressures: bool) -> Sample {
    Sample {
        time_ms: record.time_ms,
        actuation: record.actuation,
        // A fault that this version does not know vents like any other; its name is taken from the record.
        mode: record.mode.mode().unwrap_or(Mode::Vented),
        faults: record.faults,
        step: record.step,
        repeat: record.repeat,
        holding: record.holding,
        setpoints_kpa: record.setpoints_kpa,
        estimates_kpa: record.estimates_kpa,
        chambers_kpa: if true_pressures { record.chambers_kpa } else { record.estimates_kpa },
        manifold_kpa: if record.manifold_kpa.is_finite() { record.manifold_kpa } else { record.sensor_kpa },
        sensor_kpa: record.sensor_kpa,
        bends_deg: [0, 1, 2].map(|index| chart::bend_deg(record, index)),
        bend_sensor_deg: record.bend_sensor_deg,
    }
}

/// Names of the faults that vented, in order of time.
fn faults(records: &[Record]) -> Vec<String> {
    let stretches = records.chunk_by(|a, b| a.mode == b.mode);
    let faulted = stretches.filter(|rows| matches!(rows[0].mode, LinkMode::Faulted(_)));
    faulted.map(|rows| link_mode_name(rows[0].mode).replace("faulted:", "")).collect()
}

fn notes(recording: &Recording, true_pressures: bool) -> Vec<String> {
    let mut notes = Vec::new();
    if !true_pressures {
        notes.push(
            "Nobody knows the true pressures in the chambers: pressures and errors here are the controller's own estimate.".into(),
        );
    }
    if recording.torn {
        notes.push("The file was cut: its last line had no end and was left out.".into());
    }
    if let Some((line, why)) = &recording.first_bad {
        notes.push(format!(
            "{} line(s) were no rows and were left out; the first is line {line}: {why}.",
            recording.bad_lines
        ));
    }
    let last = recording.records.last().map(|record| record.link).unwrap_or_default();
    for (count, what) in [
        (last.frames_lost, "telemetry frames were lost"),
        (last.frames_bad, "damaged frames came"),
        (last.late_ticks, "control ticks were late"),
        (last.device_dropped_frames, "frames were dropped by the device"),
    ] {
        if let Some(count) = count.filter(|&count| count > 0) {
            notes.push(format!("{count} {what}."));
        }
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::csv::{RecordWriter, table};
    use crate::simulate::{Program, Run};
    use model_core::units::Pressure;

    fn trace() -> Trace {
        let run = Run::new(Program::Setpoints([30, 0, 30].map(Pressure::from_kpa)), 2);
        run.simulate(|_, _| {}).expect("taken")
    }

    fn opened(text: &[u8]) -> Opened {
        Opened::new("run.csv".into(), read(text).expect("a recording"))
    }

    fn text(records: impl Iterator<Item = Record>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = RecordWriter::new(&mut bytes, 1000).expect("begins");
        records.for_each(|record| writer.write(&record).expect("written"));
        drop(writer);
        bytes
    }

    /// As a device tells it: a row each 10 ms, and nothing that only a simulation knows.
    fn device(record: &Record) -> Record {
        Record {
            source: Source::Device,
            chambers_kpa: [f64::NAN; 3],
            manifold_kpa: f64::NAN,
            bends_deg: [f64::NAN; 3],
            ..record.clone()
        }
    }

    #[test]
    fn a_simulated_run_has_the_same_figures_read_from_its_table() {
        let trace = trace();
        let opened = opened(table(&trace).expect("written").as_bytes());
        assert!(opened.true_pressures && opened.notes.is_empty(), "{:?}", opened.notes);
        let (direct, read) = (summarise(&trace), &opened.summary);
        assert_eq!(direct.faults, read.faults);
        assert_eq!(direct.valve_switchings, read.valve_switchings);
        assert!((direct.duration_s - read.duration_s).abs() < 1e-9);
        assert!((direct.pump_on_s - read.pump_on_s).abs() < 1e-9);
        // The table has four decimals.
        let near = |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| (a - b).abs() < 1e-4);
        assert!(near(direct.hold_mean_abs_error_kpa, read.hold_mean_abs_error_kpa), "{read:?}");
        assert!(near(Some(direct.peak_bend_deg), Some(read.peak_bend_deg)), "{read:?}");
    }

    #[test]
    fn a_devices_figures_are_of_its_estimate_and_say_so() {
        let records: Vec<Record> = trace().samples.iter().step_by(10).map(Record::from).collect();
        let opened = opened(&text(records.iter().map(device)));
        assert!(!opened.true_pressures);
        assert!(opened.notes[0].contains("estimate"), "{:?}", opened.notes);
        let most = records.iter().map(|record| record.estimates_kpa[0]).fold(0.0, f64::max);
        assert!((opened.summary.segments[0].peak_chamber_kpa - most).abs() < 1e-4);
        let read = records.iter().map(|record| record.bend_sensor_deg).fold(0.0, f64::max);
        assert!((opened.summary.peak_bend_deg - read).abs() < 1e-4, "the sensor's, for want of another");
        assert!(opened.summary.segments[0].peak_bend_deg.is_nan());
        let pump_on = records.iter().filter(|record| record.actuation.pump).count() as f64 * 0.01;
        assert!((opened.summary.pump_on_s - pump_on).abs() < 0.02, "{} {pump_on}", opened.summary.pump_on_s);
        let place = tempfile::tempdir().expect("a folder");
        let files = opened.write(&Folder::prepare(place.path()).expect("writable")).expect("written");
        let page = fs::read_to_string(&files[0]).expect("reads");
        assert!(page.contains("Recording of a device") && page.contains("estimate") && !page.contains("NaN°"));
        assert!(!files.iter().any(|file| file.ends_with("finger.svg")), "no bend is known");
    }

    #[test]
    fn a_cut_and_damaged_file_opens_and_tells_what_was_left_out() {
        let mut bytes = table(&trace()).expect("written").into_bytes();
        let third = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').nth(3).expect("lines").0;
        bytes[third + 1] = b'x';
        bytes.truncate(bytes.len() - 40);
        let opened = opened(&bytes);
        assert!(opened.recording.torn && opened.recording.bad_lines == 1);
        let notes = opened.notes.join(" ");
        assert!(notes.contains("cut") && notes.contains("line 5"), "{notes}");
    }

    #[test]
    fn a_fault_of_a_newer_device_is_named_by_its_code() {
        let row = |time_ms, mode| Record { mode, ..Record::unknown(Source::Device, time_ms) };
        let rows = [row(0, LinkMode::Vented), row(10, LinkMode::Faulted(63)), row(20, LinkMode::Faulted(63))];
        assert_eq!(opened(&text(rows.into_iter())).summary.faults, ["code-63"]);
    }

    #[test]
    fn an_event_cannot_break_the_page() {
        let event = "</script><script>alert(1)</script><b>".to_owned();
        let rows = [0, 10].map(|time_ms| Record { event: event.clone(), ..Record::unknown(Source::Device, time_ms) });
        let place = tempfile::tempdir().expect("a folder");
        let files = opened(&text(rows.into_iter())).write(&Folder::prepare(place.path()).expect("writable"));
        let page = fs::read_to_string(&files.expect("written")[0]).expect("reads");
        assert!(page.contains("&lt;/script&gt;") && !page.contains("<script>alert"));
    }

    #[test]
    fn what_is_no_recording_is_named() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        fs::write(file.path(), "pressure_kpa,bend_deg\n30,46\n").expect("written");
        let error = format!("{:#}", open(file.path()).expect_err("no recording"));
        assert!(error.contains(&file.path().display().to_string()) && error.contains("no recording"), "{error}");
    }
}
