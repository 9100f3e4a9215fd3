//! What the dashboard shows, made of the recording's rows: the same for a device, the emulated board and a replay.

use super::event;
use crate::report::record::{Record, code_name};
use model_core::controller::Fault;
use model_core::protocol::LinkMode;
use model_core::sequence::{Sequence, library};
use model_core::supervisor::fault::Priority;
use std::collections::VecDeque;

/// How far back the curves go, ms.
pub const SHOWN_MS: u32 = 20_000;
/// Time between two points of a curve, ms: finer than a dot of the terminal.
const POINT_MS: u32 = 50;
/// Events that are kept.
const EVENTS: usize = 100;

/// One moment of the curves; not a number where nobody knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Time of the recording, ms.
    pub time_ms: u32,
    /// Reference of each chamber.
    pub setpoints_kpa: [f64; 3],
    /// Estimate of each chamber.
    pub estimates_kpa: [f64; 3],
}

/// A latched fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alarm {
    /// The fault's number.
    pub code: u8,
    /// Its name, or `code-63` when this version knows none.
    pub name: String,
    /// How urgent; nothing when this version does not know the fault.
    pub priority: Option<Priority>,
    /// When it was first told, ms of the recording.
    pub since_ms: u32,
    /// The operator has seen it.
    pub seen: bool,
}

/// Where a sequence is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Which.
    pub sequence: &'static Sequence,
    /// Done share, 0..=1.
    pub share: f64,
}

/// See the module's page.
#[derive(Clone, Debug, Default)]
pub struct State {
    last: Option<Record>,
    points: VecDeque<Point>,
    alarms: Vec<Alarm>,
    events: VecDeque<(u32, String)>,
    sequence: Option<&'static Sequence>,
    /// When the step that runs began: its repeat, its index, the time, ms.
    step: Option<(u16, u16, u32)>,
    /// Time that the step has spent in pause, ms.
    paused_ms: u32,
    highest_kpa: [f64; 3],
    /// How often the link was lost, and the device started anew.
    link_gaps: u32,
    restarts: u32,
}

impl State {
    /// Takes the next row.
    pub fn take(&mut self, row: &Record) {
        for happened in event::split(&row.event) {
            self.link_gaps += u32::from(event::is_gap(happened));
            self.restarts += u32::from(event::is_restart(happened));
            self.events.push_back((row.time_ms, happened.to_owned()));
        }
        while self.events.len() > EVENTS {
            self.events.pop_front();
        }
        if let Some(name) = event::started(&row.event) {
            self.sequence = library::find(name);
            self.step = None;
        }
        self.follow(row);
        self.alarm(row);
        for (highest, kpa) in self.highest_kpa.iter_mut().zip(row.estimates_kpa) {
            *highest = highest.max(kpa);
        }
        self.point(row);
        self.last = Some(row.clone());
    }

    fn follow(&mut self, row: &Record) {
        let before = self.last.as_ref().map_or(row.time_ms, |last| last.time_ms);
        match row.mode {
            LinkMode::Running => {
                let at = (row.repeat, row.step);
                if self.step.is_none_or(|(repeat, step, _)| (repeat, step) != at) {
                    self.step = Some((row.repeat, row.step, row.time_ms));
                    self.paused_ms = 0;
                }
            }
            LinkMode::Paused => self.paused_ms = self.paused_ms.saturating_add(row.time_ms.saturating_sub(before)),
            _ => self.step = None,
        }
    }

    fn alarm(&mut self, row: &Record) {
        self.alarms.retain(|alarm| row.faults.codes().any(|code| code == alarm.code));
        for code in row.faults.codes() {
            if !self.alarms.iter().any(|alarm| alarm.code == code) {
                let priority = Fault::from_code(code).map(Fault::priority);
                self.alarms.push(Alarm { code, name: code_name(code), priority, since_ms: row.time_ms, seen: false });
            }
        }
        // The most urgent one first, then the oldest.
        self.alarms.sort_by_key(|alarm| (core::cmp::Reverse(alarm.priority), alarm.since_ms, alarm.code));
    }

    fn point(&mut self, row: &Record) {
        let gap = row.estimates_kpa.iter().all(|kpa| kpa.is_nan());
        let due = self.points.back().is_none_or(|last| row.time_ms >= last.time_ms.saturating_add(POINT_MS));
        if due || gap {
            let Record { time_ms, setpoints_kpa, estimates_kpa, .. } = *row;
            self.points.push_back(Point { time_ms, setpoints_kpa, estimates_kpa });
        }
        while self.points.front().is_some_and(|first| first.time_ms.saturating_add(SHOWN_MS) < row.time_ms) {
            self.points.pop_front();
        }
    }

    /// The operator has seen every alarm that there is.
    pub fn acknowledge(&mut self) {
        self.alarms.iter_mut().for_each(|alarm| alarm.seen = true);
    }

    /// The newest row.
    #[must_use]
    pub const fn last(&self) -> Option<&Record> {
        self.last.as_ref()
    }

    /// The curves, the oldest point first.
    pub fn points(&self) -> impl Iterator<Item = &Point> {
        self.points.iter()
    }

    /// Every latched fault, the most urgent first.
    #[must_use]
    pub fn alarms(&self) -> &[Alarm] {
        &self.alarms
    }

    /// What happened, the newest last, with its time, ms.
    #[must_use]
    pub fn events(&self) -> impl DoubleEndedIterator<Item = &(u32, String)> {
        self.events.iter()
    }

