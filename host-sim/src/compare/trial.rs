//! One regulator in one scenario with one seed.

use super::scenario::Scenario;
use crate::plant::{Plant, Truth};
use anyhow::{Result, anyhow, bail};
use model_core::actuation::{Actuation, PerSegment};
use model_core::observer::Pneumatics;
use model_core::self_test::{SelfTest, Verdict};
use model_core::units::Pressure;

/// A regulator under comparison: once a millisecond, references and the manifold's reading in, outputs out.
pub trait Contender: Send {
    /// What the power-on self test has measured of the machine, once, before the first tick.
    fn know(&mut self, pneumatics: Pneumatics);
    /// One tick. The reading has its zero taken off.
    fn step(&mut self, references: PerSegment<Pressure>, manifold: Pressure) -> Actuation;
    /// What it takes each chamber's pressure to be, kPa.
    fn estimates_kpa(&self) -> [f64; 3];
}

/// The self test ends long before, ms.
const SELF_TEST_MS: u32 = 10_000;
/// Time between self test and scenario, vented, in which the sensor's zero is taken: as the controller does in standby, ms.
const STANDBY_MS: u32 = 1000;
/// The last of it, in which the air has long left, is averaged, ms.
const ZERO_MS: u32 = 400;

/// One millisecond: the state at its start, and what was commanded for it.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// References, kPa.
    pub references_kpa: [f64; 3],
    /// True gauge pressures of the chambers, kPa.
    pub chambers_kpa: [f64; 3],
    /// What the regulator took them to be, kPa.
    pub estimates_kpa: [f64; 3],
    /// True gauge pressure of the manifold, kPa.
    pub manifold_kpa: f64,
    /// What was commanded.
    pub actuation: Actuation,
}

/// The true state at the moment a setpoint changes, from which the bound of that step starts.
#[derive(Clone, Debug)]
pub struct StepStart {
    /// Index of the moment.
    pub at: usize,
    /// The true state there.
    pub truth: Truth,
    /// The last commands, the newest last, as many as the longest dead time.
    pub commands: Vec<Actuation>,
}

/// A recorded trial.
#[derive(Clone, Debug)]
pub struct Trial {
    /// A moment a millisecond, and one at the end.
    pub moments: Vec<Moment>,
    /// Where references jump.
    pub steps: Vec<StepStart>,
}

/// References that change by more in a millisecond have jumped, kPa: the fastest sine moves by a tenth.
pub const JUMP_KPA: f64 = 1.0;
/// Commands kept at a step's start: more than any dead time.
const KEPT: usize = 64;

/// Runs it.
///
/// # Errors
/// When the pressure sensor fails or the self test does not pass, which no scenario asks for.
pub fn run(scenario: &Scenario, seed: u64, contender: &mut dyn Contender) -> Result<Trial> {
    let mut plant = Plant::new(scenario.variation.parameters(), scenario.variation.scene(), seed);
    let reading = |plant: &Plant| {
        plant.inputs().manifold.valid().ok_or_else(|| anyhow!("the pressure sensor fails in {}", scenario.name))
    };
    contender.know(self_tested(&mut plant, scenario)?);
    let mut zero_kpa = 0.0;
    for time_ms in 0..STANDBY_MS {
        if time_ms >= STANDBY_MS - ZERO_MS {
            zero_kpa += reading(&plant)?.to_f64() / f64::from(ZERO_MS);
        }
        plant.step(&Actuation::SAFE);
    }
    let zero = Pressure::from_f64_kpa(zero_kpa);
    let references = scenario.references_kpa(seed);
    let mut trial = Trial { moments: Vec::with_capacity(references.len()), steps: Vec::new() };
    let mut before_kpa = [0.0; 3];
    for (at, &references_kpa) in references.iter().enumerate() {
        let truth = plant.truth();
        if jumps(before_kpa, references_kpa) {
            let kept = &trial.moments[at.saturating_sub(KEPT)..];
            let commands = kept.iter().map(|moment: &Moment| moment.actuation).collect();
            trial.steps.push(StepStart { at, truth, commands });
        }
        before_kpa = references_kpa;
        let actuation = contender.step(references_kpa.map(Pressure::from_f64_kpa), reading(&plant)? - zero);
        trial.moments.push(Moment {
            references_kpa,
            chambers_kpa: truth.chambers_kpa,
            estimates_kpa: contender.estimates_kpa(),
            manifold_kpa: truth.manifold_kpa,
            actuation,
        });
        plant.step(&actuation);
    }
    Ok(trial)
}

/// What the power-on self test measures of this machine, as the controller does before anything else.
fn self_tested(plant: &mut Plant, scenario: &Scenario) -> Result<Pneumatics> {
    let mut test = SelfTest::new();
    for _ in 0..SELF_TEST_MS {
        match test.step(&plant.inputs()) {
            Verdict::Testing(actuation) => {
                plant.step(&actuation);
            }
            Verdict::Passed => return Ok(test.measured()),
            Verdict::Failed(part) => bail!("the self test finds {part:?} in {}", scenario.name),
        }
    }
    bail!("the self test does not end in {}", scenario.name)
}

/// Whether a reference jumps.
#[must_use]
pub fn jumps(before_kpa: [f64; 3], now_kpa: [f64; 3]) -> bool {
    before_kpa.iter().zip(now_kpa).any(|(before, now)| (now - before).abs() > JUMP_KPA)
}
