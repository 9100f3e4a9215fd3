//! What happened beside the telemetry, in the words of the recording's last column.

use super::requests::Outcome;
use core::fmt;
use fixed::types::I8F24;
use model_core::actuation::Segment;
use model_core::protocol::{IdentifiedSegment, Identity, LinkCommand};
use model_core::units::{Bend, Pressure};

/// Between two events of one row.
const BETWEEN: &str = " | ";
/// Before the name of a sequence that was started.
const RUNS: &str = "taken: run ";
/// Before the reason for a lost link.
const LOST: &str = "link lost: ";
/// The device has started anew.
const RESTARTED: &str = "device started anew";

/// One event.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The device said who it is.
    Device(Identity),
    /// The device said what it has identified.
    Identified([IdentifiedSegment; 3]),
    /// What became of a request.
    Request(Outcome),
    /// A request was not sent, because the link was lost.
    Dropped(LinkCommand),
    /// The link is lost.
    Lost(String),
    /// Frames come again.
    Back {
        /// How long none came, ms.
        after_ms: u64,
        /// Telemetry frames that are missing.
        lost: u32,
    },
    /// The device has started anew.
    Restarted,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Device(identity) => {
                let [a, b, c] = identity.serial;
                write!(f, "device: firmware {} serial {a:08x}{b:08x}{c:08x}", identity.firmware)?;
                write!(f, " started by {:?}", identity.reset_cause)
            }
            Self::Identified(segments) => {
                let ready = Segment::ALL.into_iter().zip(segments).filter(|(_, own)| own.ready);
                let each: Vec<_> = ready.map(|(segment, own)| coefficients(segment, own.coefficients)).collect();
                write!(f, "identified: {}", if each.is_empty() { "nothing yet".into() } else { each.join("; ") })
            }
            Self::Request(Outcome::Taken(command)) => write!(f, "taken: {}", name(command)),
            Self::Request(Outcome::Refused(command, reason)) => write!(f, "refused: {} ({reason:?})", name(command)),
            Self::Request(Outcome::Unanswered(command)) => write!(f, "no answer: {}", name(command)),
            Self::Dropped(command) => write!(f, "not sent: {}", name(command)),
            Self::Lost(why) => write!(f, "{LOST}{why}"),
            Self::Back { after_ms, lost } => {
                let seconds = *after_ms as f64 / 1000.0;
                write!(f, "link back after {seconds:.2} s: {lost} frames lost")
            }
            Self::Restarted => f.write_str(RESTARTED),
        }
    }
}

/// A row's text for its events.
#[must_use]
pub fn joined(events: &[Event]) -> String {
    events.iter().map(Event::to_string).collect::<Vec<_>>().join(BETWEEN)
}

/// The events of a row's text.
pub fn split(text: &str) -> impl Iterator<Item = &str> {
    text.split(BETWEEN).filter(|event| !event.is_empty())
}

/// The sequence that a row's text says was started.
#[must_use]
pub fn started(text: &str) -> Option<&str> {
    split(text).filter_map(|event| event.strip_prefix(RUNS)).last()
}

/// Whether an event of a row's text is a lost link.
#[must_use]
pub fn is_gap(event: &str) -> bool {
    event.starts_with(LOST)
}

/// Whether an event of a row's text is a start of the device.
#[must_use]
pub fn is_restart(event: &str) -> bool {
    event == RESTARTED
}

/// k, c1, c2 in kPa; of 2^-24 kPa.
#[must_use]
pub fn coefficients_kpa(bits: [i32; 3]) -> [f64; 3] {
    bits.map(|bits| I8F24::from_bits(bits).to_num())
}

/// A segment's coefficients in words; of 2^-24 kPa.
fn coefficients(segment: Segment, bits: [i32; 3]) -> String {
    let [k, c1, c2] = coefficients_kpa(bits);
    format!("{} k {k:.3} c1 {c1:.3} c2 {c2:.3} kPa", segment.name())
}

/// A request in words.
#[must_use]
pub fn name(command: &LinkCommand) -> String {
    let three = |values: [f64; 3], unit| {
        let [p, m, d] = values;
        format!("{p:.1}/{m:.1}/{d:.1} {unit}")
    };
    match command {
        LinkCommand::Run(sequence) => format!("run {sequence}"),
        LinkCommand::Pause => "pause".into(),
        LinkCommand::Resume => "resume".into(),
        LinkCommand::Vent => "vent".into(),
        LinkCommand::Setpoints(bits) => {
            format!("setpoints {}", three(bits.map(|bits| Pressure::from_bits(bits).to_f64()), "kPa"))
        }
        LinkCommand::Bends(bits) => format!("bends {}", three(bits.map(|bits| Bend::from_bits(bits).to_f64()), "deg")),
        LinkCommand::ZeroSensors => "zero sensors".into(),
        LinkCommand::Calibrate { segment, k, c1, c2 } => {
            format!("calibrate {}", coefficients(*segment, [*k, *c1, *c2]))
        }
        LinkCommand::Identify => "identify".into(),
        LinkCommand::ClearFault => "clear fault".into(),
        LinkCommand::Beat => "beat".into(),
        LinkCommand::Identification => "identification".into(),
        LinkCommand::AdoptIdentified => "adopt identified".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::run;
    use super::*;
    use model_core::protocol::Reason;

    #[test]
    fn a_started_sequence_reads_back_from_the_rows_text() {
        let taken = Event::Request(Outcome::Taken(run("grasp")));
        let text = joined(&[Event::Lost("gone".into()), taken.clone(), Event::Restarted]);
        assert_eq!(text, "link lost: gone | taken: run grasp | device started anew");
        assert_eq!(started(&text), Some("grasp"));
        assert_eq!(split(&text).count(), 3);
        let refused = Event::Request(Outcome::Refused(run("grasp"), Reason::Faulted));
        assert_eq!(started(&joined(&[refused])), None);
        assert_eq!(split("").count(), 0);
    }

    #[test]
    fn quantities_are_told_in_their_units() {
        assert_eq!(name(&LinkCommand::Setpoints([60 << 16, 1 << 15, 0])), "setpoints 60.0/0.5/0.0 kPa");
        assert_eq!(name(&LinkCommand::Bends([45 << 16, 0, 0])), "bends 45.0/0.0/0.0 deg");
    }
}
