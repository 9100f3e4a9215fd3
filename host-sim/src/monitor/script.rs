//! What is asked of a device without anybody at the keys: coefficients, then a sequence to its end, then to use what it found. No
//! clock, no I/O.

use super::event;
use super::requests::Outcome;
use super::session::{Connection, Session};
use model_core::protocol::{LinkCommand, LinkMode, SequenceName};
use model_core::sequence::Sequence;
use std::collections::VecDeque;

/// Longest wait for the first frame, ms.
const FIRST_FRAME_MS: u64 = 10_000;
/// Time for which the device must have been vented before anything is asked of it, ms: after a self test, or another sequence, the last
/// air still leaves, and what closes then keeps some degrees of bend.
const VENTED_MS: u64 = 1000;
/// Time that is still recorded after a sequence's end, ms: the finger is seen to vent.
const AFTER_MS: u64 = 2000;

/// How far the script is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Something is still to be asked.
    Asking,
    /// The sequence runs, or there is none.
    Running,
    /// The sequence has ended by itself, and the device was asked to use what it has identified.
    Adopting,
    /// The sequence has ended by itself, at this time, ms.
    Finished(u64),
    /// It did not come to its end: why.
    Failed(String),
}

/// See the module's page.
#[derive(Debug)]
pub struct Script {
    to_ask: VecDeque<LinkCommand>,
    /// When the sequence has ended the device is to use what it has identified.
    adopts: bool,
    sequence: Option<&'static Sequence>,
    /// Time to record, ms from the first frame on.
    for_ms: Option<u64>,
    stage: Stage,
    first_ms: Option<u64>,
    /// Since when it is vented, ms.
    vented_ms: Option<u64>,
    /// When the device took the sequence, ms.
    started_ms: Option<u64>,
    /// It was seen to run.
    ran: bool,
}

impl Script {
    /// Sends the coefficients, runs the sequence, and ends after the time, or else with the sequence.
    #[must_use]
    pub fn new(calibration: Vec<LinkCommand>, sequence: Option<&'static Sequence>, for_ms: Option<u64>) -> Self {
        let run = sequence.and_then(|sequence| SequenceName::try_from(sequence.name).ok()).map(LinkCommand::Run);
        let to_ask: VecDeque<_> = calibration.into_iter().chain(run).collect();
        let stage = if to_ask.is_empty() { Stage::Running } else { Stage::Asking };
        Self {
            to_ask,
            adopts: false,
            sequence,
            for_ms,
            stage,
            first_ms: None,
            vented_ms: None,
            started_ms: None,
            ran: false,
        }
    }

    /// When the sequence has ended the device is to use what it has identified.
    #[must_use]
    pub fn adopting(self, adopts: bool) -> Self {
        Self { adopts, ..self }
    }

    /// How far it is.
    #[must_use]
    pub const fn stage(&self) -> &Stage {
        &self.stage
    }

