//! The fitted curves through their points, and what is left of the points: a panel a segment.

use super::Report;
use super::estimate::{Estimate, Point};
use crate::drawing::{Area, Chart, INK, drawing, series_labels, styled, svg};
use crate::report::plots::SEGMENT_COLOURS;
use anyhow::Result;
use core::ops::Range;
use model_core::actuation::Segment;
use model_core::calibration::bend_deg;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// A panel's size, pixels.
const PANEL: (u32, u32) = (560, 400);
/// What is not like the others.
const OUTLIER: RGBColor = RGBColor(200, 30, 60);
/// The pressures shown, kPa.
const SHOWN_KPA: (f64, f64) = (0.0, 160.0);

fn colour(found: &Estimate) -> RGBColor {
    let index = Segment::ALL.iter().position(|segment| segment.name() == found.segment);
    SEGMENT_COLOURS[index.unwrap_or(0)]
}

/// A panel's axes: degrees over pressure.
fn axes<'a, 'b>(
    area: &'a Area<'b>,
    title: &str,
    shown_deg: Range<f64>,
    label: &dyn Fn(&f64) -> String,
) -> Result<Chart<'a, 'b>> {
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 15, &INK))
        .margin(8)
        .margin_right(16)
        .x_label_area_size(36)
        .y_label_area_size(52)
        .build_cartesian_2d(SHOWN_KPA.0..SHOWN_KPA.1, shown_deg)
        .map_err(drawing)?;
    styled(&mut chart.configure_mesh())
        .x_labels(9)
        .x_desc("gauge pressure, kPa")
        .y_desc("degrees of one segment")
        .x_label_formatter(&|value| format!("{value:.0}"))
        .y_label_formatter(label)
        .draw()
        .map_err(drawing)?;
    Ok(chart)
}

fn panels(report: &Report, draw: impl Fn(&Area<'_>, &Estimate) -> Result<()>) -> Result<String> {
    let count = report.segments.len().max(1);
    svg((PANEL.0 * count as u32, PANEL.1), &|area| {
        area.split_evenly((1, count)).iter().zip(&report.segments).try_for_each(|(part, found)| draw(part, found))
    })
}

/// Pressures at which curves are drawn: close together where they are steep.
fn along() -> impl Iterator<Item = f64> {
    (0..=200).map(|part| 150.0 * (f64::from(part) / 200.0).powi(2))
}

/// Bend against pressure: points, curve, and the curve's 95 % interval.
///
/// # Errors
/// When the drawing backend fails.
pub fn fit(report: &Report) -> Result<String> {
    panels(report, |area, found| {
        let colour = colour(found);
        let curve: Vec<(f64, f64)> = along().map(|kpa| (kpa, bend_deg(found.coefficients_kpa, kpa))).collect();
        let highest = found.points.iter().map(|point| point.bend_deg).chain(curve.last().map(|end| end.1));
        let top = highest.fold(30.0, f64::max) * 1.08;
        let title = format!("bend against pressure, segment {}", found.segment);
        let mut chart = axes(area, &title, 0.0..top, &|value| format!("{value:.0}"))?;
        let sides = |sign: f64| {
            let side = move |&(kpa, deg): &(f64, f64)| Some((kpa, (deg + sign * found.half_width_deg(kpa)?).max(0.0)));
            curve.iter().skip(1).filter_map(side).collect::<Vec<_>>()
        };
        let mut band = sides(1.0);
        band.extend(sides(-1.0).into_iter().rev());
        if !band.is_empty() {
            chart
                .draw_series([Polygon::new(band, colour.mix(0.25).filled())])
                .map_err(drawing)?
                .label("95 % of the curve")
                .legend(move |(x, y)| Rectangle::new([(x, y - 4), (x + 18, y + 4)], colour.mix(0.25).filled()));
        }
        chart
            .draw_series(LineSeries::new(curve, colour.stroke_width(2)))
            .map_err(drawing)?
            .label("fit")
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        chart
            .draw_series(found.points.iter().map(|p| Circle::new((p.pressure_kpa, p.bend_deg), 3, INK.stroke_width(1))))
            .map_err(drawing)?
            .label("measured")
            .legend(|(x, y)| Circle::new((x + 9, y), 3, INK.stroke_width(1)));
        let out: Vec<&Point> = found.points.iter().filter(|point| point.outlier).collect();
        if !out.is_empty() {
            let rings = out.iter().map(|p| Circle::new((p.pressure_kpa, p.bend_deg), 7, OUTLIER.stroke_width(2)));
            chart
                .draw_series(rings)
                .map_err(drawing)?
                .label("outlier")
                .legend(|(x, y)| Circle::new((x + 9, y), 6, OUTLIER.stroke_width(2)));
        }
        series_labels(&mut chart, SeriesLabelPosition::LowerRight)
    })
}

/// Residuals against pressure: each point, the levels' means, and the band that 95 % of the points should lie in.
///
/// # Errors
/// When the drawing backend fails.
pub fn residuals(report: &Report) -> Result<String> {
    panels(report, |area, found| {
        let colour = colour(found);
        let band = 1.96 * found.scatter_deg.unwrap_or(0.0);
        let largest = found.points.iter().map(|point| point.residual_deg.abs()).fold(band.max(0.1), f64::max) * 1.2;
        let title = format!("measured bend less the fit, segment {}", found.segment);
        let mut chart = axes(area, &title, -largest..largest, &RangedCoordf64::format)?;
        chart
            .draw_series([Rectangle::new([(SHOWN_KPA.0, -band), (SHOWN_KPA.1, band)], colour.mix(0.12).filled())])
            .map_err(drawing)?;
        chart
            .draw_series(LineSeries::new([(SHOWN_KPA.0, 0.0), (SHOWN_KPA.1, 0.0)], INK.stroke_width(1)))
            .map_err(drawing)?;
        let means = found.levels.iter().map(|level| {
            let (kpa, deg) = (level.pressure_kpa, level.residual_deg);
            PathElement::new([(kpa - 4.0, deg), (kpa + 4.0, deg)], colour.stroke_width(3))
        });
        chart.draw_series(means).map_err(drawing)?;
        chart
            .draw_series(
                found.points.iter().map(|p| Circle::new((p.pressure_kpa, p.residual_deg), 3, INK.stroke_width(1))),
            )
            .map_err(drawing)?;
        for point in found.points.iter().filter(|point| point.outlier) {
            let at = (point.pressure_kpa, point.residual_deg);
            // Towards the middle, so that it stays inside.
            let beside = if point.pressure_kpa > 80.0 { -62 } else { 11 };
            let label =
                Text::new(point.place.clone(), (beside, -6), ("sans-serif", 12, &OUTLIER).into_text_style(area));
            let ring = Circle::new((0, 0), 7, OUTLIER.stroke_width(2));
            chart.draw_series([EmptyElement::at(at) + ring + label]).map_err(drawing)?;
        }
        Ok(())
    })
}
