//! Each chamber's pressure against its setpoint: the numbers in the frame's title, the last seconds as curves.

use super::{FAINT, SEGMENTS, STRONG};
use crate::monitor::state::{Point, SHOWN_MS, State};
use model_core::actuation::{Passage, Segment};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType};

/// The top of the curves, kPa: the working range's end and what may overshoot it. What is above is drawn there.
const TOP_KPA: f64 = 160.0;

/// Draws the three segments, proximal on top.
pub fn draw(frame: &mut Frame, area: Rect, state: &State) {
    let areas: [Rect; 3] = Layout::vertical([Constraint::Fill(1); 3]).areas(area);
    for (segment, area) in Segment::ALL.into_iter().zip(areas) {
        chart(frame, area, state, segment);
    }
}

fn title(state: &State, segment: Segment) -> Line<'static> {
    let index = segment as usize;
    let name = Span::styled(format!(" {} ", segment.name()), STRONG.fg(SEGMENTS[index]));
    let Some(last) = state.last() else { return Line::from(name) };
    // A tiny negative pressure is no -0.0.
    let kpa = |value: f64| {
        if value.is_finite() { format!("{:.1}", if value.abs() < 0.05 { 0.0 } else { value }) } else { "---".into() }
    };
    let valve = if last.actuation.segments[index] == Passage::Open { "open" } else { "closed" };
    let bend = state.bends_deg().map_or_else(String::new, |bends| format!("  {:.1} deg", bends[index]));
    Line::from(vec![
        name,
        Span::styled(kpa(last.estimates_kpa[index]), STRONG),
        Span::raw(format!(" / {} kPa{bend}", kpa(last.setpoints_kpa[index]))),
        Span::styled(format!("  {valve} "), FAINT),
    ])
}

fn chart(frame: &mut Frame, area: Rect, state: &State, segment: Segment) {
    let index = segment as usize;
    let now = state.last().map_or(0.0, |last| f64::from(last.time_ms) / 1000.0);
    let setpoints = curves(state, |point| point.setpoints_kpa[index]);
    let estimates = curves(state, |point| point.estimates_kpa[index]);
    let dataset = |style: Style| {
        move |curve| Dataset::default().marker(Marker::Braille).graph_type(GraphType::Line).style(style).data(curve)
    };
    let mut datasets: Vec<Dataset> = setpoints.iter().map(Vec::as_slice).map(dataset(FAINT)).collect();
    datasets.extend(estimates.iter().map(Vec::as_slice).map(dataset(Style::new().fg(SEGMENTS[index]))));
    let shown = f64::from(SHOWN_MS) / 1000.0;
    let chart = Chart::new(datasets)
        .block(Block::bordered().border_style(FAINT).title(title(state, segment)))
        .x_axis(Axis::default().bounds([now - shown, now]))
        .y_axis(Axis::default().bounds([0.0, TOP_KPA]).labels(["0", "80", "160"]).style(FAINT))
        .legend_position(None);
    frame.render_widget(chart, area);
}

/// Time in seconds and value: one curve for each stretch in which it is known.
fn curves(state: &State, value: impl Fn(&Point) -> f64) -> Vec<Vec<(f64, f64)>> {
    let points: Vec<_> =
        state.points().map(|point| (f64::from(point.time_ms) / 1000.0, value(point).clamp(0.0, TOP_KPA))).collect();
    points.split(|point| point.1.is_nan()).filter(|curve| !curve.is_empty()).map(<[_]>::to_vec).collect()
}
