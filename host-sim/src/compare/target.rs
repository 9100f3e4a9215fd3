//! What the core's regulator is aimed at, and whether it is there.

use super::contender::Kind;
use super::score::Scores;
use super::{Report, Row, scenario};
use serde::Serialize;

/// Mean hold error, kPa: the sensor's display resolution.
const HOLD_KPA: f64 = 1.0;
/// Overshoot, kPa.
const OVERSHOOT_KPA: f64 = 2.0;
/// Settling time over the physical bound.
const OVER_BOUND: f64 = 1.2;
/// Mean absolute error in multi-step over the best peer's: at least 30 % less.
const OVER_BEST_PEER: f64 = 0.7;
/// Room of the robust scenarios.
const ROBUST: f64 = 2.0;

/// One target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    /// What is aimed at.
    pub what: &'static str,
    /// Where it is looked for.
    pub scenarios: &'static str,
    /// The largest value that is good.
    pub limit: f64,
    /// What ours does.
    pub ours: f64,
    /// The scenario in which it does worst, where there are several.
    pub worst_scenario: Option<&'static str>,
    /// Whether it is there.
    pub met: bool,
}

impl Target {
    fn new(what: &'static str, scenarios: &'static str, limit: f64, ours: f64, worst: Option<&'static str>) -> Self {
        Self { what, scenarios, limit, ours, worst_scenario: worst, met: ours <= limit }
    }
}

/// The largest of a figure over some rows, with its scenario.
fn worst(rows: &[&Row], figure: impl Fn(&Scores) -> Option<f64>) -> Option<(f64, &'static str)> {
    rows.iter().filter_map(|row| Some((figure(&row.scores)?, row.scenario))).max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The targets that these rows can tell something of.
#[must_use]
pub fn targets(report: &Report) -> Vec<Target> {
    let mut targets = Vec::new();
    for (name, robust) in [("default plant", false), ("robust", true)] {
        let room = if robust { ROBUST } else { 1.0 };
        let rows: Vec<&Row> = report
            .rows
            .iter()
            .filter(|row| row.regulator == Kind::Ours.name())
            .filter(|row| scenario::find(row.scenario).is_some_and(|one| one.variation.is_robust() == robust))
            .collect();
        let mut add = |what, limit: f64, found: Option<(f64, &'static str)>| {
            if let Some((value, scenario)) = found {
                targets.push(Target::new(what, name, limit * room, value, Some(scenario)));
            }
        };
        add("mean hold error, kPa", HOLD_KPA, worst(&rows, |scores| scores.hold_error_kpa));
        add("overshoot, kPa", OVERSHOOT_KPA, worst(&rows, |scores| scores.overshoot_kpa));
        // A scenario with a step that never settles is beyond any limit.
        add(
            "mean settling over bound",
            OVER_BOUND,
            worst(
                &rows,
                |scores| if scores.steps_not_settled > 0 { Some(f64::INFINITY) } else { scores.settling_over_bound },
            ),
        );
        let error = |row: &Row| row.scores.mean_absolute_error_kpa;
        let switchings = |row: &Row| row.scores.switchings_per_min();
        add("switchings over the fewest of the peers", 1.0, over_best(report, &rows, switchings));
        if robust {
            add("mean absolute error over the best peer's", OVER_BEST_PEER, over_best(report, &rows, error));
        } else {
            let multi: Vec<&Row> = rows.iter().copied().filter(|row| row.scenario == "multi-step").collect();
            let found = over_best(report, &multi, error);
            if let Some((value, _)) = found {
                let what = "mean absolute error over the best peer's";
                targets.push(Target::new(what, "multi-step", OVER_BEST_PEER, value, None));
            }
        }
    }
    targets
}

/// The largest over these rows of ours over the best peer's.
fn over_best(report: &Report, rows: &[&Row], figure: impl Fn(&Row) -> f64) -> Option<(f64, &'static str)> {
    let over = |row: &&Row| {
        let peers = Kind::PEERS.iter().filter_map(|&peer| report.row(row.scenario, peer));
        let best = peers.map(&figure).min_by(f64::total_cmp)?;
        Some((figure(row) / best, row.scenario))
    };
    rows.iter().filter_map(over).max_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(scenario: &'static str, regulator: Kind, error: f64, overshoot: f64, switchings: f64) -> Row {
        let scores = Scores {
            mean_absolute_error_kpa: error,
            overshoot_kpa: Some(overshoot),
            valve_switchings_per_min: switchings,
            ..Scores::default()
        };
        Row { scenario, regulator: regulator.name(), scores, steps: Vec::new() }
    }

    #[test]
    fn targets_are_judged_by_the_worst_scenario_and_the_best_peer() {
        let rows = vec![
            row("multi-step", Kind::Ours, 2.0, 1.0, 100.0),
            row("multi-step", Kind::BangBang, 4.0, 0.0, 90.0),
            row("multi-step", Kind::PwmPid, 3.0, 0.0, 400.0),
            row("random", Kind::Ours, 9.0, 2.5, 50.0),
            row("random", Kind::BangBang, 1.0, 0.0, 200.0),
            row("leak", Kind::Ours, 3.0, 3.5, 10.0),
        ];
        let targets = targets(&Report { seeds: 1, rows });
        let find = |what: &str, scenarios: &str| {
            targets.iter().find(|target| target.what.starts_with(what) && target.scenarios == scenarios).expect("there")
        };
        let error = find("mean absolute", "multi-step");
        assert!((error.ours - 2.0 / 3.0).abs() < 1e-12 && error.met);
        let over = find("overshoot", "default plant");
        assert_eq!((over.worst_scenario, over.met), (Some("random"), false));
        // Twice the room, and no peer to compare with.
        assert!(find("overshoot", "robust").met);
        assert!((find("switchings", "default plant").ours - 100.0 / 90.0).abs() < 1e-12);
        assert!(!targets.iter().any(|target| target.what.starts_with("mean absolute") && target.scenarios == "robust"));
    }
}
