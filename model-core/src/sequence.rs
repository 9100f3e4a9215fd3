//! Rehabilitation sequences: `const` tables of steps, checked when they are compiled.

use crate::actuation::PerSegment;
use crate::units::{Bend, Millis, Pressure};

/// What a step asks of the three segments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Gauge pressure of each chamber.
    Pressure(PerSegment<Pressure>),
    /// Bend of each segment; the controller turns it into pressure by its calibration.
    Bend(PerSegment<Bend>),
}

/// One step: go to the target in `ramp`, stay there for `hold`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Where to.
    pub target: Target,
    /// Time of the straight line from the last step's target (zero: a step change).
    pub ramp: Millis,
    /// Time at the target after the ramp.
    pub hold: Millis,
}

/// A named table of steps, run `repeats` times; afterwards the finger vents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// The name on the command line and in the protocol.
    pub name: &'static str,
    /// One line for people.
    pub description: &'static str,
    /// The steps, in order.
    pub steps: &'static [Step],
    /// How often the steps are run, at least once.
    pub repeats: u16,
}
