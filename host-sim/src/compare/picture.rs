//! The comparison drawn: how the regulators take the same references, and error against switchings.

use super::contender::Kind;
use super::scenario::Scenario;
use super::trial::Trial;
use super::{Report, trial};
use crate::drawing::{Area, INK, drawing, series_labels, styled, svg};
use anyhow::Result;
use model_core::actuation::Segment;
use plotters::prelude::*;

/// The chambers' colours, proximal first.
const CHAMBERS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

/// The longest part of a scenario that is drawn, ms: more would be too small to read.
const SHOWN_MS: usize = 9000;

fn colour(kind: Kind) -> RGBColor {
    match kind {
        Kind::BangBang => RGBColor(148, 152, 160),
        Kind::PwmPid => RGBColor(0, 114, 178),
        Kind::SlidingMode => RGBColor(0, 158, 115),
        Kind::Ours => RGBColor(213, 94, 0),
    }
}

/// True pressures over the references (thin black), a panel for each regulator, with the first seed.
///
/// # Errors
/// When a trial or the drawing backend fails.
pub fn traces(scenario: &Scenario) -> Result<String> {
    let trials = Kind::ALL
        .into_iter()
        .map(|kind| Ok((kind, trial::run(scenario, 1, kind.make().as_mut())?)))
        .collect::<Result<Vec<(Kind, Trial)>>>()?;
    svg((900, 860), &|area| {
        let (title, panels) = area.split_vertically(30);
        let style = ("sans-serif", 16, &INK).into_text_style(area);
        title.draw_text(&format!("{}: {}", scenario.name, scenario.description), &style, (56, 10)).map_err(drawing)?;
        let names = Segment::ALL.map(Segment::name).into_iter().zip(CHAMBERS).chain([("reference", INK)]);
        for (place, (name, ink)) in (0..).zip(names) {
            let style = ("sans-serif", 13, &ink).into_text_style(area);
            title.draw_text(name, &style, (580 + 78 * place, 12)).map_err(drawing)?;
        }
        let panels = panels.split_evenly((trials.len(), 1));
        for (place, ((kind, trial), panel)) in trials.iter().zip(&panels).enumerate() {
            trace_panel(*kind, trial, panel, place + 1 == trials.len())?;
        }
        Ok(())
    })
}

fn trace_panel(kind: Kind, trial: &Trial, panel: &Area<'_>, last: bool) -> Result<()> {
    let shown = &trial.moments[..trial.moments.len().min(SHOWN_MS)];
    let seconds = |at: usize| 1e-3 * at as f64;
    let highest = shown.iter().flat_map(|moment| moment.references_kpa).fold(10.0, f64::max);
    let mut chart = ChartBuilder::on(panel)
        .caption(kind.name(), ("sans-serif", 13, &INK))
        .margin_right(16)
        .x_label_area_size(if last { 36 } else { 18 })
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..seconds(shown.len()), 0.0..1.1 * highest)
        .map_err(drawing)?;
    let mut mesh = chart.configure_mesh();
    styled(&mut mesh)
        .label_style(("sans-serif", 11, &INK))
        .y_desc("kPa")
        .y_labels(5)
        .y_label_formatter(&|value| format!("{value:.0}"));
    if last {
        mesh.x_desc("s");
    }
    mesh.draw().map_err(drawing)?;
    for (i, ink) in CHAMBERS.iter().enumerate() {
        // A jump stays a jump: both its ends are kept.
        let points = |of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
            let kept = |at: &usize| {
                at.is_multiple_of(16)
                    || at + 1 == shown.len()
                    || trial.steps.iter().any(|step| step.at.abs_diff(*at) <= 1)
            };
            (0..shown.len()).filter(kept).map(|at| (seconds(at), of(at))).collect()
        };
        let truth = points(&|at| shown[at].chambers_kpa[i]);
        let reference = points(&|at| shown[at].references_kpa[i]);
        chart.draw_series(LineSeries::new(truth, ink.stroke_width(2))).map_err(drawing)?;
        chart.draw_series(LineSeries::new(reference, INK.stroke_width(1))).map_err(drawing)?;
    }
    Ok(())
}

/// Mean absolute error against switchings, a point for each scenario, a colour for each regulator; multi-step is larger.
///
/// # Errors
/// When the drawing backend fails.
pub fn error_against_switchings(report: &Report) -> Result<String> {
    let place =
        |row: &super::Row| (row.scores.switchings_per_min().max(1.0), row.scores.mean_absolute_error_kpa.max(0.01));
    let places: Vec<(f64, f64)> = report.rows.iter().map(place).collect();
    let range = |of: fn(&(f64, f64)) -> f64, room: f64| {
        let (low, high) =
            places.iter().map(of).fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        if low < high { low / room..high * room } else { 0.5..2.0 }
    };
    svg((900, 560), &|area| {
        let mut chart = ChartBuilder::on(area)
            .caption(
                "error against switchings, a point for each scenario (large: multi-step)",
                ("sans-serif", 16, &INK),
            )
            .margin(8)
            .margin_right(20)
            .x_label_area_size(44)
            .y_label_area_size(60)
            .build_cartesian_2d(range(|at| at.0, 1.5).log_scale(), range(|at| at.1, 1.3).log_scale())
            .map_err(drawing)?;
        styled(&mut chart.configure_mesh())
            .x_desc("switchings of valves and relay a minute")
            .y_desc("mean absolute error, kPa")
            .x_label_formatter(&|value| format!("{value:.0}"))
            .y_label_formatter(&|value| format!("{value}"))
            .draw()
            .map_err(drawing)?;
        for kind in Kind::ALL {
            let rows = report.rows.iter().filter(|row| row.regulator == kind.name());
            let ink = colour(kind);
            let point = |row: &super::Row| {
                Circle::new(place(row), if row.scenario == "multi-step" { 8 } else { 4 }, ink.filled())
            };
            chart
                .draw_series(rows.map(point))
                .map_err(drawing)?
                .label(kind.name())
                .legend(move |(x, y)| Circle::new((x + 8, y), 5, ink.filled()));
        }
        series_labels(&mut chart, SeriesLabelPosition::UpperRight)
    })
}
