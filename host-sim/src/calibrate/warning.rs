//! What a lab should know before it loads a fit.

use super::estimate::Estimate;
use super::file::admitted;
use serde::Serialize;

/// Fewer levels than the model has coefficients plus two leave nothing to judge it by; the paper has five.
const LEAST_LEVELS: usize = 5;
/// Of two repeats nobody can tell which one is wrong.
const LEAST_REPEATS: usize = 3;
/// The paper's levels are 30 to 150 kPa; a level may be this far from its pressure.
const LOWEST_KPA: f64 = 35.0;
const HIGHEST_KPA: f64 = 145.0;
/// An empty segment that reads more than this has its zero wrong, degrees.
const ZERO_DEG: f64 = 2.0;
/// Chance below which a test speaks.
const CHANCE: f64 = 0.001;
/// k, c1, c2: a 95 % interval wider than a tenth of what the device takes (0..=60, 5..=40, 0..=2 kPa) is ill determined.
const WIDEST_KPA: [f64; 3] = [6.0, 3.5, 0.2];
/// Names of k, c1, c2.
pub const NAMES: [&str; 3] = ["k", "c1", "c2"];

/// What is the matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Too few pressures.
    FewLevels,
    /// Too few measurements at a pressure.
    FewRepeats,
    /// A point is not of the others' kind.
    Outlier,
    /// More pressure, less bend.
    NotRising,
    /// Low or high pressures are missing.
    RangeNotCovered,
    /// A coefficient is hardly determined.
    IllDetermined,
    /// A coefficient would be below zero.
    AtBound,
    /// The levels' means lie off the curve by more than their scatter explains.
    LackOfFit,
    /// Bends change from repeat to repeat.
    Drift,
    /// An empty segment is not straight.
    Zero,
    /// The device does not take a coefficient.
    OutsideDevice,
}

/// One warning.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// `all`, `proximal`, `middle` or `distal`.
    pub segment: &'static str,
    /// What is the matter.
    pub kind: Kind,
    /// What was found, and what to do.
    pub message: String,
}

/// All that is to be said of an estimate.
#[must_use]
pub fn warnings(estimate: &Estimate) -> Vec<Warning> {
    let mut all = Vec::new();
    let mut warn = |kind, message| all.push(Warning { segment: estimate.segment, kind, message });
    let levels = &estimate.levels;
    if levels.len() < LEAST_LEVELS {
        warn(
            Kind::FewLevels,
            format!(
                "{} pressures where at least {LEAST_LEVELS} are needed: measure 30, 60, 90, 120 and 150 kPa",
                levels.len()
            ),
        );
    }
    let scarce: Vec<String> = levels
        .iter()
        .filter(|level| level.points < LEAST_REPEATS)
        .map(|level| format!("{:.0} kPa ({})", level.pressure_kpa, level.points))
        .collect();
    if !scarce.is_empty() {
        warn(
            Kind::FewRepeats,
            format!(
                "fewer than {LEAST_REPEATS} measurements at {}: neither their scatter nor an outlier can be told; the \
                 paper has ten",
                scarce.join(", ")
            ),
        );
    }
    outliers(estimate, &mut warn);
    for pair in levels.windows(2) {
        if pair[1].bend_deg <= pair[0].bend_deg {
            warn(
                Kind::NotRising,
                format!(
                    "{:.1} degrees at {:.0} kPa, but {:.1} at {:.0} kPa: a segment bends more with more pressure; look \
                     for a leak, a slipped mark or swapped lines",
                    pair[0].bend_deg, pair[0].pressure_kpa, pair[1].bend_deg, pair[1].pressure_kpa
                ),
            );
        }
    }
    let [low, high] = estimate.range_kpa();
    if low > LOWEST_KPA || high < HIGHEST_KPA {
        warn(
            Kind::RangeNotCovered,
            format!(
                "measured from {low:.0} to {high:.0} kPa, the device uses 0 to 150: beyond, the curve is a guess; measure \
                 30 kPa and 150 kPa too"
            ),
        );
    }
    coefficients(estimate, &mut warn);
    if let Some(test) = estimate.lack_of_fit.filter(|test| test.chance < CHANCE)
        && let Some(farthest) = levels.iter().max_by(|a, b| a.residual_deg.abs().total_cmp(&b.residual_deg.abs()))
    {
        warn(
            Kind::LackOfFit,
            format!(
                "the mean at {:.0} kPa lies {:+.2} degrees off the curve, more than the scatter of the repeats explains \
                 (F = {:.1}, chance {:.0e}): the model, a gauge or a level is off; the intervals speak of scatter alone",
                farthest.pressure_kpa, farthest.residual_deg, test.f, test.chance
            ),
        );
    }
    if let Some(chance) = estimate.drift_chance.filter(|&chance| chance < CHANCE) {
        warn(
            Kind::Drift,
            format!(
                "bends change from repeat to repeat (chance {chance:.0e}): let the finger run in, and look for a leak"
            ),
        );
    }
    if let Some((place, deg)) = estimate.empty.first().filter(|(_, deg)| deg.abs() > ZERO_DEG) {
        warn(
            Kind::Zero,
            format!(
                "{place}: {deg:.1} degrees without pressure, more than {ZERO_DEG}: vent, set the bend's zero and measure \
                 anew"
            ),
        );
    }
    all
}

