//! The comparison as text, as Markdown and as CSV.

use super::bound::Kind as Way;
use super::contender::Kind;
use super::score::StepScore;
use super::{Report, Row};
use anyhow::{Context, Result};

/// A figure that may be missing.
fn optional(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

/// Settling time with its bound in brackets, ms.
fn settling(settling_ms: Option<f64>, bound_ms: Option<f64>) -> String {
    match (settling_ms, bound_ms) {
        (Some(settling), Some(bound)) => format!("{settling:.0} ({bound:.0})"),
        (None, Some(bound)) => format!("- ({bound:.0})"),
        _ => "-".to_owned(),
    }
}

/// Column heads with their units.
const HEADS: [(&str, &str); 17] = [
    ("scenario", ""),
    ("regulator", ""),
    ("error (least)", "kPa"),
    ("hold", "kPa"),
    ("overshoot", "kPa"),
    ("settling (bound)", "ms"),
    ("ratio", "mean"),
    ("ratio", "worst"),
    ("unsettled", "steps"),
    ("mixed (bound)", "ms"),
    ("unsettled", "mixed"),
    ("valves", "/min"),
    ("relay", "/min"),
    ("pump", "duty"),
    ("disturbed", "kPa"),
    ("chamber", "max kPa"),
    ("manifold", "max kPa"),
];

fn cells(row: &Row) -> [String; 17] {
    let scores = &row.scores;
    [
        row.scenario.to_owned(),
        row.regulator.to_owned(),
        format!("{:.2} ({:.2})", scores.mean_absolute_error_kpa, scores.least_error_kpa),
        optional(scores.hold_error_kpa, 2),
        optional(scores.overshoot_kpa, 2),
        settling(scores.settling_ms, scores.bound_ms),
        optional(scores.settling_over_bound, 2),
        optional(scores.worst_settling_over_bound, 2),
        format!("{}/{}", scores.steps_not_settled, scores.steps),
        settling(scores.mixed_settling_ms, scores.mixed_bound_ms),
        format!("{}/{}", scores.mixed_steps_not_settled, scores.mixed_steps),
        format!("{:.0}", scores.valve_switchings_per_min),
        format!("{:.0}", scores.relay_switchings_per_min),
        format!("{:.2}", scores.pump_duty),
        optional(scores.disturbance_kpa, 2),
        format!("{:.1}", scores.peak_chamber_kpa),
        format!("{:.1}", scores.peak_manifold_kpa),
    ]
}

/// Rows with their columns as wide as they must be; the first two to the left.
fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(String::len).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut out = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            line += &if column < 2 { format!("{cell:<width$}  ") } else { format!("{cell:>width$}  ") };
        }
        out += line.trim_end();
        out.push('\n');
    }
    out
}

/// The steps of a report with the same references, averaged over the seeds: for each regulator settling time, where all
/// settled, and bound, ms.
struct StepRow {
    scenario: &'static str,
    from_kpa: [f64; 3],
    to_kpa: [f64; 3],
    way: Way,
    regulators: Vec<(Option<f64>, f64)>,
}

fn step_rows(report: &Report) -> Vec<StepRow> {
    let mut rows = Vec::new();
    let Some(first) = Kind::ALL.first() else { return rows };
    for row in report.rows.iter().filter(|row| row.regulator == first.name()) {
        // Each seed has setpoints of its own where they are random: the first seed's steps stand for them.
        let firsts: Vec<&StepScore> = row.steps.iter().filter(|step| step.seed == 1).collect();
        for step in firsts {
            let alike = |other: &&StepScore| {
                let same = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.0);
                other.at_ms == step.at_ms && same(other.from_kpa, step.from_kpa) && same(other.to_kpa, step.to_kpa)
            };
            let of = |kind: &Kind| {
                let steps = report.row(row.scenario, *kind).map_or(&[][..], |row| &row.steps);
                let (mut settling, mut bound, mut count) = (Some(0.0), 0.0, 0.0);
                for other in steps.iter().filter(alike) {
                    settling = settling.zip(other.settling_ms).map(|(sum, one)| sum + one);
                    bound += other.bound_ms;
                    count += 1.0;
                }
                (settling.map(|sum| sum / count), bound / count)
            };
            rows.push(StepRow {
                scenario: row.scenario,
                from_kpa: step.from_kpa,
                to_kpa: step.to_kpa,
                way: step.kind,
                regulators: Kind::ALL.iter().map(of).collect(),
            });
        }
    }
    rows
}

fn kpa(values: [f64; 3]) -> String {
    values.map(|value| format!("{value:.0}")).join("/")
}

fn step_cells(row: &StepRow) -> Vec<String> {
    let way = match row.way {
        Way::Rise => "rise",
        Way::Fall => "fall",
        Way::Mixed => "mixed",
    };
    let mut cells =
        vec![row.scenario.to_owned(), format!("{} to {}", kpa(row.from_kpa), kpa(row.to_kpa)), way.to_owned()];
    cells.extend(row.regulators.iter().map(|&(time, bound)| settling(time, Some(bound))));
    cells
}

fn step_heads() -> Vec<String> {
    let heads = ["scenario", "step, kPa", "way"].map(str::to_owned);
    heads.into_iter().chain(Kind::ALL.map(|kind| kind.name().to_owned())).collect()
}

fn met(met: bool) -> String {
    if met { "met" } else { "not met" }.to_owned()
}

