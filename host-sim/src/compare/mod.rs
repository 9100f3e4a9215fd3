//! Regulators side by side: the same plant, noise, seeds and scenarios.

pub mod bound;
pub(crate) mod command;
pub mod contender;
mod picture;
pub mod scenario;
pub mod score;
mod table;
pub mod target;
pub mod trial;
pub mod tune;

pub use picture::{error_against_switchings, traces};
pub use table::{csv, markdown, text};

use anyhow::Result;
use bound::Physics;
use rayon::prelude::*;
use scenario::Scenario;
use score::{Scores, StepScore};
use serde::Serialize;

/// One regulator in one scenario.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The scenario.
    pub scenario: &'static str,
    /// The regulator.
    pub regulator: &'static str,
    /// Its figures over all seeds.
    pub scores: Scores,
    /// Its steps, seed by seed.
    pub steps: Vec<StepScore>,
}

/// All that is measured.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Seeds 1 to this.
    pub seeds: u64,
    /// A row for each scenario and regulator.
    pub rows: Vec<Row>,
}

impl Report {
    /// What ours is aimed at, and where it is.
    #[must_use]
    pub fn targets(&self) -> Vec<target::Target> {
        target::targets(self)
    }

    /// The row of a scenario and a regulator.
    #[must_use]
    pub fn row(&self, scenario: &str, regulator: contender::Kind) -> Option<&Row> {
        self.rows.iter().find(|row| row.scenario == scenario && row.regulator == regulator.name())
    }
}

/// Runs these scenarios with seeds 1 to `seeds` for all regulators; `progress` is called after each trial, from any thread.
///
/// # Errors
/// When a trial fails.
pub fn measure(scenarios: &[Scenario], seeds: u64, progress: impl Fn() + Sync) -> Result<Report> {
    let cases: Vec<(&Scenario, contender::Kind)> =
        scenarios.iter().flat_map(|scenario| contender::Kind::ALL.map(|regulator| (scenario, regulator))).collect();
    let rows: Result<Vec<Row>> = cases
        .par_iter()
        .map(|&(scenario, regulator)| {
            let physics = Physics::new(scenario.variation.parameters(), &scenario.variation.scene());
            let mut trials = Vec::new();
            for seed in 1..=seeds {
                trials.push((seed, trial::run(scenario, seed, regulator.make().as_mut())?));
                progress();
            }
            let (scores, steps) = score::score(&trials, &physics, scenario.scored_from_ms() as usize);
            Ok(Row { scenario: scenario.name, regulator: regulator.name(), scores, steps })
        })
        .collect();
    Ok(Report { seeds, rows: rows? })
}

#[cfg(test)]
mod tests;
