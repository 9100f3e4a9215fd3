//! The report as text and as the tables of the documents.

use super::kinematics::Kinematics;
use super::points::Fit;
use super::{Report, bend, equations, force};
use core::fmt::Write as _;

const NOT_GIVEN: &str = "not given";

fn verdict(passed: bool) -> &'static str {
    if passed { "pass" } else { "**fail**" }
}

/// A table of Markdown.
fn table(head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut out = format!("| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len()));
    for row in rows {
        let _ = writeln!(out, "| {} |", row.join(" | "));
    }
    out
}

fn bend_rows(rows: &[bend::Row]) -> String {
    let points = rows.iter().flat_map(|row| {
        row.points.iter().map(|point| {
            vec![
                row.name.to_owned(),
                format!("{:.0}", point.pressure_kpa),
                format!("{:.1}", point.measured_deg),
                format!("{:.2}", point.ours_deg),
                format!("{:+.2}", point.error_deg),
                format!("{:+.2}", point.error_percent),
                format!("{:+.2} ({:+.2})", point.left_out_error_deg, point.left_out_error_percent),
            ]
        })
    });
    table(&["Row", "kPa", "Measured, deg", "Ours, deg", "Error, deg", "Error, %", "Left out: deg (%)"], points)
}

fn bend_verdicts(report: &Report) -> String {
    let rows = report.bend.iter().map(|row| {
        let [k, c1, c2] = row.coefficients_kpa;
        vec![
            row.name.to_owned(),
            format!("{k:.3}, {c1:.4}, {c2:.4}"),
            format!("{:.2}", row.worst_percent),
            verdict(row.passed).to_owned(),
            format!("{:.2}", row.fem_150_deg),
            format!("{:+.1}", row.fem_against_measured_percent),
        ]
    });
    let target = format!("Within {} %", report.bend_target_percent);
    table(
        &["Row", "k, c1, c2, kPa", "Worst error, %", &target, "Paper's FEM at 150 kPa, deg", "FEM against measured, %"],
        rows,
    )
}

fn force_rows(rows: &[force::Row]) -> String {
    let points = rows.iter().flat_map(|row| {
        row.points.iter().map(|point| {
            vec![
                row.name.to_owned(),
                format!("{:.0}", point.pressure_kpa),
                format!("{:.2}", point.measured_n),
                format!("{:.3}", point.ours_n),
                format!("{:+.2}", point.error_percent),
                format!("{:+.1}", point.line_error_percent),
                point.left_out_error_percent.map_or_else(|| "-".to_owned(), |percent| format!("{percent:+.1}")),
            ]
        })
    });
    table(&["Row", "kPa", "Measured, N", "Ours, N", "Error, %", "One line, %", "Left out, %"], points)
}

fn force_verdicts(report: &Report) -> String {
    let rows = report.force.iter().map(|row| {
        vec![
            row.name.to_owned(),
            format!("{:.2}", row.worst_percent),
            verdict(row.passed).to_owned(),
            format!("{:.5}", row.correlation_r),
            format!("{:.5}", row.slope_n_per_kpa),
            format!("{:+.3}", row.intercept_n),
            format!("{:.1}", row.line_worst_percent),
            format!("{:.2} ({:+.1} %)", row.fem_150_n, row.fem_against_measured_percent),
        ]
    });
    let target = format!("Within {} %", report.force_target_percent);
    table(
        &[
            "Row",
            "Worst error, %",
            &target,
            "r",
            "Slope, N/kPa",
            "At 0 kPa, N",
            "Line's worst error, %",
            "FEM at 150 kPa, N (against measured)",
        ],
        rows,
    )
}

fn combination_rows(report: &Report) -> String {
    let rows = report.combinations.iter().map(|row| {
        let [x, y] = row.fingertip_mm;
        vec![
            row.segments.to_owned(),
            format!("{:.0}", row.pressure_kpa),
            row.bends_deg.map(|bend| format!("{bend:.1}")).join(" / "),
            format!("{x:.1}, {y:.1}"),
            format!("{:.1}", row.direction_deg),
            format!("{:.2}", row.force_n),
            row.paper.to_owned(),
        ]
    });
    table(&["Pressed", "kPa", "Bends, deg", "Fingertip x, y, mm", "Direction, deg", "Force, N", "Paper"], rows)
}

fn equation_rows(rows: &[equations::Row]) -> String {
    let rows = rows.iter().map(|row| {
        vec![
            format!("{:.0}", row.bend_deg),
            format!("{:.4}", row.stretch),
            format!("{:.3} / {:.3}", row.printed_volume, row.corrected_volume),
            format!("{:+.4} / {:.4}", row.printed_energy_slope_mpa, row.corrected_energy_slope_mpa),
            format!("{:+.3} / {:.3}", row.printed_stretch_slope, row.corrected_stretch_slope),
            format!("{:+.4} / {:.4}", row.printed_work_mpa, row.corrected_work_mpa),
            format!("{:.2}", row.calibrated_pressure_kpa),
        ]
    });
    table(
        &["Bend, deg", "λ (13)", "λ₁λ₂λ₃ (2)", "dW/dλ, MPa (6), (15)", "dλ/dα (16)", "dW/dα, MPa", "Calibrated P, kPa"],
        rows,
    )
}

/// The part of docs/paper.md.
pub fn paper(report: &Report) -> String {
    let cavity = &report.small_cavity;
    let [_, at_30] = equations::work_over_pressure(30.0);
    let [_, at_150] = equations::work_over_pressure(150.0);
    let mut out = format!(
        "### Bend: Table 2, figures 13, 23, 38, 41\n\n{}\n{}\n",
        bend_verdicts(report),
        bend_rows(&report.bend)
    );
    let _ = writeln!(
        out,
        "One small cavity at 150 kPa: finite elements {:.2} deg, a fifth of their chamber {:.2} deg; ours, a fifth of the \
         measured chamber, {:.2} deg ({:+.1} %). At other pressures, and measured: {NOT_GIVEN}.\n",
        cavity.fem_150_deg, cavity.fem_chamber_share_deg, cavity.ours_deg, cavity.error_percent
    );
    let _ = writeln!(
        out,
        "### Driving force: Table 3, figures 24, 42\n\n{}\n{}",
        force_verdicts(report),
        force_rows(&report.force)
    );
    let _ = writeln!(
        out,
        "Finger to chamber with exoskeleton: {:.3} at 150 kPa (the 1.71), {:.3} as the ratio of the slopes. One small \
         cavity: {:.1} N by finite elements at 150 kPa; measured: {NOT_GIVEN}.\n",
        report.force_ratio.at_150_kpa,
        report.force_ratio.of_slopes,
        model_core::paper::FEM_SMALL_CAVITY_N
    );
    let _ = writeln!(out, "### Segment combinations: figures 25 to 31\n\n{}", combination_rows(report));
    let _ = writeln!(
        out,
        "### Equations: as printed / corrected, and calibrated\n\n{}\nWere the corrected form right up to one factor in \
         front, its dW/dα over the pressure would be constant; it is {at_30:.2} at the bend of 30 kPa and {at_150:.2} at \
         that of 150 kPa.",
        equation_rows(&report.equations)
    );
    out
}

fn fit_row(fit: &Fit) -> Vec<String> {
    let open = if fit.open_mm.is_empty() {
        "nothing".to_owned()
    } else {
        fit.open_mm.iter().map(|(name, value)| format!("{name} {value:.1}")).collect::<Vec<_>>().join(", ")
    };
    vec![
        fit.reading.to_owned(),
        fit.meaning.to_owned(),
        fit.points.to_owned(),
        open,
        fit.degrees_of_freedom.to_string(),
        format!("{:.2}", fit.rms_mm),
        format!("{:.2} ({:.1} %)", fit.worst_mm, fit.worst_percent),
    ]
}

/// The part of docs/kinematics.md.
pub fn kinematics(kinematics: &Kinematics) -> String {
    let errors = &kinematics.errors;
    let row = |name: &str, mean: f64, worst: f64| vec![name.to_owned(), format!("{mean:.2}"), format!("{worst:.2}")];
    let mut out = table(
        &["Against f64, µm", "Mean", "Worst"],
        [
            row("forward, fixed point", errors.fixed_mean_um, errors.fixed_worst_um),
            row("forward, f32 with micromath", errors.micromath_mean_um, errors.micromath_worst_um),
            row("inverse, fixed point: the place reached", errors.inverse_mean_um, errors.inverse_worst_um),
        ],
    );
    let _ = writeln!(
        out,
        "\n{} postures, 0 to 110 degrees by 5 in each segment; the inverse starts from 30/30/30 degrees and lost {} of the \
         places. Three rigid links of 44, 44 and 42 mm in place of the arcs would put the fingertip {:.1} mm elsewhere on \
         average, {:.1} mm at most.\n",
        errors.postures, errors.inverse_lost, errors.arcs_against_links_mean_mm, errors.arcs_against_links_worst_mm
    );
    let legs = kinematics.legs.iter().map(|legs| {
        let list = |values: [f64; 3]| values.map(|value| format!("{value:.1}")).join(" / ");
        vec![
            legs.points.to_owned(),
            list(legs.lengths_mm),
            list(legs.directions_deg),
            format!("{:.1}", legs.turn_at_b_deg),
        ]
    });
    let head = ["Points", "Legs OA / AB / BC, mm", "Directions, deg", "Turn at B, deg"];
    let [arcs, by_sum, before] = kinematics.turns_at_b_deg;
    let _ = writeln!(
        out,
        "{}\nWhatever the lengths, the turn at B is {arcs:.1} deg for equal arcs, {by_sum:.1} deg for links turned by the \
         sum of the bends, {before:.1} deg for links before their joint.\n",
        table(&head, legs)
    );
    let head = [
        "Reading",
        "What A, B, C are",
        "Points",
        "Open, fitted, mm",
        "Degrees of freedom left",
        "RMS, mm",
        "Worst, mm",
    ];
    out + &table(&head, kinematics.fits.iter().map(fit_row))
}

/// What the command prints.
pub fn text(report: &Report) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "Bend, Table 2 (target {} %):", report.bend_target_percent);
    for row in &report.bend {
        let left_out = row.points.iter().map(|point| point.left_out_error_percent.abs()).fold(0.0, f64::max);
        let _ = writeln!(
            out,
            "  {}  {:<22} worst {:.2} %, worst left-out point {left_out:.2} %; paper's FEM at 150 kPa {:+.1} %",
            if row.passed { "pass" } else { "FAIL" },
            row.name,
            row.worst_percent,
            row.fem_against_measured_percent
        );
    }
    let _ = writeln!(out, "Force, Table 3 (target {} %):", report.force_target_percent);
    for row in &report.force {
        let _ = writeln!(
            out,
            "  {}  {:<22} worst {:.2} %; r {:.5}, slope {:.5} N/kPa; one straight line is off by up to {:.1} %",
            if row.passed { "pass" } else { "FAIL" },
            row.name,
            row.worst_percent,
            row.correlation_r,
            row.slope_n_per_kpa,
            row.line_worst_percent
        );
    }
    let _ = writeln!(out, "  finger to chamber at 150 kPa: {:.3}", report.force_ratio.at_150_kpa);
    let _ = writeln!(out, "Points A, B, C, measured (no link lengths given: each reading fitted):");
    for fit in report.kinematics.fits.iter().filter(|fit| fit.points == "measured") {
        let _ = writeln!(
            out,
            "  {:<34} rms {:6.2} mm, worst {:6.2} mm, {} degrees of freedom left",
            fit.reading, fit.rms_mm, fit.worst_mm, fit.degrees_of_freedom
        );
    }
    let errors = &report.kinematics.errors;
    let _ = writeln!(
        out,
        "Kinematics against f64: fixed point {:.2} um, micromath {:.1} um; there and back {:.2} um",
        errors.fixed_worst_um, errors.micromath_worst_um, errors.inverse_worst_um
    );
    out
}