    /// How often the link was lost, and how often the device started anew.
    #[must_use]
    pub const fn gaps_and_restarts(&self) -> (u32, u32) {
        (self.link_gaps, self.restarts)
    }

    /// The sequence that was started last.
    #[must_use]
    pub const fn sequence(&self) -> Option<&'static Sequence> {
        self.sequence
    }

    /// The highest estimate of each chamber so far, kPa.
    #[must_use]
    pub const fn highest_kpa(&self) -> [f64; 3] {
        self.highest_kpa
    }

    /// Where the sequence is; nothing while none runs, or when nobody knows which.
    #[must_use]
    pub fn progress(&self) -> Option<Progress> {
        let last = self.last.as_ref()?;
        let sequence = self.sequence.filter(|_| matches!(last.mode, LinkMode::Running | LinkMode::Paused))?;
        let (repeat, step, since_ms) = self.step?;
        let steps = sequence.steps();
        let time = |steps: &[model_core::sequence::Step]| steps.iter().map(|one| one.ramp.0 + one.hold.0).sum::<u32>();
        let before = steps.get(..usize::from(step)).map(time)?;
        let own = steps.get(usize::from(step)..)?.get(..1).map(time)?;
        let into = last.time_ms.saturating_sub(since_ms).saturating_sub(self.paused_ms).min(own);
        let done = u32::from(repeat) * time(steps) + before + into;
        Some(Progress { sequence, share: (f64::from(done) / f64::from(sequence.duration().0.max(1))).min(1.0) })
    }

    /// Bend of each segment, degrees, as well as it is known: the truth, or the model's. The last row's.
    #[must_use]
    pub fn bends_deg(&self) -> Option<[f64; 3]> {
        let last = self.last.as_ref()?;
        [last.bends_deg, last.model_bends_deg].into_iter().find(|bends| bends.iter().all(|bend| bend.is_finite()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::told;
    use super::*;
    use crate::report::record::Source;

    fn row(time_ms: u32, mode: LinkMode, change: impl FnOnce(&mut Record)) -> Record {
        let mut row = Record::from_telemetry(Source::Device, time_ms, &told(time_ms, mode));
        change(&mut row);
        row
    }

    #[test]
    fn progress_follows_steps_and_repeats_and_rests_in_pause() {
        // Three times 4, 5.5, 4.5 and 4 s.
        let mut state = State::default();
        state.take(&row(1000, LinkMode::Running, |row| row.event = "taken: run grasp".into()));
        assert_eq!(state.progress().map(|progress| progress.share), Some(0.0));
        state.take(&row(3000, LinkMode::Running, |_| {}));
        assert!((state.progress().expect("runs").share - 2.0 / 54.0).abs() < 1e-9);
        state.take(&row(9000, LinkMode::Paused, |_| {}));
        assert!((state.progress().expect("paused").share - 2.0 / 54.0).abs() < 1e-9);
        state.take(&row(10_000, LinkMode::Running, |row| (row.repeat, row.step) = (1, 2)));
        state.take(&row(11_000, LinkMode::Running, |row| (row.repeat, row.step) = (1, 2)));
        let expected = (18.0 + 4.0 + 5.5 + 1.0) / 54.0;
        assert!((state.progress().expect("runs").share - expected).abs() < 1e-9);
        // A step that lasts longer than it should does not run into the next.
        state.take(&row(60_000, LinkMode::Running, |row| (row.repeat, row.step) = (1, 2)));
        assert!((state.progress().expect("runs").share - 32.0 / 54.0).abs() < 1e-9);
        state.take(&row(61_000, LinkMode::Vented, |_| {}));
        assert_eq!(state.progress(), None);
    }

    #[test]
    fn alarms_stand_by_urgency_until_they_are_cleared() {
        let bits = |bits: u64| model_core::supervisor::fault::FaultSet::from_bits(bits);
        let mut state = State::default();
        state.take(&row(10, LinkMode::Running, |row| row.faults = bits(1 << 42)));
        state.acknowledge();
        state.take(&row(20, LinkMode::Faulted(4), |row| row.faults = bits(1 << 42 | 1 << 4 | 1 << 63)));
        let shown: Vec<_> =
            state.alarms().iter().map(|alarm| (alarm.name.as_str(), alarm.since_ms, alarm.seen)).collect();
        assert_eq!(shown, [("emergency-stop", 20, false), ("leak-slow", 10, true), ("code-63", 20, false)]);
        state.take(&row(30, LinkMode::Vented, |_| {}));
        assert_eq!(state.alarms(), []);
    }

    #[test]
    fn curves_keep_their_time_and_their_gaps() {
        let mut state = State::default();
        for time in (0..60_000).step_by(10) {
            state.take(&row(time, LinkMode::Running, |row| {
                if time == 50_010 {
                    row.estimates_kpa = [f64::NAN; 3];
                }
            }));
        }
        let points: Vec<_> = state.points().collect();
        assert_eq!((points.len(), points[0].time_ms), (401, 40_000));
        assert_eq!(points.iter().filter(|point| point.estimates_kpa[0].is_nan()).count(), 1);
        let off = |(found, exact): (f64, f64)| (found - exact).abs() < 1e-9;
        assert!(state.highest_kpa().into_iter().zip([59.0, 30.0, 61.0]).all(off));
    }
}
