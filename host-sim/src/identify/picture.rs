//! The identified curves over the true ones, and what is left of the bends' errors.

use super::Report;
use crate::drawing::{Area, FAINT, INK, drawing, series_labels, styled, svg};
use crate::report::plots::SEGMENT_COLOURS;
use anyhow::Result;
use model_core::calibration;
use plotters::prelude::*;

/// Pressure against bend on the left, errors on the right.
pub fn draw(report: &Report) -> Result<String> {
    svg((1100, 420), &|area| {
        let (left, right) = area.split_horizontally(520);
        curves(&left, report)?;
        errors(&right, report)
    })
}

fn curves(area: &Area<'_>, report: &Report) -> Result<()> {
    let mut chart = ChartBuilder::on(area)
        .caption("Bend against pressure: true, and identified (dots)", ("sans-serif", 15, &INK))
        .margin(6)
        .x_label_area_size(32)
        .y_label_area_size(48)
        .build_cartesian_2d(0.0..150.0, 0.0..120.0)
        .map_err(drawing)?;
    styled(&mut chart.configure_mesh()).x_desc("kPa").y_desc("degrees").draw().map_err(drawing)?;
    let along = |c: [f64; 3]| (0..=150).map(f64::from).map(move |kpa| (kpa, calibration::bend_deg(c, kpa)));
    let default = calibration::DEFAULT.to_f64_kpa();
    chart
        .draw_series(LineSeries::new(along(default), INK.mix(0.4).stroke_width(1)))
        .map_err(drawing)?
        .label("before")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 16, y)], INK.mix(0.4)));
    for (found, colour) in report.segments.iter().zip(SEGMENT_COLOURS) {
        chart
            .draw_series(LineSeries::new(along(found.true_kpa), colour.stroke_width(2)))
            .map_err(drawing)?
            .label(found.segment)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour));
        let dots = along(found.identified_kpa).step_by(10).map(|at| Circle::new(at, 3, colour.filled()));
        chart.draw_series(dots).map_err(drawing)?;
    }
    series_labels(&mut chart, SeriesLabelPosition::LowerRight)
}

fn errors(area: &Area<'_>, report: &Report) -> Result<()> {
    let most = report.worst_before_deg.max(2.0) * 1.1;
    let count = report.after.len() as f64;
    let mut chart = ChartBuilder::on(area)
        .caption(
            "Error of each segment's bend: before (rings), after (dots); 1 degree shaded",
            ("sans-serif", 15, &INK),
        )
        .margin(6)
        .x_label_area_size(32)
        .y_label_area_size(48)
        .build_cartesian_2d(0.0..count + 1.0, -most..most)
        .map_err(drawing)?;
    styled(&mut chart.configure_mesh())
        .disable_x_mesh()
        .x_desc("bends asked for, in the table's order")
        .y_desc("degrees")
        .draw()
        .map_err(drawing)?;
    chart.draw_series([Rectangle::new([(0.0, -1.0), (count + 1.0, 1.0)], FAINT.mix(0.5).filled())]).map_err(drawing)?;
    for (index, colour) in SEGMENT_COLOURS.into_iter().enumerate() {
        let at = |row: usize, error: f64| (row as f64 + 0.85 + 0.15 * index as f64, error);
        let rings = report
            .before
            .iter()
            .enumerate()
            .map(|(row, held)| Circle::new(at(row, held.error_deg[index]), 4, colour.stroke_width(1)));
        chart.draw_series(rings).map_err(drawing)?;
        let dots = report
            .after
            .iter()
            .enumerate()
            .map(|(row, held)| Circle::new(at(row, held.error_deg[index]), 3, colour.filled()));
        chart.draw_series(dots).map_err(drawing)?;
    }
    Ok(())
}