    /// What it runs.
    #[must_use]
    pub const fn sequence(&self) -> Option<&'static Sequence> {
        self.sequence
    }

    /// It has set the finger in motion.
    #[must_use]
    pub const fn started(&self) -> bool {
        self.started_ms.is_some()
    }

    /// Looks at the session; returns what is to be asked now.
    pub fn next(&mut self, session: &mut Session, now_ms: u64) -> Option<LinkCommand> {
        let outcomes = session.take_outcomes();
        let up = session.connection() == &Connection::Up;
        if up {
            self.first_ms.get_or_insert(now_ms);
        } else if self.first_ms.is_none() && self.for_ms.is_none() && now_ms > FIRST_FRAME_MS {
            self.stage =
                Stage::Failed("no frame came within 10 s: is the device switched on, and this its port?".into());
        }
        for outcome in &outcomes {
            match outcome {
                Outcome::Taken(LinkCommand::Run(_)) => self.started_ms = Some(now_ms),
                Outcome::Taken(LinkCommand::AdoptIdentified) => self.stage = Stage::Finished(now_ms),
                Outcome::Taken(_) => {}
                Outcome::Refused(command, reason) => {
                    self.stage = Stage::Failed(format!("the device refused: {} ({reason:?})", event::name(command)));
                }
                Outcome::Unanswered(command) => {
                    self.stage = Stage::Failed(format!("the device did not answer: {}", event::name(command)));
                }
            }
        }
        let mode = session.mode().filter(|_| up);
        self.vented_ms = (mode == Some(LinkMode::Vented)).then(|| self.vented_ms.unwrap_or(now_ms));
        let rests = self.vented_ms.is_some_and(|since| now_ms >= since + VENTED_MS);
        self.ran |= self.started() && matches!(mode, Some(LinkMode::Running | LinkMode::Paused));
        match (&self.stage, mode) {
            (Stage::Asking, Some(LinkMode::Vented)) if rests && session.idle() && !self.to_ask.is_empty() => {
                return self.to_ask.pop_front();
            }
            (Stage::Asking, Some(LinkMode::Faulted(_))) => {
                self.stage = Stage::Failed("a fault is latched: see the alarms, and clear it".into());
            }
            (Stage::Asking, Some(_)) if session.idle() && self.to_ask.is_empty() => self.stage = Stage::Running,
            (Stage::Running, Some(LinkMode::Faulted(_))) if self.sequence.is_some() => {
                self.stage = Stage::Failed("a fault ended the sequence: see the alarms".into());
            }
            // Telemetry from before the start may still come after the answer.
            (Stage::Running, Some(LinkMode::Vented)) if self.ran || self.must_be_over(now_ms) => {
                if self.adopts {
                    self.stage = Stage::Adopting;
                    return Some(LinkCommand::AdoptIdentified);
                }
                self.stage = Stage::Finished(now_ms);
            }
            (Stage::Adopting, Some(LinkMode::Faulted(_))) => {
                self.stage = Stage::Failed("a fault came before what was identified was taken".into());
            }
            _ => {}
        }
        None
    }

    /// The sequence was started so long ago that it has ended, seen or not.
    fn must_be_over(&self, now_ms: u64) -> bool {
        let ends = self.started_ms.zip(self.sequence).map(|(started, own)| started + u64::from(own.duration().0));
        ends.is_some_and(|ends| now_ms > ends)
    }

    /// Nothing is left to wait for.
    #[must_use]
    pub fn over(&self, now_ms: u64) -> bool {
        match (self.for_ms, &self.stage) {
            (Some(span), _) => now_ms >= self.first_ms.unwrap_or(0) + span,
            (None, Stage::Finished(at)) => now_ms >= at + AFTER_MS,
            (None, Stage::Failed(_)) => true,
            (None, _) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{frame, identity, requests, run, told};
    use super::*;
    use crate::report::record::Source;
    use model_core::protocol::{Reason, Report};
    use model_core::sequence::library;

    /// A device that tests itself, then runs what it is asked to run for a second.
    fn play(script: &mut Script, refuse: Option<Reason>, end_mode: LinkMode) -> (Vec<LinkCommand>, u64) {
        let mut session = Session::new(Source::Device);
        session.opened();
        let (mut asked, mut runs_since) = (Vec::new(), None);
        for now in (0..20_000).step_by(10) {
            let mode = match runs_since {
                None if now < 300 => LinkMode::SelfTest,
                None => LinkMode::Vented,
                Some(since) if now < since + 1000 => LinkMode::Running,
                Some(_) => end_mode,
            };
            session.bytes(now, &frame(&Report::Telemetry(told(now as u32, mode))));
            if let Some(command) = script.next(&mut session, now) {
                session.ask(command);
            }
            for request in requests(&session.tick(now).0) {
                let answer = match (&request.command, refuse) {
                    (LinkCommand::Identify, _) => identity(request.id),
                    (LinkCommand::Run(_), Some(reason)) => Report::Nack { id: request.id, reason },
                    (command, _) => {
                        asked.push(command.clone());
                        if matches!(command, LinkCommand::Run(_)) {
                            runs_since = Some(now);
                        }
                        Report::Ack { id: request.id }
                    }
                };
                session.bytes(now, &frame(&answer));
            }
            if script.over(now) {
                return (asked, now);
            }
        }
        panic!("never over: {script:?}");
    }

    #[test]
    fn coefficients_go_before_the_sequence_which_runs_to_its_end() {
        let calibration = super::super::keys::calibrate(&[Some(model_core::calibration::DEFAULT); 3]);
        let mut script = Script::new(calibration.clone(), library::find("all"), None);
        let (asked, end) = play(&mut script, None, LinkMode::Vented);
        assert_eq!(asked, [calibration, vec![run("all")]].concat());
        assert!(matches!(script.stage(), Stage::Finished(_)) && script.started(), "{script:?}");
        assert!((4300..4600).contains(&end), "{end}");
    }

    #[test]
    fn a_refusal_and_a_fault_fail() {
        let mut script = Script::new(Vec::new(), library::find("all"), None);
        play(&mut script, Some(Reason::Faulted), LinkMode::Vented);
        let Stage::Failed(why) = script.stage() else { panic!("{script:?}") };
        assert!(why.contains("run all") && why.contains("Faulted"), "{why}");
        let mut script = Script::new(Vec::new(), library::find("all"), None);
        play(&mut script, None, LinkMode::Faulted(4));
        assert!(matches!(script.stage(), Stage::Failed(_)), "{script:?}");
    }

    #[test]
    fn what_was_identified_is_adopted_after_the_sequence() {
        let mut script = Script::new(Vec::new(), library::find("calibrate"), None).adopting(true);
        let (asked, end) = play(&mut script, None, LinkMode::Vented);
        assert_eq!(asked, [run("calibrate"), LinkCommand::AdoptIdentified]);
        assert!(matches!(script.stage(), Stage::Finished(_)) && (4300..4700).contains(&end), "{end} {script:?}");
        let mut script = Script::new(Vec::new(), library::find("calibrate"), None).adopting(true);
        let (asked, _) = play(&mut script, None, LinkMode::Faulted(4));
        assert_eq!(asked, [run("calibrate")], "not after a fault");
    }

    #[test]
    fn a_time_ends_it_whatever_the_sequence_does() {
        let mut script = Script::new(Vec::new(), library::find("all"), Some(1700));
        assert_eq!(play(&mut script, None, LinkMode::Vented).1, 1700);
        assert_eq!(script.stage(), &Stage::Running);
        let mut script = Script::new(Vec::new(), None, Some(500));
        assert_eq!(play(&mut script, None, LinkMode::Vented), (vec![], 500));
        assert!(!script.started());
    }

    #[test]
    fn a_silent_line_is_not_waited_for_for_ever() {
        let mut script = Script::new(Vec::new(), library::find("all"), None);
        let mut session = Session::new(Source::Device);
        assert_eq!((script.next(&mut session, 10_000), script.over(10_000)), (None, false));
        assert_eq!((script.next(&mut session, 10_001), script.over(10_001)), (None, true));
    }
}
