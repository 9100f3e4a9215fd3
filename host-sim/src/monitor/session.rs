//! One device over one line: bytes and time in, rows of the recording and bytes for the line out. No clock, no I/O.

use super::event::{self, Event};
use super::link::{Link, Quality};
use super::requests::{Outcome, Requests};
use crate::report::record::{Record, Source};
use fixed::types::I8F24;
use model_core::inverse::Tabulated;
use model_core::protocol::{IdentifiedSegment, Identity, LinkCommand, LinkMode, Report};
use model_core::units::{Coefficients, Pressure};

/// Time without a frame after which the link counts as lost, ms.
pub const SILENT_MS: u64 = 500;
/// Time between two signs of life to a device that is driven by hand, ms: it vents after a second without one.
const BEAT_MS: u64 = 400;

/// Whether frames come.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Connection {
    /// None came yet.
    Waiting,
    /// They come.
    Up,
    /// They do not come any more, or the port is gone: why, and since when by the host's clock.
    Down(String, u64),
}

/// See the module's page.
#[derive(Debug)]
pub struct Session {
    source: Source,
    link: Link,
    requests: Requests,
    connection: Connection,
    /// The port is open.
    open: bool,
    identity: Option<Identity>,
    identified: Option<[IdentifiedSegment; 3]>,
    model: Option<[Tabulated; 3]>,
    /// Longest gap without a frame, ms, and how many there were.
    gaps: u32,
    longest_gap_ms: u64,
    last_frame_ms: Option<u64>,
    last_beat_ms: u64,
    events: Vec<Event>,
    outcomes: Vec<Outcome>,
    last: Option<Record>,
    /// Time of the recording less the device's clock, ms.
    ahead: i64,
    /// The host's clock at the first row.
    start_ms: Option<u64>,
}

impl Session {
    /// Nothing is connected yet.
    #[must_use]
    pub fn new(source: Source) -> Self {
        Self {
            source,
            link: Link::default(),
            requests: Requests::default(),
            connection: Connection::Waiting,
            open: false,
            identity: None,
            identified: None,
            model: None,
            gaps: 0,
            longest_gap_ms: 0,
            last_frame_ms: None,
            last_beat_ms: 0,
            events: Vec::new(),
            outcomes: Vec::new(),
            last: None,
            ahead: 0,
            start_ms: None,
        }
    }

    /// Counts of the link.
    #[must_use]
    pub const fn quality(&self) -> &Quality {
        self.link.quality()
    }

    /// Whether frames come.
    #[must_use]
    pub const fn connection(&self) -> &Connection {
        &self.connection
    }

    /// Who the device said it is.
    #[must_use]
    pub const fn identity(&self) -> Option<&Identity> {
        self.identity.as_ref()
    }

    /// What the device has identified of each segment, once it has answered the last request for it.
    #[must_use]
    pub const fn identified(&self) -> Option<&[IdentifiedSegment; 3]> {
        self.identified.as_ref()
    }

    /// How often the link was lost, and the longest time for which no frame came, ms.
    #[must_use]
    pub const fn gaps(&self) -> (u32, u64) {
        (self.gaps, self.longest_gap_ms)
    }

    /// Time since the last frame, ms.
    #[must_use]
    pub fn age_ms(&self, now_ms: u64) -> Option<u64> {
        self.last_frame_ms.map(|last| now_ms.saturating_sub(last))
    }

    /// The device's mode, as it was told last.
    #[must_use]
    pub fn mode(&self) -> Option<LinkMode> {
        self.last.as_ref().map(|last| last.mode)
    }

    /// The request that waits for its answer.
    #[must_use]
    pub fn asked(&self) -> Option<&LinkCommand> {
        self.requests.asked()
    }

    /// Every request was answered or given up.
    #[must_use]
    pub fn idle(&self) -> bool {
        self.requests.idle()
    }

    /// Asks the device.
    pub fn ask(&mut self, command: LinkCommand) {
        if command == LinkCommand::Identification {
            self.identified = None;
        }
        self.requests.ask(command);
    }

    /// The port is open.
    pub fn opened(&mut self) {
        self.open = true;
        // Coefficients may have changed, or it is another device.
        self.requests.ask(LinkCommand::Identify);
    }

