//! The controller's core in closed loop with the plant, one millisecond at a time.

use crate::plant::{Plant, PlantParameters, Scene};
use crate::trace::{Sample, Trace};
use anyhow::{Result, anyhow};
use model_core::actuation::PerSegment;
use model_core::calibration;
use model_core::controller::{Command, Controller, Inputs, Outputs, Rejection};
use model_core::sequence::Sequence;
use model_core::units::{Bend, Pressure};

/// Time before the command, ms: the vented controller trims its sensor's zero.
pub const STANDBY_MS: u32 = 1000;
/// Time for which setpoints given by hand are held, ms.
pub const HOLD_MS: u32 = 6000;
/// Time after the end, ms: the finger is seen to vent.
pub const VENT_MS: u32 = 5000;

/// What a run does.
#[derive(Clone, Copy, Debug)]
pub enum Program {
    /// A sequence from its start to its end.
    Sequence(&'static Sequence),
    /// A step to these setpoints, held for [`HOLD_MS`], then vented.
    Setpoints(PerSegment<Pressure>),
    /// A step to these bends, held for [`HOLD_MS`], then vented.
    Bends(PerSegment<Bend>),
}

impl Program {
    /// The sequence's name, `setpoints` or `bends`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sequence(sequence) => sequence.name,
            Self::Setpoints(_) => "setpoints",
            Self::Bends(_) => "bends",
        }
    }

    /// One line on it.
    #[must_use]
    pub fn description(&self) -> String {
        match self {
            Self::Sequence(sequence) => sequence.description.to_owned(),
            Self::Setpoints(setpoints) => {
                let [p, m, d] = setpoints.map(Pressure::to_f64);
                format!("A step to {p}/{m}/{d} kPa, held for {} s", HOLD_MS / 1000)
            }
            Self::Bends(bends) => {
                let [p, m, d] = bends.map(Bend::to_f64);
                format!("A step to {p}/{m}/{d} degrees, held for {} s", HOLD_MS / 1000)
            }
        }
    }

    /// How long it takes, ms.
    #[must_use]
    pub fn duration_ms(&self) -> u32 {
        match self {
            Self::Sequence(sequence) => sequence.duration().0,
            Self::Setpoints(_) | Self::Bends(_) => HOLD_MS,
        }
    }
}

/// A run: what, on which plant, with which seed.
#[derive(Clone, Debug)]
pub struct Run {
    /// What to do.
    pub program: Program,
    /// The plant.
    pub parameters: PlantParameters,
    /// Which of its parts are modelled, and which faults come.
    pub scene: Scene,
    /// Seed of the sensors' errors.
    pub seed: u64,
}

impl Run {
    /// On the default plant with everything modelled.
    #[must_use]
    pub fn new(program: Program, seed: u64) -> Self {
        Self { program, parameters: PlantParameters::default(), scene: Scene::default(), seed }
    }

    /// Simulates standby, program and venting; `progress` hears milliseconds done and in all.
    ///
    /// # Errors
    /// When the controller does not take the command: setpoints out of limits, or a fault in standby.
    pub fn simulate(&self, mut progress: impl FnMut(u32, u32)) -> Result<Trace> {
        let mut plant = Plant::new(self.parameters.clone(), self.scene.clone(), self.seed);
        let mut controller = Controller::new([calibration::DEFAULT; 3]);
        let end = STANDBY_MS + self.program.duration_ms();
        let total = end + VENT_MS;
        let mut samples = Vec::with_capacity(total as usize);
        for time_ms in 0..total {
            let inputs = plant.inputs();
            if time_ms == STANDBY_MS {
                let command = match self.program {
                    Program::Sequence(sequence) => Command::Run(sequence),
                    Program::Setpoints(setpoints) => Command::Setpoints(setpoints),
                    Program::Bends(bends) => Command::Bends(bends),
                };
                controller.command(command).map_err(rejected)?;
            } else if time_ms == end && matches!(self.program, Program::Setpoints(_) | Program::Bends(_)) {
                controller.command(Command::Vent).map_err(rejected)?;
            }
            let outputs = controller.step(&inputs);
            samples.push(sample(time_ms, &inputs, &outputs, &plant));
            plant.step(&outputs.actuation);
            if time_ms % 100 == 0 {
                progress(time_ms, total);
            }
        }
        progress(total, total);
        Ok(Trace {
            name: self.program.name().to_owned(),
            description: self.program.description(),
            seed: self.seed,
            samples,
        })
    }
}

