//! Plots of a run as SVG: files of their own, and what the page shows where scripts are off.

pub use super::chart::SEGMENT_COLOURS;

use super::chart::{Chart, SWITCHES, bends as bends_chart, extremes, pressures as pressure_charts, seconds};
use super::record::Record;
use crate::drawing::{Area, FAINT, INK, drawing, styled, svg};
use anyhow::Result;
use plotters::prelude::*;

/// Rows to a bucket at least, and buckets to a curve at most: finer than a pixel.
const EVERY: usize = 10;
const BUCKETS: usize = 8000;

fn duration(records: &[Record]) -> f64 {
    records.last().map_or(1.0, seconds).max(0.001)
}

fn line(records: &[Record], value: &dyn Fn(&Record) -> f64) -> Vec<(f64, f64)> {
    let every = EVERY.max(records.len() / BUCKETS);
    records.chunks(every).flat_map(|rows| extremes(rows, value)).collect()
}

/// A panel with a time axis, curves and a legend.
fn panel(area: &Area<'_>, shown: &Chart, records: &[Record]) -> Result<()> {
    let mut chart = ChartBuilder::on(area)
        .caption(&shown.title, ("sans-serif", 15, &INK))
        .margin(6)
        .margin_right(16)
        .x_label_area_size(30)
        .y_label_area_size(52)
        .build_cartesian_2d(0.0..duration(records), shown.range.0..shown.range.1)
        .map_err(drawing)?;
    styled(&mut chart.configure_mesh())
        .x_labels(12)
        .y_labels(6)
        .x_label_formatter(&|value| format!("{value:.0} s"))
        .y_label_formatter(&|value| format!("{value:.0}"))
        .y_desc(shown.unit)
        .draw()
        .map_err(drawing)?;
    for curve in &shown.curves {
        let style = curve.colour.rgb().stroke_width(curve.width);
        chart
            .draw_series(LineSeries::new(line(records, &curve.value), style))
            .map_err(drawing)?
            .label(curve.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.85))
        .border_style(FAINT)
        .label_font(("sans-serif", 12, &INK))
        .draw()
        .map_err(drawing)?;
    Ok(())
}

/// Setpoint, estimate and, where it is known, true pressure of each chamber, a panel each.
///
/// # Errors
/// When the drawing backend fails.
pub fn pressures(records: &[Record]) -> Result<String> {
    svg((960, 720), &|area| {
        for (part, chart) in area.split_evenly((3, 1)).iter().zip(&pressure_charts(records)) {
            panel(part, chart, records)?;
        }
        Ok(())
    })
}

/// Bend of each segment and of the whole finger.
///
/// # Errors
/// When the drawing backend fails.
pub fn bends(records: &[Record]) -> Result<String> {
    svg((960, 320), &|area| panel(area, &bends_chart(records), records))
}

/// Pump and valves as a timing diagram: a bar where the pump runs or the passage is open.
///
/// # Errors
/// When the drawing backend fails.
pub fn actuation(records: &[Record]) -> Result<String> {
    svg((960, 240), &|area| {
        let mut chart = ChartBuilder::on(area)
            .caption("pump and valves", ("sans-serif", 15, &INK))
            .margin(6)
            .margin_right(16)
            .x_label_area_size(30)
            .y_label_area_size(100)
            .build_cartesian_2d(0.0..duration(records), 0.0..SWITCHES.len() as f64)
            .map_err(drawing)?;
        styled(&mut chart.configure_mesh())
            .disable_y_mesh()
            .disable_y_axis()
            .x_labels(12)
            .x_label_formatter(&|value| format!("{value:.0} s"))
            .draw()
            .map_err(drawing)?;
        for (index, switch) in SWITCHES.iter().enumerate() {
            let middle = SWITCHES.len() as f64 - 0.5 - index as f64;
            // Every millisecond counts here: a dose may last for three.
            let same = |a: &Record, b: &Record| (switch.on)(a) == (switch.on)(b);
            let bars = records.chunk_by(same).filter(|chunk| (switch.on)(&chunk[0])).map(|chunk| {
                let (start, end) = (seconds(&chunk[0]), seconds(&chunk[chunk.len() - 1]) + 0.001);
                Rectangle::new([(start, middle - 0.32), (end, middle + 0.32)], switch.colour.rgb().filled())
            });
            chart.draw_series(bars).map_err(drawing)?;
            let (_, y) = chart.backend_coord(&(0.0, middle));
            area.draw_text(switch.name, &("sans-serif", 12, &INK).into_text_style(area), (8, y - 6))
                .map_err(drawing)?;
        }
        Ok(())
    })
}
