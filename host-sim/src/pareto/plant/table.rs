//! The report as text, Markdown and CSV.

use super::{ERROR_TARGET_KPA, IntegratorRow, Report, SPEED_TARGET};
use anyhow::{Result, anyhow};

/// An error with three digits that count; a dash where there is no number any more.
fn error(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) if value.abs() < 1e-3 || value.abs() >= 1e5 => format!("{value:.1e}"),
        Some(value) => {
            let digits = (1 - value.abs().log10().floor() as i32).clamp(0, 5) as usize;
            format!("{value:.digits$}")
        }
    }
}

/// A speed with two digits that count: more would claim too much of one run.
fn speed(value: f64) -> String {
    if value <= 0.0 {
        return "0".to_owned();
    }
    let unit = 10_f64.powi(value.log10().floor() as i32 - 1);
    let rounded = ((value / unit).round() * unit) as u64;
    if rounded >= 1000 { format!("{},{:03}", rounded / 1000, rounded % 1000) } else { rounded.to_string() }
}

/// Median and fastest round.
fn speeds(row: &IntegratorRow) -> String {
    let [median, fastest] = [row.simulated_seconds_per_second, row.fastest_simulated_seconds_per_second].map(speed);
    format!("{median} to {fastest}")
}

fn stiff(row: &IntegratorRow) -> Vec<String> {
    row.stiff
        .iter()
        .map(|case| {
            let value = error(case.max_error_kpa);
            if case.stable { value } else { format!("{value}, unstable") }
        })
        .collect()
}

/// Head and rows of a table.
type Table = (Vec<String>, Vec<Vec<String>>);

fn tables(report: &Report) -> [Table; 4] {
    let head = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let name = |row: &IntegratorRow| format!("{}{}", row.integrator, if row.default { " (default)" } else { "" });
    let integrators = report
        .integrators
        .iter()
        .map(|row| {
            vec![
                name(row),
                row.step.clone(),
                error(Some(row.max_error_kpa)),
                error(Some(row.rms_error_kpa)),
                error(Some(row.max_bend_error_deg)),
                format!("{:.2}", row.evaluations_per_tick),
                speeds(row),
                if row.dominated { "yes".to_owned() } else { "no".to_owned() },
            ]
        })
        .collect();
    let mut stiff_head = head(&["integrator", "step"]);
    if let Some(row) = report.integrators.first() {
        stiff_head.extend(row.stiff.iter().map(|case| format!("{}, kPa", case.case)));
    }
    stiff_head.push("closed air's change, NL".to_owned());
    let stiff_rows = report
        .integrators
        .iter()
        .map(|row| {
            let mut cells = vec![name(row), row.step.clone()];
            cells.extend(stiff(row));
            cells.push(error(Some(row.closed_drift_nl)));
            cells
        })
        .collect();
    let switches = report
        .switches
        .iter()
        .map(|row| {
            vec![
                row.left_out.to_owned(),
                format!("{:.2}", row.time_ratio),
                error(Some(row.max_error_kpa)),
                error(Some(row.rms_error_kpa)),
                error(Some(row.max_bend_error_deg)),
                error(Some(row.rms_pressure_reading_kpa)),
                error(Some(row.rms_bend_reading_deg)),
            ]
        })
        .collect();
    [
        (
            head(&[
                "integrator",
                "step",
                "max error, kPa",
                "rms error, kPa",
                "bend error, deg",
                "evaluations a tick",
                "simulated s per s",
                "dominated",
            ]),
            integrators,
        ),
        (stiff_head, stiff_rows),
        (
            head(&[
                "left out",
                "time ratio",
                "max error, kPa",
                "rms error, kPa",
                "bend error, deg",
                "pressure reading, kPa rms",
                "bend reading, deg rms",
            ]),
            switches,
        ),
        parts(report),
    ]
}

fn parts(report: &Report) -> Table {
    let total: f64 = report.breakdown.parts.iter().map(|row| row.fastest_ns_per_tick).sum();
    let line = |name: &str, median_ns: f64, fastest_ns: f64| {
        vec![
            name.to_owned(),
            format!("{median_ns:.0}"),
            format!("{fastest_ns:.0}"),
            format!("{:.0} %", 100.0 * fastest_ns / total),
        ]
    };
    let rows = &report.breakdown.parts;
    let mut lines: Vec<_> = rows.iter().map(|row| line(row.part, row.ns_per_tick, row.fastest_ns_per_tick)).collect();
    lines.push(line("whole tick", rows.iter().map(|row| row.ns_per_tick).sum(), total));
    let head = ["part of a tick", "median round, ns", "fastest round, ns", "share"].map(str::to_owned).to_vec();
    (head, lines)
}

