//! What host and device say to each other.
//!
//! Pressures are in 2^-16 kPa, bends in 2^-16 degree, coefficients in 2^-24 kPa, as [`crate::units`] keep them.

use crate::actuation::{Actuation, Passage, Segment};
use crate::controller::{Fault, Mode, Outputs, Rejection};
use crate::identification::Identified;
use crate::sequence::MAX_NAME_BYTES;
use crate::units::{Bend, Pressure};
use fixed::types::I8F24;
use serde::{Deserialize, Serialize};

/// A sequence's name.
pub type SequenceName = heapless::String<MAX_NAME_BYTES>;

/// Host to device: asks for something; the answer carries the same `id`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// Chosen by the host.
    pub id: u16,
    /// What it asks for.
    pub command: LinkCommand,
}

/// What a host asks for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LinkCommand {
    /// Runs a built-in sequence from its start.
    Run(SequenceName),
    /// Holds the running sequence where it is.
    Pause,
    /// Goes on after a pause.
    Resume,
    /// Vents, and ends whatever runs. Always taken.
    Vent,
    /// Goes to these gauge pressures at once (2^-16 kPa, 0..=150 kPa) and holds them.
    Setpoints([i32; 3]),
    /// Takes what the sensors read now, vented, as zero.
    ZeroSensors,
    /// Uses these coefficients (2^-24 kPa) for one segment from now on.
    Calibrate {
        /// Whose.
        segment: Segment,
        /// Linear bending stiffness, 0..=60 kPa.
        k: i32,
        /// First Yeoh coefficient, 5..=40 kPa.
        c1: i32,
        /// Second Yeoh coefficient, 0..=2 kPa.
        c2: i32,
    },
    /// Asks who the device is; answered with [`Report::Identity`].
    Identify,
    /// Clears a latched fault whose cause is gone.
    ClearFault,
    /// Says that the host is there, and nothing else.
    Beat,
    /// Goes to these bends of the segments at once (2^-16 degree, 0..=110 degrees) and holds them.
    Bends([i32; 3]),
    /// Asks for what has been identified; answered with [`Report::Identification`].
    Identification,
    /// Uses the identified coefficients from now on.
    AdoptIdentified,
}

/// Device to host.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Report {
    /// A hundred times a second.
    Telemetry(Telemetry),
    /// The request with this id was taken.
    Ack {
        /// The request's.
        id: u16,
    },
    /// It was not taken, and nothing changed.
    Nack {
        /// The request's.
        id: u16,
        /// Why.
        reason: Reason,
    },
    /// Answer to [`LinkCommand::Identify`].
    Identity(Identity),
    /// Answer to [`LinkCommand::Identification`].
    Identification {
        /// The request's.
        id: u16,
        /// Proximal, middle, distal.
        segments: [IdentifiedSegment; 3],
    },
}

/// What has been identified of a segment since its coefficients were taken into use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct IdentifiedSegment {
    /// k, c1, c2, 2^-24 kPa.
    pub coefficients: [i32; 3],
    /// Root mean square of the residual as pressure, 2^-16 kPa.
    pub residual_pressure: i32,
    /// The same as bend, 2^-16 degree.
    pub residual_bend: i32,
    /// Points taken.
    pub points: u16,
    /// They reach far enough and fit well enough to be adopted.
    pub ready: bool,
}

impl From<Identified> for IdentifiedSegment {
    fn from(identified: Identified) -> Self {
        let coefficients = identified.coefficients;
        Self {
            coefficients: [coefficients.k(), coefficients.c1(), coefficients.c2()].map(I8F24::to_bits),
            residual_pressure: identified.residual_pressure.to_bits(),
            residual_bend: identified.residual_bend.to_bits(),
            points: identified.points,
            ready: identified.ready,
        }
    }
}

/// Who the device is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// The request's.
    pub id: u16,
    /// [`super::VERSION`].
    pub protocol: u8,
    /// The firmware's version.
    pub firmware: heapless::String<16>,
    /// The chip's unique number.
    pub serial: [u32; 3],
    /// Why the device last started.
    pub reset_cause: ResetCause,
    /// k, c1, c2 in use for each segment, 2^-24 kPa.
    pub coefficients: [[i32; 3]; 3],
    /// What the pressure sensor reads at atmosphere, 2^-16 kPa.
    pub pressure_zero: i32,
    /// What the bend sensor reads at rest, 2^-16 degree.
    pub bend_zero: i32,
    /// Number of built-in sequences.
    pub sequences: u8,
}

