//! Plots of a run as SVG.

use crate::drawing::{Area, FAINT, INK, drawing, styled, svg};
use crate::trace::{Sample, Trace};
use anyhow::Result;
use model_core::actuation::{Passage, Segment};
use plotters::prelude::*;

/// One colour a segment, apart in brightness too, so that they survive a grey printer and colour blindness (Okabe, Ito).
pub const SEGMENT_COLOURS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

/// Samples to a bucket: 10 ms are finer than a pixel.
const EVERY: usize = 10;

fn seconds(sample: &Sample) -> f64 {
    f64::from(sample.time_ms) / 1000.0
}

fn duration(trace: &Trace) -> f64 {
    trace.samples.last().map_or(1.0, seconds).max(0.001)
}

fn line(trace: &Trace, value: impl Fn(&Sample) -> f64) -> Vec<(f64, f64)> {
    // The lowest and the highest of each bucket, in their order: a short peak must not vanish.
    let ends = |bucket: &[Sample]| {
        let points = || bucket.iter().map(|sample| (seconds(sample), value(sample)));
        let low = points().min_by(|a, b| a.1.total_cmp(&b.1));
        let high = points().max_by(|a, b| a.1.total_cmp(&b.1));
        let mut ends: Vec<_> = low.into_iter().chain(high).collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends.dedup();
        ends
    };
    trace.samples.chunks(EVERY).flat_map(ends).collect()
}

/// One curve with its name.
struct Curve {
    name: String,
    colour: RGBColor,
    width: u32,
    points: Vec<(f64, f64)>,
}

/// A panel with a time axis, curves and a legend.
fn panel(area: &Area<'_>, title: &str, unit: &str, range: (f64, f64), time: f64, curves: &[Curve]) -> Result<()> {
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 15, &INK))
        .margin(6)
        .margin_right(16)
        .x_label_area_size(30)
        .y_label_area_size(52)
        .build_cartesian_2d(0.0..time, range.0..range.1)
        .map_err(drawing)?;
    styled(&mut chart.configure_mesh())
        .x_labels(12)
        .y_labels(6)
        .x_label_formatter(&|value| format!("{value:.0} s"))
        .y_label_formatter(&|value| format!("{value:.0}"))
        .y_desc(unit)
        .draw()
        .map_err(drawing)?;
    for curve in curves {
        let style = curve.colour.stroke_width(curve.width);
        chart
            .draw_series(LineSeries::new(curve.points.iter().copied(), style))
            .map_err(drawing)?
            .label(&curve.name)
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

/// True pressure, setpoint and estimate of each chamber, a panel each.
///
/// # Errors
/// When the drawing backend fails.
pub fn pressures(trace: &Trace) -> Result<String> {
    let time = duration(trace);
    let top = trace
        .samples
        .iter()
        .flat_map(|sample| sample.chambers_kpa.into_iter().chain(sample.setpoints_kpa))
        .fold(20.0, f64::max)
        * 1.12;
    svg((960, 720), &|area| {
        for (part, segment) in area.split_evenly((3, 1)).iter().zip(Segment::ALL) {
            let index = segment as usize;
            let curve = |name: &str, colour, width, points| Curve { name: name.into(), colour, width, points };
            let title = format!("{} chamber", segment.name());
            let curves = [
                curve("setpoint", RGBColor(150, 155, 165), 4, line(trace, |sample| sample.setpoints_kpa[index])),
                curve("estimate", RGBColor(90, 90, 90), 1, line(trace, |sample| sample.estimates_kpa[index])),
                curve("true pressure", SEGMENT_COLOURS[index], 2, line(trace, |sample| sample.chambers_kpa[index])),
            ];
            panel(part, &title, "kPa", (-5.0, top), time, &curves)?;
        }
        Ok(())
    })
}

/// Bend of each segment and of the whole finger.
///
/// # Errors
/// When the drawing backend fails.
pub fn bends(trace: &Trace) -> Result<String> {
    let finger = |sample: &Sample| sample.bends_deg.iter().sum::<f64>();
    let top = trace.samples.iter().map(finger).fold(30.0, f64::max) * 1.12;
    let mut curves = vec![
        Curve {
            name: "flex sensor".into(),
            colour: RGBColor(200, 204, 212),
            width: 3,
            // A failed sensor has no value to draw.
            points: line(trace, |sample| sample.bend_sensor_deg)
                .into_iter()
                .filter(|point| point.1.is_finite())
                .collect(),
        },
        Curve { name: "finger".into(), colour: INK, width: 2, points: line(trace, finger) },
    ];
    for segment in Segment::ALL {
        let index = segment as usize;
        curves.push(Curve {
            name: segment.name().into(),
            colour: SEGMENT_COLOURS[index],
            width: 2,
            points: line(trace, |sample| sample.bends_deg[index]),
        });
    }
    svg((960, 320), &|area| panel(area, "bend", "degrees", (-5.0, top), duration(trace), &curves))
}

/// Pump and valves as a timing diagram: a bar where the pump runs or the passage is open.
///
/// # Errors
/// When the drawing backend fails.
pub fn actuation(trace: &Trace) -> Result<String> {
    /// A row: its name, its colour, and when its bar is drawn.
    type Row = (&'static str, RGBColor, fn(&Sample) -> bool);
    let rows: [Row; 5] = [
        ("pump on", INK, |sample| sample.actuation.pump),
        ("dump open", RGBColor(204, 121, 167), |sample| sample.actuation.dump == Passage::Open),
        ("proximal open", SEGMENT_COLOURS[0], |sample| sample.actuation.segments[0] == Passage::Open),
        ("middle open", SEGMENT_COLOURS[1], |sample| sample.actuation.segments[1] == Passage::Open),
        ("distal open", SEGMENT_COLOURS[2], |sample| sample.actuation.segments[2] == Passage::Open),
    ];
    let time = duration(trace);
    svg((960, 240), &|area| {
        let mut chart = ChartBuilder::on(area)
            .caption("pump and valves", ("sans-serif", 15, &INK))
            .margin(6)
            .margin_right(16)
            .x_label_area_size(30)
            .y_label_area_size(100)
            .build_cartesian_2d(0.0..time, 0.0..5.0)
            .map_err(drawing)?;
        styled(&mut chart.configure_mesh())
            .disable_y_mesh()
            .disable_y_axis()
            .x_labels(12)
            .x_label_formatter(&|value| format!("{value:.0} s"))
            .draw()
            .map_err(drawing)?;
        for (index, (name, colour, on)) in rows.iter().enumerate() {
            let middle = 4.5 - index as f64;
            // Every millisecond counts here: a dose may last for three.
            let bars = trace.samples.chunk_by(|a, b| on(a) == on(b)).filter(|chunk| on(&chunk[0])).map(|chunk| {
                let (start, end) = (seconds(&chunk[0]), seconds(&chunk[chunk.len() - 1]) + 0.001);
                Rectangle::new([(start, middle - 0.32), (end, middle + 0.32)], colour.filled())
            });
            chart.draw_series(bars).map_err(drawing)?;
            let (_, y) = chart.backend_coord(&(0.0, middle));
            area.draw_text(name, &("sans-serif", 12, &INK).into_text_style(area), (8, y - 6)).map_err(drawing)?;
        }
        Ok(())
    })
}
