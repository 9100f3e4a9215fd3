//! What goes into the controller and what comes out of it.

use crate::actuation::{Actuation, PerSegment, Segment};
use crate::sequence::Sequence;
use crate::supervisor::fault::{Fault, FaultSet};
use crate::units::{Bend, Coefficients, Millis, Pressure};

/// What a sensor said this tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading<T> {
    /// A plausible value.
    Valid(T),
    /// Electrically below the sensor's range: a broken wire or no supply.
    BelowRange,
    /// Electrically above the sensor's range: a short, or more than the sensor can tell.
    AboveRange,
}

impl<T> Reading<T> {
    /// Changes a plausible value.
    #[must_use]
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> Reading<U> {
        match self {
            Self::Valid(value) => Reading::Valid(change(value)),
            Self::BelowRange => Reading::BelowRange,
            Self::AboveRange => Reading::AboveRange,
        }
    }

    /// The plausible value.
    #[must_use]
    pub fn valid(self) -> Option<T> {
        match self {
            Self::Valid(value) => Some(value),
            Self::BelowRange | Self::AboveRange => None,
        }
    }
}

/// Everything the controller sees in one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a line or an event of its own; together they are no state")]
pub struct Inputs {
    /// Time since start.
    pub now: Millis,
    /// Gauge pressure of the manifold (ISE30A, analogue).
    pub manifold: Reading<Pressure>,
    /// Bend of the whole finger (BF350): the sum of the three segments' bends.
    pub bend: Reading<Bend>,
    /// The ISE30A's switch output: true above its over-pressure threshold.
    pub over_pressure_switch: bool,
    /// True while the emergency stop is pressed or its loop is broken.
    pub emergency_stop: bool,
    /// A valid frame came from the host since the last tick. What a host drives by hand ends when it is silent.
    pub host_heard: bool,
    /// This tick came late, or a sample before it was lost.
    pub overrun: bool,
}

#[cfg(test)]
impl Inputs {
    /// A vented finger at rest, everything right.
    pub(crate) const CALM: Self = Self {
        now: Millis::ZERO,
        manifold: Reading::Valid(Pressure::ZERO),
        bend: Reading::Valid(Bend::ZERO),
        over_pressure_switch: false,
        emergency_stop: false,
        host_heard: true,
        overrun: false,
    };
}

/// What a user or a host asks for.
#[derive(Clone, Copy, Debug)]
pub enum Command {
    /// Runs a sequence from its start.
    Run(&'static Sequence),
    /// Goes to these gauge pressures at once, and holds them.
    Setpoints(PerSegment<Pressure>),
    /// Goes to these bends of the segments at once, and holds them; 0..=110 degrees each.
    Bends(PerSegment<Bend>),
    /// Vents the finger and ends whatever runs.
    Vent,
    /// Holds the running sequence where it is: its time stands still, its setpoints are kept.
    Pause,
    /// Goes on after a pause.
    Resume,
    /// Takes what the sensors read now as zero; only vented, and only within [`ZERO_LIMIT`](super::ZERO_LIMIT)
    /// and [`BEND_ZERO_LIMIT`](super::BEND_ZERO_LIMIT).
    ZeroSensors,
    /// Uses these coefficients for this segment; only vented.
    Calibrate(Segment, Coefficients),
    /// Uses the coefficients identified, of every segment that has some to offer; only vented.
    AdoptIdentified,
    /// Clears a latched fault whose cause is gone.
    ClearFault,
}

/// Why a command was not taken; nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// A fault is latched: clear it first.
    Faulted,
    /// A setpoint lies outside 0..=150 kPa or 0..=110 degrees.
    SetpointOutOfLimits,
    /// The fault's cause is still there.
    CauseStillPresent,
    /// No fault is latched.
    NoFault,
    /// No sequence runs.
    NotRunning,
    /// No sequence is paused.
    NotPaused,
    /// The finger is not vented.
    NotVented,
    /// A sensor is too far off its zero, or fails.
    ZeroOutOfLimits,
    /// The power-on self test runs; wait for its end.
    SelfTesting,
    /// No segment has identified coefficients to offer: run the sequence `calibrate` first.
    NothingIdentified,
}

/// What the controller is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Vented and waiting.
    Vented,
    /// The power-on self test runs.
    SelfTest,
    /// Running a sequence.
    Running,
    /// Holding setpoints given by hand.
    Holding,
    /// A sequence is paused.
    Paused,
    /// A fault is latched; vented.
    Faulted(Fault),
}

/// One tick's results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outputs {
    /// To the pins.
    pub actuation: Actuation,
    /// What the controller is doing.
    pub mode: Mode,
    /// Every fault that is latched, those that do not vent too.
    pub faults: FaultSet,
    /// The reference each chamber should have now (ramps included); zero when vented.
    pub setpoints: PerSegment<Pressure>,
    /// The estimated gauge pressure of each chamber.
    pub estimates: PerSegment<Pressure>,
    /// Index of the running step within the sequence; zero otherwise.
    pub step: u16,
    /// Which repeat of the sequence runs, from zero.
    pub repeat: u16,
    /// True while the reference rests at a step's target (its hold time), false during ramps, pauses and when vented.
    pub holding: bool,
    /// The manifold's pressure, its zero taken off.
    pub manifold: Reading<Pressure>,
    /// The finger's bend, its zero taken off.
    pub bend: Reading<Bend>,
}
