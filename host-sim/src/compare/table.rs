//! The comparison as text.

use super::Report;

/// A figure that may be missing.
fn optional(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

/// For people.
#[must_use]
pub fn text(report: &Report) -> String {
    let mut out = format!(
        "{:<14}{:<13}{:>8}{:>8}{:>7}{:>9}{:>9}{:>7}{:>7}{:>9}{:>8}{:>8}{:>7}{:>8}{:>8}\n",
        "scenario",
        "regulator",
        "error",
        "hold",
        "over",
        "settling",
        "bound",
        "mean",
        "worst",
        "not",
        "valves",
        "relay",
        "pump",
        "distur-",
        "peak"
    );
    out += &format!(
        "{:<14}{:<13}{:>8}{:>8}{:>7}{:>9}{:>9}{:>7}{:>7}{:>9}{:>8}{:>8}{:>7}{:>8}{:>8}\n",
        "", "", "kPa", "kPa", "kPa", "ms", "ms", "ratio", "ratio", "settled", "/min", "/min", "duty", "bance", "kPa"
    );
    for row in &report.rows {
        let scores = &row.scores;
        out += &format!(
            "{:<14}{:<13}{:>8.2}{:>8}{:>7}{:>9}{:>9}{:>7}{:>7}{:>9}{:>8.0}{:>8.0}{:>7.2}{:>8}{:>8.1}\n",
            row.scenario,
            row.regulator,
            scores.mean_absolute_error_kpa,
            optional(scores.hold_error_kpa, 2),
            optional(scores.overshoot_kpa, 2),
            optional(scores.settling_ms, 0),
            optional(scores.bound_ms, 0),
            optional(scores.settling_over_bound, 2),
            optional(scores.worst_settling_over_bound, 2),
            format!("{}/{}", scores.steps_not_settled, scores.steps),
            scores.valve_switchings_per_min,
            scores.relay_switchings_per_min,
            scores.pump_duty,
            optional(scores.disturbance_kpa, 2),
            scores.peak_chamber_kpa,
        );
    }
    out
}
