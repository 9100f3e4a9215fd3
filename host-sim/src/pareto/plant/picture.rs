//! Error against speed as SVG.

use super::{ERROR_TARGET_KPA, IntegratorRow, Report, SPEED_TARGET};
use anyhow::{Result, anyhow};
use plotters::prelude::*;

const INK: RGBColor = RGBColor(60, 64, 72);
const FAINT: RGBColor = RGBColor(226, 229, 234);
const GREY: RGBColor = RGBColor(176, 180, 188);
const FRONT: RGBColor = RGBColor(0, 114, 178);
const DEFAULT: RGBColor = RGBColor(213, 94, 0);

#[expect(clippy::needless_pass_by_value, reason = "the form that map_err takes")]
fn drawing<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> anyhow::Error {
    anyhow!("cannot draw: {error}")
}

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

/// Height of a label, pixels.
const LABEL_HEIGHT: i32 = 10;

/// Width of a label, pixels, generously.
fn label_width(label: &str) -> i32 {
    label.chars().count() as i32 * 6
}

/// The spot nearest below or above at which a label covers no earlier one.
fn free_spot(taken: &[(i32, i32)], (x, y): (i32, i32), width: i32) -> (i32, i32) {
    let free = |y: i32| {
        taken.iter().all(|&(other_x, other_y)| (other_y - y).abs() > LABEL_HEIGHT || (other_x - x).abs() > width)
    };
    let nearest = (0..40).flat_map(|step| [y + step, y - step]).find(|&y| free(y));
    (x, nearest.unwrap_or(y))
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
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (900, 560)).into_drawing_area();
        area.fill(&WHITE).map_err(drawing)?;
        let mut chart = ChartBuilder::on(&area)
            .caption("integrators of the plant: error against speed", ("sans-serif", 16, &INK))
            .margin(8)
            .x_label_area_size(44)
            .y_label_area_size(66)
            .build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale())
            .map_err(drawing)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE.mix(0.0))
            .bold_line_style(FAINT)
            .axis_style(INK)
            .label_style(("sans-serif", 12, &INK))
            .x_desc("simulated seconds in a second, one core, fastest round")
            .y_desc("largest error of a chamber, kPa")
            .x_label_formatter(&|value| format!("{value:.0}"))
            .y_label_formatter(&|value| if *value < 0.01 { format!("{value:.0e}") } else { format!("{value}") })
            .draw()
            .map_err(drawing)?;
        let targets = [[(SPEED_TARGET, y.0), (SPEED_TARGET, y.1)], [(x.0, ERROR_TARGET_KPA), (x.1, ERROR_TARGET_KPA)]];
        for [from, to] in targets {
            let dashed = DashedLineSeries::new([from, to], 5, 5, INK.stroke_width(1));
            chart.draw_series(dashed).map_err(drawing)?;
        }
        let mut taken: Vec<(i32, i32)> = Vec::new();
        for row in &report.integrators {
            let (place, colour) =
                ((row.fastest_simulated_seconds_per_second, row.max_error_kpa.min(TOP_KPA)), colour(row));
            let radius = if row.default { 7 } else { 4 };
            let mark = if row.default { " (default)" } else { "" };
            let label = format!("{}, {}{mark}", row.integrator, row.step);
            let ink = if row.dominated && !row.default { GREY } else { INK };
            let style = ("sans-serif", LABEL_HEIGHT, &ink).into_text_style(&area);
            chart.draw_series(core::iter::once(Circle::new(place, radius, colour.filled()))).map_err(drawing)?;
            let (x, y) = chart.backend_coord(&place);
            let spot = free_spot(&taken, (x + radius + 3, y - LABEL_HEIGHT / 2), label_width(&label));
            taken.push(spot);
            area.draw_text(&label, &style, spot).map_err(drawing)?;
        }
        area.present().map_err(drawing)?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_do_not_cover_each_other() {
        let mut taken = Vec::new();
        for index in 0..6 {
            let spot = free_spot(&taken, (100 + index, 200), 80);
            assert!(taken.iter().all(|&(_, y): &(i32, i32)| (y - spot.1).abs() > LABEL_HEIGHT), "{taken:?} {spot:?}");
            taken.push(spot);
        }
        assert_eq!(free_spot(&taken, (500, 200), 80), (500, 200));
    }
}