    /// The port is gone. Returns the row that marks the gap's start.
    pub fn cut(&mut self, now_ms: u64, why: &str) -> Option<Record> {
        self.open = false;
        self.link.cut();
        let dropped = self.requests.cut();
        self.events.extend(dropped.into_iter().filter(|one| *one != LinkCommand::Identify).map(Event::Dropped));
        self.down(now_ms, why)
    }

    fn down(&mut self, now_ms: u64, why: &str) -> Option<Record> {
        if let Connection::Down(..) = self.connection {
            return None;
        }
        self.connection = Connection::Down(why.to_owned(), now_ms);
        let time_ms = self.time_of(now_ms);
        let last = self.last.as_ref()?;
        self.gaps += 1;
        self.events.push(Event::Lost(why.to_owned()));
        let time_ms = time_ms.max(last.time_ms.saturating_add(1));
        // What the device does now nobody knows: what it did last, and no quantity.
        let row = Record {
            mode: last.mode,
            faults: last.faults,
            priority: last.priority,
            repeat: last.repeat,
            step: last.step,
            actuation: last.actuation,
            ..Record::unknown(self.source, time_ms)
        };
        Some(self.finished(row))
    }

    /// Time of the recording at a time of the host, ms.
    fn time_of(&mut self, now_ms: u64) -> u32 {
        let start = *self.start_ms.get_or_insert(now_ms);
        u32::try_from(now_ms.saturating_sub(start)).unwrap_or(u32::MAX)
    }

    /// Takes what the line gave; returns the rows that come of it.
    pub fn bytes(&mut self, now_ms: u64, bytes: &[u8]) -> Vec<Record> {
        let received = self.link.bytes(now_ms, bytes);
        let mut rows = Vec::new();
        for one in received {
            if one.restarted {
                self.events.push(Event::Restarted);
                self.requests.ask(LinkCommand::Identify);
            }
            let outcome = self.requests.answer(&one.report);
            match one.report {
                Report::Telemetry(told) => {
                    let synchronised = self.back(now_ms, one.lost) || one.restarted;
                    let host = i64::from(self.time_of(now_ms));
                    if synchronised || self.last.is_none() {
                        self.ahead = host - i64::from(told.tick);
                    }
                    let by_device = u32::try_from(i64::from(told.tick) + self.ahead).unwrap_or_default();
                    let rising = self.last.as_ref().map_or(0, |last| last.time_ms.saturating_add(1));
                    let mut row = Record::from_telemetry(self.source, by_device.max(rising), &told);
                    if let Some(model) = &self.model {
                        for ((bend, own), bits) in row.model_bends_deg.iter_mut().zip(model).zip(told.estimates) {
                            *bend = own.bend_from_pressure(Pressure::from_bits(bits)).to_f64();
                        }
                    }
                    rows.push(self.finished(row));
                }
                Report::Identity(identity) => self.introduced(identity),
                Report::Identification { segments, .. } => {
                    self.events.push(Event::Identified(segments));
                    self.identified = Some(segments);
                }
                Report::Ack { .. } | Report::Nack { .. } => {}
            }
            self.note(outcome);
        }
        rows
    }

    /// Frames come: notes the end of a gap, and says whether there was one.
    fn back(&mut self, now_ms: u64, lost: u32) -> bool {
        let before = self.last_frame_ms.replace(now_ms);
        let was_down = matches!(self.connection, Connection::Down(..));
        if core::mem::replace(&mut self.connection, Connection::Up) != Connection::Up
            && self.identity.is_none()
            && self.requests.idle()
        {
            // It was switched on after it was asked.
            self.requests.ask(LinkCommand::Identify);
        }
        if let (true, Some(before)) = (was_down, before) {
            let after_ms = now_ms.saturating_sub(before);
            self.longest_gap_ms = self.longest_gap_ms.max(after_ms);
            self.events.push(Event::Back { after_ms, lost });
        }
        was_down
    }

    fn introduced(&mut self, identity: Identity) {
        let coefficients = identity.coefficients.map(|bits| {
            let [k, c1, c2] = bits.map(I8F24::from_bits);
            Coefficients::new(k, c1, c2).ok()
        });
        self.model = match coefficients {
            [Some(p), Some(m), Some(d)] => Some([p, m, d].map(|own| Tabulated::new(&own))),
            _ => None,
        };
        self.events.push(Event::Device(identity.clone()));
        self.identity = Some(identity);
    }

