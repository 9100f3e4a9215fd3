//! Error against speed as SVG.

use super::{ERROR_TARGET_KPA, IntegratorRow, Report, SPEED_TARGET};
use crate::drawing::{Bounds, INK, drawing, overlap, styled, svg};
use anyhow::Result;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const GREY: RGBColor = RGBColor(176, 180, 188);
const DIM: RGBColor = RGBColor(120, 125, 134);
const FRONT: RGBColor = RGBColor(0, 114, 178);
const DEFAULT: RGBColor = RGBColor(213, 94, 0);

/// Errors above this are drawn at the upper edge: those have failed.
const TOP_KPA: f64 = 100.0;

fn colour(row: &IntegratorRow) -> RGBColor {
    if row.default {
        DEFAULT
    } else if row.dominated {
        GREY
    } else {
        FRONT
    }
}

/// Width and height of the drawing, pixels.
const SIZE: (u32, u32) = (900, 560);

/// Where the diagram begins, pixels.
const LEFT: i32 = 80;

/// Height of a label, pixels.
const LABEL_HEIGHT: i32 = 10;

/// Width of a label, pixels, generously.
fn label_width(label: &str) -> i32 {
    label.chars().count() as i32 * 47 / 10
}

/// A number that starts with 1, 2 or 5; nothing for the others, whose labels would run into each other.
fn round_number(value: f64) -> String {
    let text = format!("{value:.0}");
    if text.starts_with(['1', '2', '5']) { text } else { String::new() }
}

/// Where a label of a point covers nothing that is taken: right or left of it, as little above or below as can be, and
/// within the width of the drawing.
fn free_area(taken: &[Bounds], (x, y): (i32, i32), radius: i32, width: i32) -> Bounds {
    let area = |left: i32, shift: i32| {
        let top = y + shift - LABEL_HEIGHT / 2;
        [left, top, left + width, top + LABEL_HEIGHT + 2]
    };
    let right = x + radius + 3;
    let left = x - radius - 3 - width;
    (0..60)
        .flat_map(|shift| [area(right, shift), area(right, -shift), area(left, shift), area(left, -shift)])
        .find(|&spot| spot[0] > LEFT && spot[2] < SIZE.0 as i32 && !taken.iter().any(|&other| overlap(spot, other)))
        .unwrap_or_else(|| area(right, 0))
}

/// Every choice as a point; dominated ones are grey, the default is marked, the targets are dashed.
///
/// # Errors
/// When the drawing backend fails.
pub fn picture(report: &Report) -> Result<String> {
    let speeds = || report.integrators.iter().map(|row| row.fastest_simulated_seconds_per_second);
    let errors = || report.integrators.iter().map(|row| row.max_error_kpa.min(TOP_KPA));
    let x = (speeds().fold(SPEED_TARGET, f64::min) / 1.5, speeds().fold(SPEED_TARGET, f64::max) * 2.5);
    let y = (errors().fold(ERROR_TARGET_KPA, f64::min) / 2.0, errors().fold(ERROR_TARGET_KPA, f64::max) * 2.0);
    svg(SIZE, &|area| {
        let mut chart = ChartBuilder::on(area)
            .caption("integrators of the plant: error against speed", ("sans-serif", 16, &INK))
            .margin(8)
            .x_label_area_size(44)
            .y_label_area_size(66)
            .build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale())
            .map_err(drawing)?;
        styled(&mut chart.configure_mesh())
            .x_desc("simulated seconds in a second, one core, fastest round")
            .y_desc("largest error of a chamber, kPa")
            .x_label_formatter(&|value| round_number(*value))
            .y_label_formatter(&|value| if *value < 0.01 { format!("{value:.0e}") } else { format!("{value}") })
            .draw()
            .map_err(drawing)?;
        let targets = [[(SPEED_TARGET, y.0), (SPEED_TARGET, y.1)], [(x.0, ERROR_TARGET_KPA), (x.1, ERROR_TARGET_KPA)]];
        for [from, to] in targets {
            let dashed = DashedLineSeries::new([from, to], 5, 5, INK.stroke_width(1));
            chart.draw_series(dashed).map_err(drawing)?;
        }
        let place = |row: &IntegratorRow| (row.fastest_simulated_seconds_per_second, row.max_error_kpa.min(TOP_KPA));
        let radius = |row: &IntegratorRow| if row.default { 7 } else { 4 };
        // Those that matter lie on top and choose their labels' places first.
        let mut rows: Vec<&IntegratorRow> = report.integrators.iter().collect();
        rows.sort_by_key(|row| (!row.default, row.dominated));
        let mut taken: Vec<Bounds> = Vec::new();
        for row in rows.iter().rev() {
            chart
                .draw_series(core::iter::once(Circle::new(place(row), radius(row), colour(row).filled())))
                .map_err(drawing)?;
            let ((x, y), r) = (chart.backend_coord(&place(row)), radius(row));
            taken.push([x - r, y - r, x + r, y + r]);
        }
        for row in rows {
            let mark = if row.default { " (default)" } else { "" };
            let label = format!("{}, {}{mark}", row.integrator, row.step);
            let ink = if row.dominated && !row.default { DIM } else { INK };
            let style = ("sans-serif", LABEL_HEIGHT, &ink).into_text_style(area);
            let (x, y) = chart.backend_coord(&place(row));
            let spot = free_area(&taken, (x, y), radius(row), label_width(&label));
            taken.push(spot);
            // A label that had to go elsewhere is tied to its point.
            let middle = i32::midpoint(spot[1], spot[3]);
            if (middle - y).abs() > LABEL_HEIGHT {
                let end = if spot[0] > x { spot[0] - 1 } else { spot[2] + 1 };
                area.draw(&PathElement::new(vec![(x, y), (end, middle)], GREY.stroke_width(1))).map_err(drawing)?;
            }
            // The targets' lines end at a label.
            let paper = [(spot[0], spot[1]), (spot[2], spot[3])];
            area.draw(&Rectangle::new(paper, WHITE.filled())).map_err(drawing)?;
            // Against its point, whatever the reader's letters measure.
            let (style, end) =
                if spot[0] > x { (style, spot[0]) } else { (style.pos(Pos::new(HPos::Right, VPos::Top)), spot[2]) };
            area.draw_text(&label, &style, (end, spot[1])).map_err(drawing)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_cover_neither_points_nor_each_other() {
        let points = [(100, 200), (102, 203), (110, 200), (160, 201), (880, 200)];
        let mut taken: Vec<Bounds> = points.iter().map(|&(x, y)| [x - 4, y - 4, x + 4, y + 4]).collect();
        for point in points {
            let spot = free_area(&taken, point, 4, 80);
            assert!(!taken.iter().any(|&other| overlap(spot, other)), "{taken:?} {spot:?}");
            assert!(spot[2] < SIZE.0 as i32, "{spot:?}");
            taken.push(spot);
        }
        // Where nothing is in its way it stands to the right of its point.
        assert_eq!(free_area(&taken, (500, 200), 4, 80)[0], 507);
    }
}
