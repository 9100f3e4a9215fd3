//! What a session, or a recording, comes to.

use super::state::State;
use crate::report::record::{Record, code_name, link_mode_name};
use model_core::controller::Fault;
use model_core::supervisor::fault::FaultSet;
use serde::Serialize;

/// A fault that was latched at some time.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Alarmed {
    /// Its name.
    pub fault: String,
    /// How urgent; `unknown` for a fault that this version does not know.
    pub priority: &'static str,
    /// When it was first told, ms of the recording.
    pub since_ms: u32,
}

/// Counts rows as they come.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// What the dashboard would show.
    pub state: State,
    rows: u64,
    first_ms: Option<u32>,
    seen: FaultSet,
    alarms: Vec<Alarmed>,
}

/// The summary, as `--json` prints it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Where the rows came from, in words.
    pub source: String,
    /// The device's firmware; none when it did not say.
    pub firmware: Option<String>,
    /// The sequence that was to run, or that the recording says was started last.
    pub sequence: Option<String>,
    /// `finished`, `running`, `not-started`, or why it failed; nothing in a replay.
    pub sequence_outcome: Option<String>,
    /// Time from the first row to the last, s.
    pub duration_s: f64,
    /// Rows of the recording.
    pub rows: u64,
    /// Whole frames that came; nothing in a replay.
    pub frames: Option<u64>,
    /// Telemetry frames that never came.
    pub frames_lost: Option<u32>,
    /// Frames that came and were no message.
    pub frames_bad: Option<u32>,
    /// Those among them whose CRC did not fit; nothing in a replay.
    pub frames_bad_crc: Option<u32>,
    /// How often the link was lost.
    pub link_gaps: u32,
    /// The longest time without a frame, s; nothing in a replay.
    pub longest_gap_s: Option<f64>,
    /// Starts of the device that were seen.
    pub device_restarts: u32,
    /// Frames that the device dropped since its start.
    pub device_dropped_frames: Option<u32>,
    /// Control ticks that started late, since the device's start.
    pub late_ticks: Option<u32>,
    /// The device's mode at the end.
    pub mode: Option<String>,
    /// Every fault that was latched at some time, the first first.
    pub alarms: Vec<Alarmed>,
    /// The highest estimate of each chamber, kPa.
    pub highest_estimate_kpa: [f64; 3],
    /// The recording.
    pub recording: String,
}

impl Tally {
    /// Takes the next row.
    pub fn take(&mut self, row: &Record) {
        self.rows += 1;
        self.first_ms.get_or_insert(row.time_ms);
        let new = row.faults.without(self.seen);
        self.seen = self.seen.union(row.faults);
        self.alarms.extend(new.codes().map(|code| Alarmed {
            fault: code_name(code),
            priority: Fault::from_code(code).map_or("unknown", |fault| fault.priority().name()),
            since_ms: row.time_ms,
        }));
        self.state.take(row);
    }

    /// What the rows alone say.
    #[must_use]
    pub fn summary(&self, source: &str, recording: &str) -> Summary {
        let last = self.state.last();
        let link = last.map(|last| last.link).unwrap_or_default();
        let (link_gaps, device_restarts) = self.state.gaps_and_restarts();
        let millis = last.map_or(0, |last| last.time_ms).saturating_sub(self.first_ms.unwrap_or(0));
        Summary {
            source: source.to_owned(),
            firmware: None,
            sequence: self.state.sequence().map(|sequence| sequence.name.to_owned()),
            sequence_outcome: None,
            duration_s: f64::from(millis) / 1000.0,
            rows: self.rows,
            frames: None,
            frames_lost: link.frames_lost,
            frames_bad: link.frames_bad,
            frames_bad_crc: None,
            link_gaps,
            longest_gap_s: None,
            device_restarts,
            device_dropped_frames: link.device_dropped_frames,
            late_ticks: link.late_ticks,
            mode: last.map(|last| link_mode_name(last.mode)),
            alarms: self.alarms.clone(),
            highest_estimate_kpa: self.state.highest_kpa(),
            recording: recording.to_owned(),
        }
    }
}

impl Summary {
    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let count = |count: Option<u32>| count.map_or_else(|| "unknown".into(), |count| count.to_string());
        let mut out = format!("{}: {:.1} s, {} rows\n", self.source, self.duration_s, self.rows);
        if let Some(name) = &self.sequence {
            out += &format!("sequence {name}: {}\n", self.sequence_outcome.as_deref().unwrap_or("as recorded"));
        }
        let [p, m, d] = self.highest_estimate_kpa;
        out += &format!("mode at the end: {}\n", self.mode.as_deref().unwrap_or("unknown, no frame came"));
        out += &format!("highest estimates: {p:.1} / {m:.1} / {d:.1} kPa\n");
        out += &format!(
            "link: {} frames lost, {} bad, lost {} times; device started anew {} times\n",
            count(self.frames_lost),
            count(self.frames_bad),
            self.link_gaps,
            self.device_restarts
        );
        for alarm in &self.alarms {
            let seconds = f64::from(alarm.since_ms) / 1000.0;
            out += &format!("alarm: {} ({} priority) from {seconds:.2} s\n", alarm.fault, alarm.priority);
        }
        out + &format!("recording: {}\n", self.recording)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::record::Source;

    #[test]
    fn every_fault_and_gap_is_counted_once() {
        let mut tally = Tally::default();
        for (time, bits, event) in [
            (100, 0, "taken: run all"),
            (110, 1 << 4, ""),
            (120, 1 << 4 | 1 << 63, "link lost: gone"),
            (130, 0, "link back after 1.00 s: 3 frames lost"),
            (140, 1 << 4, "link lost: gone | device started anew"),
        ] {
            let mut row = Record::unknown(Source::Device, time);
            row.faults = FaultSet::from_bits(bits);
            row.event = event.into();
            row.link.frames_lost = Some(3);
            tally.take(&row);
        }
        let summary = tally.summary("bench", "a.csv");
        assert_eq!((summary.rows, summary.link_gaps, summary.device_restarts), (5, 2, 1));
        assert_eq!((summary.frames_lost, summary.sequence.as_deref()), (Some(3), Some("all")));
        let alarms: Vec<_> =
            summary.alarms.iter().map(|one| (one.fault.as_str(), one.priority, one.since_ms)).collect();
        assert_eq!(alarms, [("emergency-stop", "high", 110), ("code-63", "unknown", 120)]);
        assert!(summary.text().contains("alarm: emergency-stop (high priority) from 0.11 s"), "{}", summary.text());
    }
}