fn target_rows(report: &Report) -> Vec<Vec<String>> {
    let row = |target: &super::target::Target| {
        vec![
            target.what.to_owned(),
            target.scenarios.to_owned(),
            format!("{:.2}", target.limit),
            format!("{:.2}", target.ours),
            target.worst_scenario.unwrap_or("").to_owned(),
            met(target.met),
        ]
    };
    report.targets().iter().map(row).collect()
}

const TARGET_HEADS: [&str; 6] = ["target of ours", "scenarios", "at most", "is", "worst in", ""];

/// For people: all figures, every step with its bound, the targets.
#[must_use]
pub fn text(report: &Report) -> String {
    let mut rows =
        vec![HEADS.map(|(name, _)| name.to_owned()).to_vec(), HEADS.map(|(_, unit)| unit.to_owned()).to_vec()];
    rows.extend(report.rows.iter().map(|row| cells(row).to_vec()));
    let mut out = aligned(&rows);
    let mut steps = vec![step_heads()];
    steps.extend(step_rows(report).iter().map(step_cells));
    if steps.len() > 1 {
        out += "\nsettling within 2 kPa (and the least that physics allows from the same state), ms, mean of the seeds; bounds of mixed steps are loose\n";
        out += &aligned(&steps);
    }
    let targets = target_rows(report);
    if !targets.is_empty() {
        out.push('\n');
        out += &aligned(&[vec![TARGET_HEADS.map(str::to_owned).to_vec()], targets].concat());
    }
    out
}

fn markdown_table(rows: &[Vec<String>], left: usize) -> String {
    let mut out = String::new();
    for (index, row) in rows.iter().enumerate() {
        out += &format!("| {} |\n", row.join(" | "));
        if index == 0 {
            let mark = |column: usize| if column < left { "---" } else { "---:" };
            out += &format!("|{}|\n", (0..row.len()).map(mark).collect::<Vec<_>>().join("|"));
        }
    }
    out
}

/// For docs/compare.md.
#[must_use]
pub fn markdown(report: &Report) -> String {
    let head = |(name, unit): (&str, &str)| if unit.is_empty() { name.to_owned() } else { format!("{name}, {unit}") };
    let mut rows = vec![HEADS.map(head).to_vec()];
    rows.extend(report.rows.iter().map(|row| cells(row).to_vec()));
    let mut steps = vec![step_heads()];
    steps.extend(step_rows(report).iter().map(step_cells));
    let targets = [vec![TARGET_HEADS.map(str::to_owned).to_vec()], target_rows(report)].concat();
    format!(
        "Targets, seeds 1 to {}:\n\n{}\nAll figures:\n\n{}\nEvery step: time to settle within 2 kPa (and the least time that physics allows from the same state), ms, mean of the \
         seeds; random setpoints of the first seed; a dash where a seed did not settle:\n\n{}",
        report.seeds,
        markdown_table(&targets, 2),
        markdown_table(&rows, 2),
        markdown_table(&steps, 3)
    )
}

/// Columns of the table after scenario and regulator: [`super::score::Scores`]' fields in their order.
const COLUMNS: [&str; 23] = [
    "mean_absolute_error_kpa",
    "least_error_kpa",
    "hold_error_kpa",
    "holds_not_reached",
    "overshoot_kpa",
    "steps",
    "steps_not_settled",
    "settling_ms",
    "bound_ms",
    "settling_over_bound",
    "worst_settling_over_bound",
    "mixed_steps",
    "mixed_steps_not_settled",
    "mixed_settling_ms",
    "mixed_bound_ms",
    "valve_switchings_per_min",
    "relay_switchings_per_min",
    "pump_duty",
    "disturbance_kpa",
    "peak_chamber_kpa",
    "peak_manifold_kpa",
    "estimate_error_kpa",
    "seeds",
];

/// One row a scenario and regulator, one column a figure; missing ones are empty.
///
/// # Errors
/// When a figure has no column.
pub fn csv(report: &Report) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["scenario", "regulator"].iter().chain(&COLUMNS))?;
    for row in &report.rows {
        let mut scores = serde_json::to_value(&row.scores)?;
        scores["seeds"] = report.seeds.into();
        let mut record = vec![row.scenario.to_owned(), row.regulator.to_owned()];
        for column in COLUMNS {
            let value = scores.get(column).with_context(|| format!("the scores have no {column}"))?;
            record.push(if value.is_null() { String::new() } else { value.to_string() });
        }
        writer.write_record(record)?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::score::Scores;

    #[test]
    fn the_table_has_a_column_for_every_figure() {
        let row = Row { scenario: "multi-step", regulator: "ours", scores: Scores::default(), steps: Vec::new() };
        let fields = serde_json::to_value(&row.scores).expect("JSON");
        let names: Vec<&String> = fields.as_object().expect("an object").keys().collect();
        assert_eq!(names.len() + 1, COLUMNS.len());
        assert!(names.iter().all(|name| COLUMNS.contains(&name.as_str())), "{names:?}");
        let table = csv(&Report { seeds: 3, rows: vec![row] }).expect("written");
        let lines: Vec<&str> = table.lines().collect();
        assert!(
            lines.len() == 2 && lines[1].starts_with("multi-step,ours,0.0,0.0,,0,") && lines[1].ends_with(",3"),
            "{table}"
        );
    }

    #[test]
    fn a_settling_time_stands_beside_its_bound() {
        assert_eq!(settling(Some(412.4), Some(300.0)), "412 (300)");
        assert_eq!(settling(None, Some(300.0)), "- (300)");
        assert_eq!(settling(None, None), "-");
    }
}
