//! The plant's integrators: error against a reference of tight tolerance, and speed.
//!
//! Errors and evaluations are the same on every machine. Speed is wall clock, of one run on one machine: read it as ratios.

pub mod breakdown;
pub mod case;
mod picture;
pub mod reference;
mod table;

pub use picture::picture;
pub use table::{csv, markdown, text};

use crate::plant::{Method, Part, Plant, Scene};
use anyhow::Result;
use breakdown::Breakdown;
use case::Case;
use core::hint::black_box;
use model_core::controller::Reading;
use serde::Serialize;
use std::time::Instant;

/// Largest error of a chamber's pressure that the default may have, kPa.
pub const ERROR_TARGET_KPA: f64 = 0.1;

/// Simulated seconds in a second that are aimed at, on one core.
pub const SPEED_TARGET: f64 = 10_000.0;

/// Below this error at a stiff case's end, kPa, an integrator counts as stable there.
const STABLE_BELOW_KPA: f64 = 1.0;

/// Rounds of a timing.
const REPEATS: usize = 25;

/// Seed of the sensors' errors.
const SEED: u64 = 1;

/// A method with its step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The method.
    pub method: Method,
    /// Steps in a tick; the adaptive method chooses its own.
    pub sub_steps: u32,
}

impl Choice {
    /// The default.
    #[must_use]
    pub fn of_the_plant() -> Self {
        let integration = crate::plant::parameters::IntegrationParameters::default();
        Self { method: integration.method, sub_steps: integration.sub_steps }
    }

    /// Its step or its tolerance.
    #[must_use]
    pub fn step(&self) -> String {
        match self.method {
            Method::Adaptive { tolerance_kpa } => format!("within {tolerance_kpa} kPa"),
            _ => format!("{} ms", 1.0 / f64::from(self.sub_steps)),
        }
    }
}

/// Everything that is measured.
#[must_use]
pub fn choices() -> Vec<Choice> {
    let fixed = |method, steps: &[u32]| steps.iter().map(|&sub_steps| Choice { method, sub_steps }).collect::<Vec<_>>();
    let adaptive = |tolerance_kpa| Choice { method: Method::Adaptive { tolerance_kpa }, sub_steps: 1 };
    let mut all = fixed(Method::Euler, &[1, 2, 5, 10, 20]);
    all.extend(fixed(Method::Heun, &[1, 2, 5, 10]));
    all.extend(fixed(Method::RungeKutta4, &[1, 2, 5]));
    all.extend(fixed(Method::RosenbrockEuler, &[1, 2, 5, 10, 20]));
    all.extend(fixed(Method::LinearlyImplicitMidpoint, &[1, 2, 5, 10]));
    all.extend(fixed(Method::Rosenbrock2, &[1, 2, 5, 10]));
    all.extend([1e-1, 1e-2, 1e-3, 1e-4].map(adaptive));
    all
}

/// How an integrator fared on a stiff case.
#[derive(Clone, Debug, Serialize)]
pub struct StiffRow {
    /// The case.
    pub case: &'static str,
    /// Largest error of a chamber's pressure, kPa; none when it is no number any more.
    pub max_error_kpa: Option<f64>,
    /// Whether it ended within 1 kPa of the reference.
    pub stable: bool,
}

/// An integrator with its step.
#[derive(Clone, Debug, Serialize)]
pub struct IntegratorRow {
    /// Name of the method.
    pub integrator: &'static str,
    /// Step or tolerance.
    pub step: String,
    /// Whether the plant takes it unless told otherwise.
    pub default: bool,
    /// Whether another is at least as fast (fastest round) and as good in the default scene, and better in one.
    pub dominated: bool,
    /// Largest error of a chamber's pressure in the default scene, kPa.
    pub max_error_kpa: f64,
    /// Root of the mean square of the same, kPa.
    pub rms_error_kpa: f64,
    /// Largest error of a segment's bend in the default scene, degrees.
    pub max_bend_error_deg: f64,
    /// Evaluations of the flows for each tick.
    pub evaluations_per_tick: f64,
    /// Simulated seconds in a second of wall clock on one core, sensors and everything: the median of several rounds of one
    /// run on one machine.
    pub simulated_seconds_per_second: f64,
    /// The same of the fastest round: what the core does when nothing else wants it.
    pub fastest_simulated_seconds_per_second: f64,
    /// The stiff cases.
    pub stiff: Vec<StiffRow>,
    /// Change of all the air in a closed system in which it keeps moving, NL.
    pub closed_drift_nl: f64,
}

