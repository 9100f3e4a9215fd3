//! Error against time, one point a method.

use super::{Report, Row};
use crate::drawing::{Bounds, FAINT, INK, drawing, overlap, styled, svg};
use crate::methods::Direction;
use anyhow::Result;
use plotters::prelude::*;

const DOMINATED: RGBColor = RGBColor(160, 165, 172);
const BEST: RGBColor = RGBColor(0, 114, 178);
const SIZE: (u32, u32) = (900, 560);
/// Pixels a character of a label, and its height.
const CHARACTER: (i32, i32) = (7, 14);

/// Whether another method is at least as good in both and better in one.
fn is_dominated(row: &Row, rows: &[&Row]) -> bool {
    let key = |row: &Row| (row.errors.max_working, row.host_time_ratio);
    let (error, time) = key(row);
    rows.iter().map(|other| key(other)).any(|(e, t)| e <= error && t <= time && (e < error || t < time))
}

/// Places for labels beside their points, so that none covers another or a point: the nearest free one.
fn place_labels(points: &[(i32, i32)], lengths: &[usize], bounds: Bounds) -> Vec<(i32, i32)> {
    let mut taken: Vec<Bounds> = points.iter().map(|&(x, y)| [x - 5, y - 5, x + 5, y + 5]).collect();
    let mut placed = Vec::new();
    for (&(x, y), &length) in points.iter().zip(lengths) {
        let (width, height) = (CHARACTER.0 * length as i32, CHARACTER.1);
        // Rings of places around the point, nearest first.
        let candidates = (0..14).flat_map(|ring| {
            let away = 8 + 12 * ring;
            [
                (x + away, y - height / 2),
                (x - away - width, y - height / 2),
                (x - width / 2, y - away - height),
                (x - width / 2, y + away),
                (x + away, y - away - height / 2),
                (x + away, y + away - height / 2),
                (x - away - width, y - away - height / 2),
                (x - away - width, y + away - height / 2),
            ]
        });
        let rectangle = |(left, top): (i32, i32)| [left, top, left + width, top + height];
        let free = |place: &(i32, i32)| {
            let [left, top, right, bottom] = rectangle(*place);
            let inside = left >= bounds[0] && top >= bounds[1] && right <= bounds[2] && bottom <= bounds[3];
            inside && !taken.iter().any(|&other| overlap(other, rectangle(*place)))
        };
        let place = candidates.into_iter().find(free).unwrap_or((x + 8, y - height / 2));
        taken.push(rectangle(place));
        placed.push(place);
    }
    placed
}

/// A label at 1, 2 and 5 times a power of ten, and none in between, where they would crowd.
fn tick(value: f64) -> String {
    let text = format!("{value:.0e}");
    if text.starts_with(['1', '2', '5']) {
        text.parse::<f64>().map(|rounded| rounded.to_string()).unwrap_or_default()
    } else {
        String::new()
    }
}

/// The picture of one direction: the worst error over the working range with the default calibration against the time
/// on this host, both logarithmic. Methods that another beats in both are grey.
pub fn picture(report: &Report, direction: Direction) -> Result<String> {
    let rows: Vec<&Row> = report.of(direction).collect();
    let span = |values: &dyn Fn(&Row) -> f64, below: f64, above: f64| {
        let all = || rows.iter().map(|row| values(row).max(1e-16));
        (all().fold(f64::INFINITY, f64::min) * below)..(all().fold(0.0, f64::max) * above)
    };
    let times = span(&|row| row.host_time_ratio, 0.7, 1.6);
    let errors = span(&|row| row.errors.max_working, 0.3, 3.0);
    let (title, unit) = match direction {
        Direction::BendFromPressure => ("Bend from pressure", "worst error over 0..150 kPa, degrees"),
        Direction::PressureFromBend => ("Pressure from bend", "worst error over 0..150 kPa, kPa"),
    };
    svg(SIZE, &|area| {
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 16, &INK))
            .margin(8)
            .margin_right(16)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .build_cartesian_2d(times.clone().log_scale(), errors.clone().log_scale())
            .map_err(drawing)?;
        styled(&mut chart.configure_mesh())
            .x_label_formatter(&|&value| tick(value))
            .y_label_formatter(&|value| format!("{value:.0e}"))
            .x_desc("time on this host in one run, f64-newton = 1")
            .y_desc(unit)
            .draw()
            .map_err(drawing)?;
        let at = |row: &Row| chart.backend_coord(&(row.host_time_ratio, row.errors.max_working.max(1e-16)));
        let points: Vec<_> = rows.iter().map(|row| at(row)).collect();
        let lengths: Vec<_> = rows.iter().map(|row| row.method.len()).collect();
        let (across, down) = chart.plotting_area().get_pixel_range();
        let labels = place_labels(&points, &lengths, [across.start, down.start, across.end, down.end]);
        for ((row, &point), &label) in rows.iter().zip(&points).zip(&labels) {
            let colour = if is_dominated(row, &rows) { DOMINATED } else { BEST };
            let width = CHARACTER.0 * row.method.len() as i32;
            let nearest = (point.0.clamp(label.0, label.0 + width), label.1 + CHARACTER.1 / 2);
            if (nearest.0 - point.0).abs() + (nearest.1 - point.1).abs() > 24 {
                area.draw(&PathElement::new([point, nearest], FAINT)).map_err(drawing)?;
            }
            area.draw(&Circle::new(point, 4, colour.filled())).map_err(drawing)?;
            area.draw(&Text::new(row.method, label, ("sans-serif", 13).into_font().color(&colour))).map_err(drawing)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_cover_neither_each_other_nor_a_point() {
        // A crowd in a corner, a column, and a point alone.
        let points = [(100, 100), (104, 102), (98, 108), (100, 120), (100, 130), (100, 140), (700, 400)];
        let lengths = [10, 17, 14, 12, 18, 13, 9];
        let labels = place_labels(&points, &lengths, [80, 20, 880, 540]);
        let boxes: Vec<Bounds> = labels
            .iter()
            .zip(lengths)
            .map(|(&(x, y), length)| [x, y, x + CHARACTER.0 * length as i32, y + CHARACTER.1])
            .collect();
        for (index, &a) in boxes.iter().enumerate() {
            assert!(boxes[..index].iter().all(|&b| !overlap(a, b)), "label {index} covers another");
            assert!(points.iter().all(|&(x, y)| !overlap(a, [x, y, x + 1, y + 1])), "label {index} covers a point");
            assert!(a[0] >= 80 && a[2] <= 880 && a[1] >= 20 && a[3] <= 540);
        }
    }
}
