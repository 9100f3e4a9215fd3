//! The controller: commands and sensor readings in, actuation and telemetry out, once a tick.

use crate::actuation::{Actuation, PerSegment};
use crate::sequence::Sequence;
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

/// Everything the controller sees in one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
}

/// What a user or a host asks for.
#[derive(Clone, Copy, Debug)]
pub enum Command {
    /// Runs a sequence from its start.
    Run(&'static Sequence),
    /// Goes to these gauge pressures at once, and holds them.
    Setpoints(PerSegment<Pressure>),
    /// Vents the finger and ends whatever runs.
    Vent,
    /// Clears a latched fault whose cause is gone.
    ClearFault,
}

/// Why a command was not taken; nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// A fault is latched: clear it first.
    Faulted,
    /// A setpoint lies outside 0..=150 kPa.
    SetpointOutOfLimits,
    /// The fault's cause is still there.
    CauseStillPresent,
    /// No fault is latched.
    NoFault,
}

/// Why the supervisor vented the finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The manifold's pressure is above the limit.
    OverPressure,
    /// The pressure switch closed.
    OverPressureSwitch,
    /// The pressure sensor is below its electrical range.
    PressureSensorBelowRange,
    /// The pressure sensor is above its electrical range.
    PressureSensorAboveRange,
    /// The emergency stop was pressed.
    EmergencyStop,
}

/// What the controller is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Vented and waiting.
    Vented,
    /// Running a sequence.
    Running,
    /// Holding setpoints given by hand.
    Holding,
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
    /// The reference each chamber should have now (ramps included); zero when vented.
    pub setpoints: PerSegment<Pressure>,
    /// The estimated gauge pressure of each chamber.
    pub estimates: PerSegment<Pressure>,
    /// Index of the running step within the sequence; zero otherwise.
    pub step: u16,
    /// Which repeat of the sequence runs, from zero.
    pub repeat: u16,
    /// True while the reference rests at a step's target (its hold time), false during ramps and when vented.
    pub holding: bool,
}

/// The whole of the controller's state.
#[derive(Clone, Debug)]
pub struct Controller {
    coefficients: Coefficients,
}

impl Controller {
    /// Starts vented.
    #[must_use]
    pub const fn new(coefficients: Coefficients) -> Self {
        Self { coefficients }
    }

    /// The calibration in use.
    #[must_use]
    pub const fn coefficients(&self) -> Coefficients {
        self.coefficients
    }

    /// Takes a command.
    ///
    /// # Errors
    /// Says why the command was not taken; nothing changes then.
    pub fn command(&mut self, command: Command) -> Result<(), Rejection> {
        let _ = command;
        Ok(())
    }

    /// One tick of one millisecond.
    pub fn step(&mut self, inputs: &Inputs) -> Outputs {
        let _ = inputs;
        Outputs {
            actuation: Actuation::SAFE,
            mode: Mode::Vented,
            setpoints: [Pressure::ZERO; 3],
            estimates: [Pressure::ZERO; 3],
            step: 0,
            repeat: 0,
            holding: false,
        }
    }
}