/// A part of the scene, left out.
#[derive(Clone, Debug, Serialize)]
pub struct SwitchRow {
    /// What is left out.
    pub left_out: &'static str,
    /// Time for a tick over that of the full scene, of the fastest round each.
    pub time_ratio: f64,
    /// Largest error of a chamber's pressure against the fully modelled reference, kPa.
    pub max_error_kpa: f64,
    /// Root of the mean square of the same, kPa.
    pub rms_error_kpa: f64,
    /// Largest error of a segment's bend against it, degrees.
    pub max_bend_error_deg: f64,
    /// Root of the mean square of the pressure reading's difference from the full scene's, kPa.
    pub rms_pressure_reading_kpa: f64,
    /// The same of the bend reading, degrees.
    pub rms_bend_reading_deg: f64,
}

/// All that is measured.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Ticks of 1 ms in the default scene.
    pub ticks: usize,
    /// Tolerance of the reference, relative and absolute.
    pub reference_tolerance: f64,
    /// The integrators, in order of method and step.
    pub integrators: Vec<IntegratorRow>,
    /// The scene's switches with the default integrator.
    pub switches: Vec<SwitchRow>,
    /// Where the default's time goes.
    pub breakdown: Breakdown,
}

/// Scenes with one part left out each, the full one first.
fn scenes() -> Vec<(&'static str, Scene)> {
    let full = Scene::default;
    let out = Part::LeftOut;
    vec![
        ("nothing", full()),
        ("sensor_errors", Scene { sensor_errors: out, ..full() }),
        ("quantisation", Scene { quantisation: out, ..full() }),
        ("sensor_lag", Scene { sensor_lag: out, ..full() }),
        ("actuator_delays", Scene { actuator_delays: out, ..full() }),
        ("volume_growth", Scene { volume_growth: out, ..full() }),
        ("finger_lag", Scene { finger_lag: out, ..full() }),
        ("all but volume_growth", Scene::ideal()),
    ]
}

/// Seconds of wall clock for each plant to take all commands once, the median and the fastest of several rounds. The plants take turns, so that
/// a machine that slows down slows all of them.
fn seconds_each(case: &Case, plants: &[Plant], mut progress: impl FnMut()) -> Vec<(f64, f64)> {
    let mut taken = vec![Vec::with_capacity(REPEATS); plants.len()];
    for _ in 0..REPEATS {
        for (plant, taken) in plants.iter().zip(&mut taken) {
            let mut plant = plant.clone();
            let start = Instant::now();
            for command in &case.commands {
                black_box(plant.step(command));
            }
            taken.push(start.elapsed().as_secs_f64());
            progress();
        }
    }
    taken.into_iter().map(median_and_fastest).collect()
}

fn median_and_fastest(mut taken: Vec<f64>) -> (f64, f64) {
    taken.sort_by(f64::total_cmp);
    (taken[taken.len() / 2], taken[0])
}