fn rejected(rejection: Rejection) -> anyhow::Error {
    anyhow!("the controller does not take the command: {rejection:?}")
}

fn sample(time_ms: u32, inputs: &Inputs, outputs: &Outputs, plant: &Plant) -> Sample {
    let truth = plant.truth();
    Sample {
        time_ms,
        actuation: outputs.actuation,
        mode: outputs.mode,
        faults: outputs.faults,
        step: outputs.step,
        repeat: outputs.repeat,
        holding: outputs.holding,
        setpoints_kpa: outputs.setpoints.map(Pressure::to_f64),
        estimates_kpa: outputs.estimates.map(Pressure::to_f64),
        chambers_kpa: truth.chambers_kpa,
        manifold_kpa: truth.manifold_kpa,
        sensor_kpa: inputs.manifold.valid().map_or(f64::NAN, Pressure::to_f64),
        bends_deg: truth.bends_deg,
        bend_sensor_deg: inputs.bend.valid().map_or(f64::NAN, Bend::to_f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::summarise;
    use crate::plant::{FaultKind, InjectedFault};
    use model_core::controller::{Fault, Mode};
    use model_core::sequence::library;

    #[test]
    fn setpoints_are_reached_held_and_vented() {
        let setpoints = [60, 30, 60].map(Pressure::from_kpa);
        let trace = Run::new(Program::Setpoints(setpoints), 1).simulate(|_, _| {}).expect("taken");
        let summary = summarise(&trace);
        assert_eq!(summary.holds_not_reached, 0);
        assert!(summary.hold_mean_abs_error_kpa.is_some_and(|error| error < 2.0), "{summary:?}");
        assert!(summary.vented_residual_kpa < 5.0);
    }

    #[test]
    fn bends_are_reached_and_the_sensor_that_fails_leaves_pressure() {
        let mut run = Run::new(Program::Bends([45, 30, 60].map(Bend::from_deg)), 1);
        let healthy = run.simulate(|_, _| {}).expect("taken");
        run.scene = Scene::default().with_faults([InjectedFault::lasting(FaultKind::BendSensorOpen, 3000)]);
        let failed = run.simulate(|_, _| {}).expect("taken");
        for trace in [healthy, failed] {
            let last = &trace.samples[(STANDBY_MS + HOLD_MS - 100) as usize];
            for (bend, asked) in last.bends_deg.into_iter().zip([45.0, 30.0, 60.0]) {
                assert!((bend - asked).abs() < 2.0, "{bend} where {asked} was asked for");
            }
        }
    }

    #[test]
    fn setpoints_beyond_the_limits_are_not_taken() {
        let setpoints = [151, 0, 0].map(Pressure::from_kpa);
        assert!(Run::new(Program::Setpoints(setpoints), 1).simulate(|_, _| {}).is_err());
    }

    #[test]
    fn a_broken_sensor_wire_or_the_emergency_stop_vents_and_stays_vented() {
        for (kind, fault) in [
            (FaultKind::PressureSensorOpen, Fault::PressureSensorBelowRange),
            (FaultKind::PressureSensorShort, Fault::PressureSensorAboveRange),
            (FaultKind::EmergencyStop, Fault::EmergencyStop),
        ] {
            let mut run = Run::new(Program::Sequence(library::find("all").expect("built in")), 3);
            // In the middle of the hold at 150 kPa.
            run.scene = Scene::default().with_faults([InjectedFault::lasting(kind, 6000)]);
            let trace = run.simulate(|_, _| {}).expect("taken");
            assert!(trace.samples[5990].chambers_kpa.iter().all(|&kpa| kpa > 140.0));
            let faulted = trace.samples[6010..].iter().all(|sample| sample.mode == Mode::Faulted(fault));
            assert!(faulted, "{fault:?}");
            // The plant's own vent time for three chambers is 1.6 s.
            assert!(trace.samples[8500].chambers_kpa.iter().all(|&kpa| kpa < 5.0), "{fault:?}");
        }
    }

    #[test]
    fn a_pump_that_cannot_be_stopped_ends_in_venting_without_over_pressure() {
        let mut run = Run::new(Program::Sequence(library::find("all").expect("built in")), 3);
        run.scene = Scene::default().with_faults([InjectedFault::lasting(FaultKind::PumpStuckOn, 3000)]);
        let trace = run.simulate(|_, _| {}).expect("taken");
        let peak = trace.samples.iter().flat_map(|sample| sample.chambers_kpa).fold(0.0, f64::max);
        assert!(peak < 165.0, "{peak}");
    }
}
