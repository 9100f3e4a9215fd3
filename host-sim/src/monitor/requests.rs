//! What the host asks for, one request after the other, until each is answered.
//!
//! A request that is not answered is sent again with the same number. Venting waits for nothing and forgets what was to be
//! asked before it, so that no late repeat of a `run` follows it.

use model_core::protocol::{LinkCommand, MAX_FRAME, Reason, Report, Request, encode};
use serde::Serialize;
use std::collections::VecDeque;

/// Longest time until an answer, ms (docs/protocol.md).
const ANSWER_MS: u64 = 100;
/// The same for what the device stores: its flash may have to be erased first.
const STORED_MS: u64 = 2500;
/// Times that a request is sent before it counts as unanswered.
const TRIES: u32 = 5;
/// The same for venting.
const VENT_TRIES: u32 = 50;

/// What became of a request.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It was taken, or answered.
    Taken(LinkCommand),
    /// It was not taken.
    Refused(LinkCommand, Reason),
    /// No answer came.
    Unanswered(LinkCommand),
}

#[derive(Debug)]
struct Flight {
    id: u16,
    command: LinkCommand,
    sent_ms: u64,
    tries: u32,
}

/// See the module's page.
#[derive(Debug, Default)]
pub struct Requests {
    waiting: VecDeque<LinkCommand>,
    flight: Option<Flight>,
    last_id: u16,
}

impl Requests {
    /// Will ask for this after everything before it; for venting before everything else.
    pub fn ask(&mut self, command: LinkCommand) {
        if command == LinkCommand::Vent {
            self.waiting.clear();
            self.flight = None;
        }
        self.waiting.push_back(command);
    }

    /// Nothing waits for an answer.
    #[must_use]
    pub fn idle(&self) -> bool {
        self.flight.is_none() && self.waiting.is_empty()
    }

    /// What waits for its answer.
    #[must_use]
    pub fn asked(&self) -> Option<&LinkCommand> {
        self.flight.as_ref().map(|flight| &flight.command)
    }

    fn id(&mut self) -> u16 {
        self.last_id = self.last_id.wrapping_add(1);
        self.last_id
    }

    /// The bytes that are due, and what was given up.
    pub fn due(&mut self, now_ms: u64) -> (Vec<u8>, Option<Outcome>) {
        let mut given_up = None;
        if let Some(flight) = &mut self.flight {
            let (patience, tries) = patience(&flight.command);
            if now_ms < flight.sent_ms + patience {
                return (Vec::new(), None);
            }
            if flight.tries < tries {
                flight.tries += 1;
                flight.sent_ms = now_ms;
                return (framed(flight.id, &flight.command), None);
            }
            given_up = self.flight.take().map(|flight| Outcome::Unanswered(flight.command));
        }
        let Some(command) = self.waiting.pop_front() else { return (Vec::new(), given_up) };
        let id = self.id();
        let bytes = framed(id, &command);
        self.flight = Some(Flight { id, command, sent_ms: now_ms, tries: 1 });
        (bytes, given_up)
    }

    /// A request that nobody waits for: a sign of life.
    pub fn beat(&mut self) -> Vec<u8> {
        framed(self.id(), &LinkCommand::Beat)
    }

    /// Takes an answer; one to something else says nothing.
    pub fn answer(&mut self, report: &Report) -> Option<Outcome> {
        let (id, reason) = match report {
            Report::Telemetry(_) => return None,
            Report::Ack { id } | Report::Identification { id, .. } => (*id, None),
            Report::Nack { id, reason } => (*id, Some(*reason)),
            Report::Identity(identity) => (identity.id, None),
        };
        let flight = self.flight.take_if(|flight| flight.id == id)?;
        Some(match reason {
            None => Outcome::Taken(flight.command),
            Some(reason) => Outcome::Refused(flight.command, reason),
        })
    }