/// What the default's ticks take, counted.
fn counts(report: &Report) -> String {
    let breakdown = &report.breakdown;
    format!(
        "Counted, on any machine: {:.2} evaluations of the flows a tick; the bends take one step of Newton's method side \
         by side in {:.1} % of the ticks, iterate in {:.1} %, and rest in the others.",
        breakdown.flow_evaluations_per_tick,
        100.0 * breakdown.bends_side_by_side_share,
        100.0 * breakdown.bends_iterated_share,
    )
}

/// Whether the default meets both targets, in words.
fn verdict(report: &Report) -> String {
    let Some(row) = report.integrators.iter().find(|row| row.default) else {
        return "the default is not among the choices".to_owned();
    };
    format!(
        "Default: {} of {}, {} kPa off at the most (target {ERROR_TARGET_KPA} kPa), {} simulated seconds a second \
         (target {}) over {} ticks.",
        row.integrator,
        row.step,
        error(Some(row.max_error_kpa)),
        speeds(row),
        speed(SPEED_TARGET),
        report.ticks,
    )
}

/// For a terminal.
#[must_use]
pub fn text(report: &Report) -> String {
    let mut out = String::new();
    for (head, rows) in tables(report) {
        let lines = || core::iter::once(&head).chain(&rows);
        let widths: Vec<usize> =
            (0..head.len()).map(|column| lines().map(|line| line[column].chars().count()).max().unwrap_or(0)).collect();
        for line in lines() {
            let cells: Vec<_> = line
                .iter()
                .zip(&widths)
                .enumerate()
                .map(
                    |(column, (cell, &width))| {
                        if column < 2 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
                    },
                )
                .collect();
            out += cells.join("  ").trim_end();
            out += "\n";
        }
        out += "\n";
    }
    out + &counts(report) + "\n" + &verdict(report) + "\n"
}

/// What stands between the markers of docs/simulator.md.
#[must_use]
pub fn markdown(report: &Report) -> String {
    let captions = [
        "The default scene, sorted by method and step. Error against the reference, at every millisecond, of the three \
         chambers; a choice is dominated when another is as fast and as good and better in one. Simulated s per s is wall \
         clock of one run on one machine, median and fastest round.",
        "The stiff cases: largest error of a chamber in kPa. Unstable: more than 1 kPa off in the last 50 ms.",
        "The scene's switches, with the default integrator. Errors against the fully modelled reference; the readings' \
         differences against the fully modelled plant with the same seed.",
        "Where the default's time goes: ticks cut off after each part, and the time from cut to cut. Wall clock of one run \
         on one machine.",
    ];
    let mut out = String::new();
    for (caption, (head, rows)) in captions.into_iter().zip(tables(report)) {
        out += &format!("{caption}\n\n| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len()));
        for row in rows {
            out += &format!("| {} |\n", row.join(" | "));
        }
        out += "\n";
    }
    out + &counts(report) + "\n\n" + &verdict(report) + "\n"
}

/// A row an integrator.
///
/// # Errors
/// When the writer fails, which it does not in memory.
pub fn csv(report: &Report) -> Result<String> {
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let mut head: Vec<String> = [
        "integrator",
        "step",
        "default",
        "dominated",
        "max_error_kpa",
        "rms_error_kpa",
        "max_bend_error_deg",
        "evaluations_per_tick",
        "simulated_seconds_per_second",
        "fastest_simulated_seconds_per_second",
        "closed_drift_nl",
    ]
    .map(str::to_owned)
    .to_vec();
    if let Some(row) = report.integrators.first() {
        head.extend(row.stiff.iter().map(|case| format!("max_error_kpa: {}", case.case)));
    }
    writer.write_record(&head)?;
    for row in &report.integrators {
        let mut cells = vec![
            row.integrator.to_owned(),
            row.step.clone(),
            row.default.to_string(),
            row.dominated.to_string(),
            format!("{:e}", row.max_error_kpa),
            format!("{:e}", row.rms_error_kpa),
            format!("{:e}", row.max_bend_error_deg),
            row.evaluations_per_tick.to_string(),
            format!("{:.0}", row.simulated_seconds_per_second),
            format!("{:.0}", row.fastest_simulated_seconds_per_second),
            format!("{:e}", row.closed_drift_nl),
        ];
        cells
            .extend(row.stiff.iter().map(|case| case.max_error_kpa.map_or_else(String::new, |kpa| format!("{kpa:e}"))));
        writer.write_record(&cells)?;
    }
    let bytes = writer.into_inner().map_err(|error| anyhow!("cannot write the table: {error}"))?;
    Ok(String::from_utf8(bytes)?)
}