    fn note(&mut self, outcome: Option<Outcome>) {
        match outcome {
            // What says something is noted with what it says; who the device is, is asked again when frames come.
            None
            | Some(
                Outcome::Taken(LinkCommand::Identify | LinkCommand::Identification)
                | Outcome::Unanswered(LinkCommand::Identify),
            ) => {}
            Some(outcome) => {
                if let Outcome::Taken(LinkCommand::Calibrate { .. } | LinkCommand::AdoptIdentified) = outcome {
                    self.requests.ask(LinkCommand::Identify);
                }
                self.outcomes.push(outcome.clone());
                self.events.push(Event::Request(outcome));
            }
        }
    }

    /// The row with what the recorder knows beside the telemetry.
    fn finished(&mut self, mut row: Record) -> Record {
        row.link.frames_lost = Some(self.link.quality().lost);
        row.link.frames_bad = Some(self.link.quality().bad());
        row.event = event::joined(&core::mem::take(&mut self.events));
        self.last = Some(row.clone());
        row
    }

    /// Time goes on: returns the bytes that are due, and a row when the link has fallen silent.
    pub fn tick(&mut self, now_ms: u64) -> (Vec<u8>, Option<Record>) {
        let silent = self.connection == Connection::Up && self.age_ms(now_ms).is_some_and(|age| age > SILENT_MS);
        let row = if silent { self.down(now_ms, "no frame for 0.5 s") } else { None };
        (self.due(now_ms), row)
    }

    /// The bytes that are due.
    pub fn due(&mut self, now_ms: u64) -> Vec<u8> {
        if !self.open {
            return Vec::new();
        }
        let (mut bytes, given_up) = self.requests.due(now_ms);
        self.note(given_up);
        let by_hand = self.mode() == Some(LinkMode::Holding);
        if by_hand && now_ms >= self.last_beat_ms + BEAT_MS {
            self.last_beat_ms = now_ms;
            bytes.extend(self.requests.beat());
        }
        bytes
    }

