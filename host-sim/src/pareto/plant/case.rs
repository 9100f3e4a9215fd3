//! What the integrators are measured on: a recording, or a stiff case made for it.

use super::reference::{self, Instant};
use crate::plant::{FaultKind, InjectedFault, Method, Plant, PlantParameters, Scene};
use crate::simulate::{Program, Run};
use anyhow::{Context, Result};
use model_core::actuation::{Actuation, Passage, Segment};
use model_core::sequence::library;

/// Commands, a plant, and what the reference makes of them.
#[derive(Clone, Debug)]
pub struct Case {
    /// What it is.
    pub name: &'static str,
    /// The plant; its integration is replaced by what is measured.
    pub parameters: PlantParameters,
    /// What breaks.
    pub faults: Vec<InjectedFault>,
    /// Gauge pressures at the start, kPa, manifold first; the finger is straight.
    pub start_kpa: [f64; 4],
    /// One command a millisecond.
    pub commands: Vec<Actuation>,
    /// The reference after each.
    pub reference: Vec<Instant>,
}

/// How a plant fared on a case.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Largest error of a chamber's pressure at any millisecond, kPa; infinite when it is no number any more.
    pub max_error_kpa: f64,
    /// Root of the mean square of the same.
    pub rms_error_kpa: f64,
    /// Largest in the last 50 ms, kPa.
    pub late_error_kpa: f64,
    /// Largest error of a segment's bend, degrees.
    pub max_bend_error_deg: f64,
    /// Largest error of all the air, NL.
    pub max_content_error_nl: f64,
    /// Evaluations of the flows for each tick.
    pub evaluations_per_tick: f64,
}

impl Case {
    fn new(
        name: &'static str,
        parameters: PlantParameters,
        faults: Vec<InjectedFault>,
        start_kpa: [f64; 4],
        commands: Vec<Actuation>,
    ) -> Result<Self> {
        let reference = reference::solve(&parameters, &faults, start_kpa, &commands, reference::TOLERANCE)
            .with_context(|| format!("case {name:?}"))?;
        Ok(Self { name, parameters, faults, start_kpa, commands, reference })
    }

    /// The plant at the case's start.
    #[must_use]
    pub fn plant(&self, method: Method, sub_steps: u32, scene: Scene, seed: u64) -> Plant {
        let mut parameters = self.parameters.clone();
        parameters.integration.method = method;
        parameters.integration.sub_steps = sub_steps;
        let [manifold, chambers @ ..] = self.start_kpa;
        Plant::new(parameters, scene.with_faults(self.faults.iter().copied()), seed).starting_at(manifold, chambers)
    }

    /// Replays the commands on a plant and compares it with the reference at every millisecond.
    #[must_use]
    pub fn replay(&self, mut plant: Plant) -> Outcome {
        let mut outcome = Outcome {
            max_error_kpa: 0.0,
            rms_error_kpa: 0.0,
            late_error_kpa: 0.0,
            max_bend_error_deg: 0.0,
            max_content_error_nl: 0.0,
            evaluations_per_tick: 0.0,
        };
        // A NaN must not hide behind a comparison.
        let off = |a: f64, b: f64| if (a - b).is_finite() { (a - b).abs() } else { f64::INFINITY };
        let ticks = self.commands.len();
        let mut squares = 0.0;
        for (tick, (command, exact)) in self.commands.iter().zip(&self.reference).enumerate() {
            plant.step(command);
            let truth = plant.truth();
            for segment in 0..3 {
                let error = off(truth.chambers_kpa[segment], exact.chambers_kpa[segment]);
                squares += error * error;
                outcome.max_error_kpa = outcome.max_error_kpa.max(error);
                if tick + 50 >= ticks {
                    outcome.late_error_kpa = outcome.late_error_kpa.max(error);
                }
                let bend = off(truth.bends_deg[segment], exact.bends_deg[segment]);
                outcome.max_bend_error_deg = outcome.max_bend_error_deg.max(bend);
            }
            let content = off(truth.content_nl, exact.content_nl);
            outcome.max_content_error_nl = outcome.max_content_error_nl.max(content);
        }
        outcome.rms_error_kpa = (squares / (3 * ticks) as f64).sqrt();
        outcome.evaluations_per_tick = plant.counts().flow_evaluations as f64 / ticks as f64;
        outcome
    }
}