fn outliers(estimate: &Estimate, warn: &mut impl FnMut(Kind, String)) {
    let without = estimate.without_outliers_kpa.map_or_else(String::new, |[k, c1, c2]| {
        format!("; without the outliers k, c1, c2 would be {k:.3}, {c1:.3}, {c2:.3} kPa")
    });
    for point in estimate.points.iter().filter(|point| point.outlier) {
        warn(
            Kind::Outlier,
            format!(
                "{}: {:.1} degrees at {:.1} kPa, {:+.1} off the curve, is not of the others' kind: measure it anew, or \
                 put a # before it{without}",
                point.place, point.bend_deg, point.pressure_kpa, point.residual_deg
            ),
        );
    }
}

fn coefficients(estimate: &Estimate, warn: &mut impl FnMut(Kind, String)) {
    match estimate.ci95_kpa {
        None => warn(
            Kind::IllDetermined,
            format!(
                "{} points leave nothing to tell k, c1 and c2 apart or to judge them by: there are no confidence \
                 intervals; measure more pressures",
                estimate.points.len()
            ),
        ),
        Some(intervals) => {
            for (index, [low, high]) in intervals.into_iter().enumerate() {
                if high - low > WIDEST_KPA[index] {
                    let shared = estimate
                        .correlation_k_c1
                        .filter(|r| index < 2 && *r < -0.9)
                        .map_or_else(String::new, |r| format!(" (k and c1 share their effect, correlation {r:.2})"));
                    warn(
                        Kind::IllDetermined,
                        format!(
                            "{} is hardly determined: {low:.2} to {high:.2} kPa{shared}; repeats, and low pressures for \
                             k, narrow it. The curve itself is known to ±{:.2} degrees",
                            NAMES[index],
                            estimate.curve_ci95_deg.unwrap_or(f64::NAN)
                        ),
                    );
                }
            }
            for (index, [_, high]) in intervals.into_iter().enumerate() {
                if estimate.unbounded_kpa[index] < 0.0 && high <= 0.0 {
                    warn(
                        Kind::AtBound,
                        format!(
                            "the points ask for {} = {:.2} kPa, which no finger has; 0 is used: is the pressure's or the \
                             bend's zero off?",
                            NAMES[index], estimate.unbounded_kpa[index]
                        ),
                    );
                }
            }
        }
    }
    if let Err(why) = admitted(estimate.coefficients_kpa) {
        warn(Kind::OutsideDevice, format!("the device does not take {why}"));
    }
}