/// Why the device started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// Power came.
    PowerOn,
    /// Power sagged and came back.
    Brownout,
    /// The reset button or the probe.
    Pin,
    /// The firmware restarted itself after a panic.
    Software,
    /// The watchdog was not fed.
    Watchdog,
    /// None of these.
    Other,
}

/// Why a request was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reason {
    /// No built-in sequence has this name.
    UnknownSequence,
    /// A fault is latched: clear it first.
    Faulted,
    /// A setpoint lies outside 0..=150 kPa or 0..=110 degrees.
    SetpointOutOfLimits,
    /// A coefficient lies outside its range.
    CoefficientOutOfLimits,
    /// No sequence runs.
    NotRunning,
    /// No sequence is paused.
    NotPaused,
    /// The finger is not vented.
    NotVented,
    /// The fault's cause is still there.
    CauseStillPresent,
    /// No fault is latched.
    NoFault,
    /// A sensor is too far off its zero, or fails.
    ZeroOutOfLimits,
    /// Taken, but the flash did not store it: it holds until the next restart.
    StorageFailed,
    /// The power-on self test runs; wait for its end.
    SelfTesting,
    /// No segment has identified coefficients to offer.
    NothingIdentified,
}

impl From<Rejection> for Reason {
    fn from(rejection: Rejection) -> Self {
        match rejection {
            Rejection::Faulted => Self::Faulted,
            Rejection::SetpointOutOfLimits => Self::SetpointOutOfLimits,
            Rejection::CauseStillPresent => Self::CauseStillPresent,
            Rejection::NoFault => Self::NoFault,
            Rejection::NotRunning => Self::NotRunning,
            Rejection::NotPaused => Self::NotPaused,
            Rejection::NotVented => Self::NotVented,
            Rejection::ZeroOutOfLimits => Self::ZeroOutOfLimits,
            Rejection::SelfTesting => Self::SelfTesting,
            Rejection::NothingIdentified => Self::NothingIdentified,
        }
    }
}

/// What the device is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LinkMode {
    /// Vented and waiting.
    Vented,
    /// The power-on self test runs.
    SelfTest,
    /// Running a sequence.
    Running,
    /// Holding setpoints.
    Holding,
    /// A sequence is paused.
    Paused,
    /// Vented by the fault with this code ([`crate::controller::Fault::code`]).
    Faulted(u8),
}

impl From<Mode> for LinkMode {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Vented => Self::Vented,
            Mode::SelfTest => Self::SelfTest,
            Mode::Running => Self::Running,
            Mode::Holding => Self::Holding,
            Mode::Paused => Self::Paused,
            Mode::Faulted(fault) => Self::Faulted(fault.code()),
        }
    }
}

impl LinkMode {
    /// The mode that it stands for; none when no fault of this version has the code.
    #[must_use]
    pub fn mode(self) -> Option<Mode> {
        Some(match self {
            Self::Vented => Mode::Vented,
            Self::SelfTest => Mode::SelfTest,
            Self::Running => Mode::Running,
            Self::Holding => Mode::Holding,
            Self::Paused => Mode::Paused,
            Self::Faulted(code) => Mode::Faulted(Fault::from_code(code)?),
        })
    }
}