/// The default scene: what the controller does to the default plant in the sequence `reconfigure`, seed 1.
///
/// # Errors
/// When the controller does not take the sequence, or the reference fails.
pub fn default_scene() -> Result<Case> {
    let sequence = library::find("reconfigure").context("no sequence is named \"reconfigure\"")?;
    let trace = Run::new(Program::Sequence(sequence), 1).simulate(|_, _| {})?;
    let commands = trace.samples.iter().map(|sample| sample.actuation).collect();
    Case::new("default scene", PlantParameters::default(), Vec::new(), [0.0; 4], commands)
}

const FILL: Actuation = Actuation { pump: true, dump: Passage::Closed, segments: [Passage::Open; 3] };
const FILL_ONE: Actuation = Actuation { segments: [Passage::Open, Passage::Closed, Passage::Closed], ..FILL };
const EQUALISE: Actuation = Actuation { pump: false, ..FILL };

fn program(steps: &[(Actuation, usize)]) -> Vec<Actuation> {
    steps.iter().flat_map(|&(command, ticks)| core::iter::repeat_n(command, ticks)).collect()
}

/// The stiff cases.
///
/// # Errors
/// When the reference fails.
pub fn stiff_cases() -> Result<Vec<Case>> {
    let default = PlantParameters::default();
    let mut tiny = PlantParameters::default();
    tiny.gas.manifold_ml = 0.2;
    let leak = FaultKind::ChamberLeak { segment: Segment::Middle, conductance_nl_per_s_bar: 0.5 };
    Ok(vec![
        // Everything is open for the dead time first. The finger then settles, closed; the valves open onto the manifold, and
        // once more when all is equal.
        Case::new(
            "valves opened between near-equal pressures",
            default.clone(),
            Vec::new(),
            [60.0, 60.0, 60.05, 59.95],
            program(&[(Actuation::HOLD, 400), (EQUALISE, 600), (Actuation::HOLD, 50), (EQUALISE, 300)]),
        )?,
        Case::new(
            "near-empty chambers, one in vacuum",
            default.clone(),
            Vec::new(),
            [0.0, -60.0, 0.001, 0.5],
            program(&[(Actuation::SAFE, 400), (FILL, 15), (EQUALISE, 300), (Actuation::SAFE, 1500)]),
        )?,
        Case::new(
            "all valves laminar at once",
            default.clone(),
            Vec::new(),
            [0.08, 0.05, -0.05, 0.02],
            program(&[(Actuation::SAFE, 600)]),
        )?,
        Case::new(
            "manifold of 0.2 mL",
            tiny,
            Vec::new(),
            [0.0; 4],
            program(&[
                (FILL_ONE, 300),
                (FILL, 400),
                (Actuation::HOLD, 50),
                (EQUALISE, 200),
                (FILL, 500),
                (Actuation::SAFE, 1500),
            ]),
        )?,
        Case::new(
            "burst chamber while filling",
            default,
            vec![InjectedFault::lasting(leak, 600)],
            [0.0; 4],
            program(&[(FILL, 1000), (EQUALISE, 300)]),
        )?,
    ])
}

/// A closed system in which air moves: the largest change of all its air, NL. Nothing passes pump, dump valve or leak.
#[must_use]
pub fn closed_drift_nl(method: Method, sub_steps: u32) -> f64 {
    let mut parameters = PlantParameters::default();
    parameters.integration.method = method;
    parameters.integration.sub_steps = sub_steps;
    let mut plant = Plant::new(parameters, Scene::default(), 1).starting_at(0.0, [0.0; 3]);
    for _ in 0..400 {
        plant.step(&FILL_ONE);
    }
    // Until the actuators have followed and the rotor rests.
    for _ in 0..300 {
        plant.step(&EQUALISE);
    }
    let start = plant.truth().content_nl;
    let mut drift = 0.0_f64;
    for tick in 0..3000 {
        // Valves that keep switching keep the air moving.
        let command = if tick % 200 < 100 { Actuation { segments: FILL_ONE.segments, ..EQUALISE } } else { EQUALISE };
        plant.step(&command);
        let off = plant.truth().content_nl - start;
        drift = if off.is_finite() { drift.max(off.abs()) } else { f64::INFINITY };
    }
    drift
}
