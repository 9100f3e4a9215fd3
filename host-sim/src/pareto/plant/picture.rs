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
        for row in &report.integrators {
            let (place, colour) =
                ((row.fastest_simulated_seconds_per_second, row.max_error_kpa.min(TOP_KPA)), colour(row));
            let radius = if row.default { 7 } else { 4 };
            let mark = if row.default { " (default)" } else { "" };
            let label = format!("{}, {}{mark}", row.integrator, row.step);
            let ink = if row.dominated && !row.default { GREY } else { INK };
            let style = ("sans-serif", 10, &ink).into_text_style(&area);
            let element = EmptyElement::at(place)
                + Circle::new((0, 0), radius, colour.filled())
                + Text::new(label, (radius + 3, -5), style);
            chart.draw_series(core::iter::once(element)).map_err(drawing)?;
        }
        area.present().map_err(drawing)?;
    }
    Ok(text)
}