/// Root mean square differences of two plants' readings, pressure (kPa) and bend (degrees), over the case's commands.
fn reading_differences(case: &Case, mut one: Plant, mut other: Plant) -> (f64, f64) {
    let (mut pressure, mut bend) = (0.0, 0.0);
    for command in &case.commands {
        let (a, b) = (one.step(command), other.step(command));
        if let (Reading::Valid(a), Reading::Valid(b)) = (a.manifold, b.manifold) {
            pressure += (a.to_f64() - b.to_f64()).powi(2);
        }
        if let (Reading::Valid(a), Reading::Valid(b)) = (a.bend, b.bend) {
            bend += (a.to_f64() - b.to_f64()).powi(2);
        }
    }
    let ticks = case.commands.len() as f64;
    ((pressure / ticks).sqrt(), (bend / ticks).sqrt())
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// Measures everything; `progress` hears steps done and in all.
///
/// # Errors
/// When the default scene cannot be recorded or the reference fails.
pub fn measure(mut progress: impl FnMut(usize, usize)) -> Result<Report> {
    let choices = choices();
    let scenes = scenes();
    let total = 2 + choices.len() + scenes.len() + REPEATS * (choices.len() + scenes.len() + 1);
    let mut done = 0;
    let mut advance = || {
        done += 1;
        progress(done, total);
    };
    let scene = case::default_scene()?;
    advance();
    let stiff = case::stiff_cases()?;
    advance();
    let default = Choice::of_the_plant();
    let mut integrators = Vec::new();
    for choice in &choices {
        let plant = |case: &Case| case.plant(choice.method, choice.sub_steps, Scene::default(), SEED);
        let outcome = scene.replay(plant(&scene));
        integrators.push(IntegratorRow {
            integrator: choice.method.name(),
            step: choice.step(),
            default: *choice == default,
            dominated: false,
            max_error_kpa: outcome.max_error_kpa,
            rms_error_kpa: outcome.rms_error_kpa,
            max_bend_error_deg: outcome.max_bend_error_deg,
            evaluations_per_tick: outcome.evaluations_per_tick,
            simulated_seconds_per_second: 0.0,
            fastest_simulated_seconds_per_second: 0.0,
            stiff: stiff
                .iter()
                .map(|case| {
                    let outcome = case.replay(plant(case));
                    StiffRow {
                        case: case.name,
                        max_error_kpa: finite(outcome.max_error_kpa),
                        stable: outcome.late_error_kpa < STABLE_BELOW_KPA,
                    }
                })
                .collect(),
            closed_drift_nl: case::closed_drift_nl(choice.method, choice.sub_steps),
        });
        advance();
    }
    let of_default =
        |scene_switches: &Scene| scene.plant(default.method, default.sub_steps, scene_switches.clone(), SEED);
    let mut switches = Vec::new();
    for (left_out, switched) in &scenes {
        let outcome = scene.replay(of_default(switched));
        let (pressure, bend) = reading_differences(&scene, of_default(&Scene::default()), of_default(switched));
        switches.push(SwitchRow {
            left_out,
            time_ratio: 1.0,
            max_error_kpa: outcome.max_error_kpa,
            rms_error_kpa: outcome.rms_error_kpa,
            max_bend_error_deg: outcome.max_bend_error_deg,
            rms_pressure_reading_kpa: pressure,
            rms_bend_reading_deg: bend,
        });
        advance();
    }
    let mut plants: Vec<Plant> =
        choices.iter().map(|choice| scene.plant(choice.method, choice.sub_steps, Scene::default(), SEED)).collect();
    plants.extend(scenes.iter().map(|(_, switched)| of_default(switched)));
    let seconds = seconds_each(&scene, &plants, &mut advance);
    let simulated_s = 1e-3 * scene.commands.len() as f64;
    for (row, (median, fastest)) in integrators.iter_mut().zip(&seconds) {
        row.simulated_seconds_per_second = simulated_s / median;
        row.fastest_simulated_seconds_per_second = simulated_s / fastest;
    }
    let seconds = &seconds[choices.len()..];
    for (row, (_, fastest)) in switches.iter_mut().zip(seconds) {
        row.time_ratio = fastest / seconds[0].1;
    }
    let breakdown = breakdown::measure(&scene, REPEATS, &mut advance);
    mark_dominated(&mut integrators);
    let (ticks, reference_tolerance) = (scene.commands.len(), reference::TOLERANCE);
    Ok(Report { ticks, reference_tolerance, integrators, switches, breakdown })
}

fn mark_dominated(rows: &mut [IntegratorRow]) {
    let points: Vec<_> = rows.iter().map(|row| (row.fastest_simulated_seconds_per_second, row.max_error_kpa)).collect();
    for (row, &(speed, error)) in rows.iter_mut().zip(&points) {
        row.dominated = points.iter().any(|&(other_speed, other_error)| {
            other_speed >= speed && other_error <= error && (other_speed > speed || other_error < error)
        });
    }
}

#[cfg(test)]
mod tests;