/// The state of one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Telemetry {
    /// Time of the sensors' samples, ms since start.
    pub tick: u32,
    /// What the device is doing.
    pub mode: LinkMode,
    /// Every latched fault: the bit with the number of its code ([`crate::supervisor::fault::FaultSet`]).
    pub faults: u64,
    /// The most urgent one's priority: 0 no fault, 1 low, 2 medium, 3 high.
    pub priority: u8,
    /// Reference of each chamber, 2^-16 kPa.
    pub setpoints: [i32; 3],
    /// Estimated pressure of each chamber, 2^-16 kPa.
    pub estimates: [i32; 3],
    /// Manifold's pressure, 2^-16 kPa; none while the sensor fails.
    pub manifold: Option<i32>,
    /// Bend of the finger, 2^-16 degree; none while the sensor fails.
    pub bend: Option<i32>,
    /// [`outputs_of`] the actuation.
    pub outputs: u8,
    /// Index of the sequence's step.
    pub step: u16,
    /// Repeat of the sequence.
    pub repeat: u16,
    /// The reference rests at a target.
    pub holding: bool,
    /// Fingertip in micrometres: x along the straight finger, y to where it bends. From the estimated pressures.
    pub fingertip_um: [i32; 2],
    /// Direction of the fingertip, thousandths of a degree.
    pub fingertip_millideg: i32,
    /// Driving force, estimated from the pressures, mN.
    pub force_mn: i32,
    /// Ticks that started late, since start.
    pub overruns: u16,
    /// Frames that were dropped, since start.
    pub dropped_frames: u16,
    /// This control tick, core clock cycles, interrupts in between included.
    pub tick_cycles: u32,
    /// The longest control tick so far, core clock cycles.
    pub worst_tick_cycles: u32,
}

impl Telemetry {
    /// What the controller's outputs say; time, fingertip, force and counters are for the caller to add, and zero here.
    #[must_use]
    pub fn of(outputs: &Outputs) -> Self {
        Self {
            tick: 0,
            mode: outputs.mode.into(),
            faults: outputs.faults.bits(),
            priority: outputs.faults.priority().map_or(0, |priority| priority as u8 + 1),
            setpoints: outputs.setpoints.map(Pressure::to_bits),
            estimates: outputs.estimates.map(Pressure::to_bits),
            manifold: outputs.manifold.valid().map(Pressure::to_bits),
            bend: outputs.bend.valid().map(Bend::to_bits),
            outputs: outputs_of(&outputs.actuation),
            step: outputs.step,
            repeat: outputs.repeat,
            holding: outputs.holding,
            fingertip_um: [0; 2],
            fingertip_millideg: 0,
            force_mn: 0,
            overruns: 0,
            dropped_frames: 0,
            tick_cycles: 0,
            worst_tick_cycles: 0,
        }
    }
}

/// One bit an output, set when its coil has current: pump, dump valve, proximal, middle and distal valve from bit 0 on.
/// The valves are normally open, so a set bit is a closed valve, and zero is the safe state.
#[must_use]
pub fn outputs_of(actuation: &Actuation) -> u8 {
    let closed = |passage: Passage| u8::from(passage == Passage::Closed);
    let [p, m, d] = actuation.segments.map(closed);
    u8::from(actuation.pump) | closed(actuation.dump) << 1 | p << 2 | m << 3 | d << 4
}

/// The reverse of [`outputs_of`]; further bits do not count.
#[must_use]
pub fn actuation_of(outputs: u8) -> Actuation {
    let passage = |bit: u8| if outputs >> bit & 1 == 1 { Passage::Closed } else { Passage::Open };
    Actuation { pump: outputs & 1 == 1, dump: passage(1), segments: [passage(2), passage(3), passage(4)] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_and_fault_comes_back_and_no_other_code_is_one() {
        let known: Vec<u8> = (0..=u8::MAX).filter(|&code| Fault::from_code(code).is_some()).collect();
        assert_eq!(known, [0..9, 16..26, 32..45, 48..50, 56..63].into_iter().flatten().collect::<Vec<_>>());
        let faults = known.into_iter().map(LinkMode::Faulted);
        let plain = [LinkMode::Vented, LinkMode::SelfTest, LinkMode::Running, LinkMode::Holding, LinkMode::Paused];
        for told in plain.into_iter().chain(faults) {
            assert_eq!(told.mode().map(LinkMode::from), Some(told));
        }
        assert_eq!(LinkMode::Faulted(255).mode(), None);
    }

    #[test]
    fn outputs_are_one_bit_each_and_zero_is_safe() {
        assert_eq!(outputs_of(&Actuation::SAFE), 0);
        for outputs in 0..32 {
            assert_eq!(outputs_of(&actuation_of(outputs)), outputs);
        }
        assert_eq!(actuation_of(0b11110), Actuation::HOLD);
    }
}