    /// The line is gone: everything is forgotten, but that the finger is to be vented. Returns what was.
    pub fn cut(&mut self) -> Vec<LinkCommand> {
        let flying = self.flight.take().map(|flight| flight.command);
        let (vents, others): (Vec<_>, Vec<_>) =
            flying.into_iter().chain(self.waiting.drain(..)).partition(|command| *command == LinkCommand::Vent);
        self.waiting.extend(vents.into_iter().take(1));
        others
    }
}

const fn patience(command: &LinkCommand) -> (u64, u32) {
    match command {
        LinkCommand::Vent => (ANSWER_MS, VENT_TRIES),
        LinkCommand::ZeroSensors | LinkCommand::Calibrate { .. } | LinkCommand::AdoptIdentified => (STORED_MS, 2),
        _ => (ANSWER_MS, TRIES),
    }
}

/// A request as bytes for the line.
#[must_use]
pub fn framed(id: u16, command: &LinkCommand) -> Vec<u8> {
    frame(&Request { id, command: command.clone() })
}

/// A message as bytes on the line.
pub fn frame(message: &impl Serialize) -> Vec<u8> {
    let mut frame = [0; MAX_FRAME];
    // Every message fits; docs/protocol.md bounds the longest.
    let length = encode(message, &mut frame).unwrap_or(0);
    frame[..length].to_vec()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{requests, run};
    use super::*;

    #[test]
    fn one_is_asked_after_the_other_and_repeated_until_it_is_answered() {
        let mut asks = Requests::default();
        asks.ask(LinkCommand::Pause);
        asks.ask(LinkCommand::Resume);
        let (bytes, _) = asks.due(0);
        let first = requests(&bytes);
        assert_eq!(first[0].command, LinkCommand::Pause);
        assert_eq!(asks.due(99), (vec![], None));
        // The same number, so that the device's late answer to the first fits.
        assert_eq!(requests(&asks.due(100).0), first);
        assert_eq!(asks.answer(&Report::Ack { id: first[0].id.wrapping_add(9) }), None);
        let taken = asks.answer(&Report::Nack { id: first[0].id, reason: Reason::NotRunning });
        assert_eq!(taken, Some(Outcome::Refused(LinkCommand::Pause, Reason::NotRunning)));
        assert_eq!(requests(&asks.due(101).0)[0].command, LinkCommand::Resume);
    }

    #[test]
    fn what_is_never_answered_is_given_up_and_the_next_one_asked() {
        let mut asks = Requests::default();
        asks.ask(LinkCommand::Pause);
        asks.ask(LinkCommand::Resume);
        let mut sent = 0;
        for now in 0..10_000 {
            let (bytes, given_up) = asks.due(now);
            sent += requests(&bytes).len();
            if given_up.is_some() {
                assert_eq!(given_up, Some(Outcome::Unanswered(LinkCommand::Pause)));
                assert_eq!((now, sent), (500, TRIES as usize + 1));
                return;
            }
        }
        panic!("never given up");
    }

    #[test]
    fn venting_waits_for_nothing_and_nothing_is_repeated_after_it() {
        let mut asks = Requests::default();
        asks.ask(run("all"));
        asks.due(0);
        asks.ask(LinkCommand::Resume);
        asks.ask(LinkCommand::Vent);
        let sent: Vec<_> = (1..5000).flat_map(|now| requests(&asks.due(now).0)).collect();
        assert_eq!(sent.len(), 50);
        assert!(sent.iter().all(|request| request.command == LinkCommand::Vent));
    }

    #[test]
    fn a_pulled_cable_forgets_all_but_venting() {
        let mut asks = Requests::default();
        asks.ask(run("all"));
        asks.due(0);
        asks.ask(LinkCommand::Pause);
        assert_eq!(asks.cut(), [run("all"), LinkCommand::Pause]);
        assert!(asks.idle());
        asks.ask(LinkCommand::Vent);
        asks.due(1);
        asks.ask(LinkCommand::Identify);
        assert_eq!(asks.cut(), [LinkCommand::Identify]);
        assert_eq!(requests(&asks.due(9).0)[0].command, LinkCommand::Vent);
    }
}