    /// What became of requests since the last call.
    pub fn take_outcomes(&mut self) -> Vec<Outcome> {
        core::mem::take(&mut self.outcomes)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{frame, identified, identity, requests, run, telemetry, told};
    use super::*;
    use model_core::protocol::Reason;

    fn session() -> Session {
        let mut session = Session::new(Source::Device);
        session.opened();
        let (asked, _) = session.tick(0);
        let id = requests(&asked)[0].id;
        session.bytes(1, &frame(&identity(id)));
        session
    }

    #[test]
    fn a_new_line_is_asked_who_it_is_and_its_model_bends_the_estimates() {
        let mut session = session();
        assert!(session.idle());
        let rows = session.bytes(5, &frame(&Report::Telemetry(told(40, LinkMode::Running))));
        assert!(
            rows[0].event.starts_with("device: firmware 0.1.0 serial 004200313335511720363839"),
            "{}",
            rows[0].event
        );
        // The reference in floating point.
        let default = model_core::calibration::DEFAULT.to_f64_kpa();
        for (bend, kpa) in rows[0].model_bends_deg.into_iter().zip([59.0, 30.0, 61.0]) {
            let reference = model_core::calibration::bend_deg(default, kpa);
            assert!((bend - reference).abs() < 1e-3, "{bend} where {reference} is right");
        }
    }

    #[test]
    fn time_rises_with_the_devices_clock_however_late_the_bytes_come() {
        let mut session = session();
        let all: Vec<u8> = (0..5).flat_map(|index| frame(&telemetry(70_000 + 10 * index))).collect();
        let times: Vec<_> = session.bytes(300, &all).iter().map(|row| row.time_ms).collect();
        assert_eq!(times, [0, 10, 20, 30, 40]);
    }

    #[test]
    fn a_pulled_cable_is_marked_at_both_ends() {
        let mut session = session();
        session.bytes(10, &frame(&telemetry(1000)));
        session.ask(run("all"));
        let marked = session.cut(25, "input/output error").expect("a row");
        assert_eq!((marked.time_ms, marked.device_ms), (15, None));
        assert!(marked.estimates_kpa.iter().all(|kpa| kpa.is_nan()));
        assert_eq!(marked.event, "not sent: run all | link lost: input/output error");
        assert_eq!(session.cut(30, "again"), None);
        assert_eq!(session.tick(40).0, Vec::<u8>::new(), "nothing is sent into a closed port");
        session.opened();
        let row = &session.bytes(2010, &frame(&telemetry(3000)))[0];
        // 199 frames between 1000 and 3000 ms; the recording's time goes on with the host's clock.
        assert_eq!((row.event.as_str(), row.time_ms), ("link back after 2.00 s: 199 frames lost", 2000));
        assert_eq!((row.link.frames_lost, session.gaps()), (Some(199), (1, 2000)));
        assert_eq!(requests(&session.tick(2011).0)[0].command, LinkCommand::Identify);
    }

    #[test]
    fn silence_on_an_open_port_is_a_lost_link_too() {
        let mut session = session();
        session.bytes(10, &frame(&telemetry(1000)));
        assert_eq!(session.tick(510).1, None);
        let marked = session.tick(511).1.expect("a row");
        assert!(marked.event.ends_with("link lost: no frame for 0.5 s"), "{}", marked.event);
        assert_eq!(session.tick(512).1, None);
    }

    #[test]
    fn a_device_driven_by_hand_hears_a_beat_every_second_and_another_none() {
        for (mode, least) in [(LinkMode::Holding, 24), (LinkMode::Running, 0), (LinkMode::Vented, 0)] {
            let mut session = session();
            let mut beats = Vec::new();
            for now in (10..10_000).step_by(10) {
                session.bytes(now, &frame(&Report::Telemetry(told(now as u32, mode))));
                let sent = requests(&session.tick(now).0);
                beats.extend(sent.iter().filter(|request| request.command == LinkCommand::Beat).map(|_| now));
            }
            assert!(beats.len() >= least && (least > 0 || beats.is_empty()), "{mode:?}: {beats:?}");
            assert!(beats.windows(2).all(|pair| pair[1] - pair[0] < 1000));
        }
    }

    #[test]
    fn a_device_that_is_switched_on_late_is_asked_again() {
        let mut session = Session::new(Source::Device);
        session.opened();
        let sent: usize = (0..5000).map(|now| requests(&session.tick(now).0).len()).sum();
        assert_eq!((sent, session.idle(), session.take_outcomes()), (5, true, vec![]));
        session.bytes(5000, &frame(&telemetry(100)));
        assert_eq!(requests(&session.tick(5001).0)[0].command, LinkCommand::Identify);
    }

    #[test]
    fn answers_are_noted_in_the_next_row() {
        let mut session = session();
        session.ask(run("grasp"));
        let id = requests(&session.tick(20).0)[0].id;
        session.bytes(21, &frame(&Report::Nack { id, reason: Reason::SelfTesting }));
        session.ask(LinkCommand::Vent);
        let id = requests(&session.tick(22).0)[0].id;
        session.bytes(23, &frame(&Report::Ack { id }));
        let row = &session.bytes(30, &frame(&telemetry(10)))[0];
        assert!(row.event.ends_with("refused: run grasp (SelfTesting) | taken: vent"), "{}", row.event);
    }

    #[test]
    fn what_was_identified_is_known_and_noted_until_it_is_asked_again() {
        let mut session = session();
        session.ask(LinkCommand::Identification);
        assert_eq!(session.identified(), None);
        let id = requests(&session.tick(21).0)[0].id;
        let segments = identified();
        session.bytes(22, &frame(&Report::Identification { id, segments }));
        assert_eq!(session.identified(), Some(&segments));
        let row = &session.bytes(30, &frame(&telemetry(10)))[0];
        let told = "identified: proximal k 12.000 c1 11.000 c2 0.500 kPa";
        assert!(row.event.ends_with(told), "{}", row.event);
        session.ask(LinkCommand::Identification);
        assert_eq!(session.identified(), None);
    }

    #[test]
    fn a_device_that_starts_anew_is_noted_and_asked_again_and_time_rises_on() {
        let mut session = session();
        session.bytes(10, &frame(&telemetry(50_000)));
        let row = &session.bytes(400, &frame(&telemetry(10)))[0];
        assert_eq!((row.event.as_str(), row.time_ms), ("device started anew", 390));
        assert_eq!(requests(&session.tick(401).0)[0].command, LinkCommand::Identify);
    }
}
