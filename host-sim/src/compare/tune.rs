//! Tuning of the peers: the same seeded search, budget, scenarios and seeds for each.
//!
//! A third of the budget draws all figures at random over their ranges (evenly in their logarithms, the first draw is the
//! start set by hand); the rest changes some figures of the best so far by factors that shrink. Its scenarios are a part of those
//! that are compared, with seeds that the comparison does not use. Ours is not tuned here: its constants are the core's.

use super::bound::Physics;
use super::contender::{Kind, gains::Range};
use super::scenario::{self, Scenario};
use super::{score, trial};
use anyhow::{Context, Result};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde::Serialize;

/// Scenarios that are tuned on.
pub const SCENARIOS: [&str; 5] = ["multi-step", "60-30-60", "sine-0.25", "sine-one", "random"];
/// Seeds that are tuned with: not those of the comparison.
pub const SEEDS: [u64; 2] = [9001, 9002];
/// Trials of figures for each peer, unless told otherwise.
pub const BUDGET: usize = 400;
/// Seed of the search itself.
const SEARCH_SEED: u64 = 5;
/// Candidates that are judged side by side: two cores are busy whatever the scenarios' lengths.
const BATCH: usize = 6;

/// Weights of the cost beside the mean absolute error's 1 per kPa: hold error and overshoot for each kPa, a thousand switchings a
/// minute, and a step or hold that never gets there.
const PER_HOLD_KPA: f64 = 1.0;
const PER_OVERSHOOT_KPA: f64 = 0.25;
const PER_1000_SWITCHINGS: f64 = 0.5;
const PER_MISSED_SHARE: f64 = 3.0;

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Tuned {
    /// The peer.
    pub regulator: &'static str,
    /// Candidates judged.
    pub budget: usize,
    /// The figures' names, with units.
    pub names: Vec<&'static str>,
    /// The figures.
    pub values: Vec<f64>,
    /// Their cost.
    pub cost_kpa: f64,
    /// The cost of the start set by hand.
    pub start_cost_kpa: f64,
    /// The cost of ours, which is not tuned, by the same measure.
    pub cost_of_ours_kpa: f64,
}

/// The cost of these figures, kPa.
fn cost(regulator: Kind, values: &[f64], cases: &[(&Scenario, Physics)]) -> Result<f64> {
    let mut sum = 0.0;
    for (scenario, physics) in cases {
        let mut trials = Vec::new();
        for seed in SEEDS {
            trials.push((seed, trial::run(scenario, seed, regulator.make_with(values).as_mut())?));
        }
        let (scores, _) = score::score(&trials, physics, scenario.scored_from_ms() as usize);
        let steps = f64::from(scores.steps + scores.mixed_steps).max(1.0);
        let missed = f64::from(scores.steps_not_settled + scores.mixed_steps_not_settled) / steps;
        sum += scores.mean_absolute_error_kpa
            + PER_HOLD_KPA * scores.hold_error_kpa.unwrap_or(0.0)
            + PER_OVERSHOOT_KPA * scores.overshoot_kpa.unwrap_or(0.0)
            + PER_1000_SWITCHINGS * scores.switchings_per_min() / 1000.0
            + PER_MISSED_SHARE * missed;
    }
    Ok(sum / cases.len() as f64)
}

fn random(ranges: &[Range], rng: &mut Pcg64) -> Vec<f64> {
    ranges.iter().map(|range| (rng.random_range(range.low.ln()..=range.high.ln())).exp()).collect()
}

/// Some of the figures changed; at least one.
fn changed(best: &[f64], ranges: &[Range], spread: f64, rng: &mut Pcg64) -> Vec<f64> {
    let must = rng.random_range(0..ranges.len());
    let share = (3.0 / ranges.len() as f64).min(1.0);
    let mut values = best.to_vec();
    for (i, (value, range)) in values.iter_mut().zip(ranges).enumerate() {
        let draw: f64 = StandardNormal.sample(rng);
        if i == must || rng.random_range(0.0..1.0) < share {
            let width = (range.high / range.low).ln();
            *value = (*value * (draw * spread * width).exp()).clamp(range.low, range.high);
        }
    }
    values
}

/// Tunes a peer with so many candidates; `progress` is called after each.
///
/// # Errors
/// When a trial fails.
pub fn tune(regulator: Kind, budget: usize, progress: impl Fn() + Sync) -> Result<Tuned> {
    let cases = SCENARIOS
        .iter()
        .map(|name| {
            let scenario = scenario::find(name).context("a scenario to tune on is missing")?;
            Ok((scenario, Physics::new(scenario.variation.parameters(), &scenario.variation.scene())))
        })
        .collect::<Result<Vec<_>>>()?;
    let ranges = regulator.ranges();
    let mut rng = Pcg64::seed_from_u64(SEARCH_SEED);
    let start: Vec<f64> = ranges.iter().map(|range| range.start).collect();
    let start_cost_kpa = cost(regulator, &start, &cases)?;
    progress();
    let (mut best, mut best_cost) = (start, start_cost_kpa);
    let mut judged = 1;
    while judged < budget {
        let share = judged as f64 / budget as f64;
        let count = BATCH.min(budget - judged);
        let candidates: Vec<Vec<f64>> = (0..count)
            .map(|_| {
                if share < 1.0 / 3.0 {
                    random(&ranges, &mut rng)
                } else {
                    // From a fifth of a range down to a fiftieth.
                    changed(&best, &ranges, 0.2 * 0.1_f64.powf((share - 1.0 / 3.0) * 1.5), &mut rng)
                }
            })
            .collect();
        let costs = candidates
            .par_iter()
            .map(|values| {
                let cost = cost(regulator, values, &cases);
                progress();
                cost
            })
            .collect::<Result<Vec<f64>>>()?;
        for (values, cost) in candidates.into_iter().zip(costs) {
            if cost < best_cost {
                (best, best_cost) = (values, cost);
            }
        }
        judged += count;
    }
    // Four digits decide nothing, and read better.
    let best: Vec<f64> = best.iter().map(|value| format!("{value:.3e}").parse().unwrap_or(*value)).collect();
    Ok(Tuned {
        regulator: regulator.name(),
        budget,
        names: ranges.iter().map(|range| range.name).collect(),
        cost_kpa: cost(regulator, &best, &cases)?,
        values: best,
        start_cost_kpa,
        cost_of_ours_kpa: cost(Kind::Ours, &[], &cases)?,
    })
}

/// For people, and to be copied to `contender/tuned.rs`.
#[must_use]
pub fn text(all: &[Tuned]) -> String {
    let mut out = String::new();
    for tuned in all {
        out += &format!(
            "{}: cost {:.3} kPa after {} candidates; start {:.3}, ours {:.3}\n",
            tuned.regulator, tuned.cost_kpa, tuned.budget, tuned.start_cost_kpa, tuned.cost_of_ours_kpa
        );
        for (name, value) in tuned.names.iter().zip(&tuned.values) {
            out += &format!("  {name:<26}{value}\n");
        }
        out += &format!("  {:?}\n", tuned.values);
    }
    out
}
