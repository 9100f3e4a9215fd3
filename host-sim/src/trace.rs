//! What a simulated run leaves behind: one sample a millisecond, truth beside what the controller believed.

use model_core::actuation::Actuation;
use model_core::controller::Mode;
use model_core::supervisor::fault::FaultSet;

/// One tick of a run.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Time since the run's start.
    pub time_ms: u32,
    /// What the controller did.
    pub actuation: Actuation,
    /// What the controller was doing.
    pub mode: Mode,
    /// Every fault that is latched.
    pub faults: FaultSet,
    /// Index of the sequence's step.
    pub step: u16,
    /// Which repeat of the sequence.
    pub repeat: u16,
    /// The reference rests at a target.
    pub holding: bool,
    /// Reference of each chamber.
    pub setpoints_kpa: [f64; 3],
    /// The controller's estimate of each chamber.
    pub estimates_kpa: [f64; 3],
    /// True gauge pressure of each chamber.
    pub chambers_kpa: [f64; 3],
    /// True gauge pressure of the manifold.
    pub manifold_kpa: f64,
    /// What the pressure sensor read; not a number when it failed.
    pub sensor_kpa: f64,
    /// True bend of each segment.
    pub bends_deg: [f64; 3],
    /// What the flex sensor read, whole finger; not a number when it failed.
    pub bend_sensor_deg: f64,
}

/// A whole run.
#[derive(Clone, Debug)]
pub struct Trace {
    /// The sequence's name, or `setpoints`.
    pub name: String,
    /// One line on it.
    pub description: String,
    /// Seed of the noise.
    pub seed: u64,
    /// Samples, one a millisecond.
    pub samples: Vec<Sample>,
}
