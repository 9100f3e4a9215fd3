//! The three lines at the top: source and recording, mode and progress, air.

use super::{BAD, FAINT, GOOD, STRONG, Status, WARNING};
use crate::monitor::session::Connection;
use crate::monitor::state::State;
use crate::report::record::link_mode_name;
use model_core::actuation::Passage;
use model_core::protocol::LinkMode;
use ratatui::Frame;
use ratatui::layout::{Alignment, Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{LineGauge, Paragraph};

/// Where the rows come from and where they go.
pub fn title(frame: &mut Frame, area: Rect, status: &Status) {
    let mut left = vec![Span::styled(" finger monitor ", STRONG), Span::raw(status.source.clone())];
    if let Some(firmware) = &status.firmware {
        left.push(Span::styled(format!("  firmware {firmware}"), FAINT));
    }
    let right = match (&status.recording, status.replay) {
        (_, Some((place, end, held))) => {
            let state = if held { "stopped" } else { "replay" };
            Line::styled(format!("{state} {:.1} of {:.1} s ", seconds(place), seconds(end)), WARNING)
        }
        (Ok(path), None) => Line::from(vec![Span::styled("REC ", BAD), Span::raw(format!("{path} "))]),
        (Err(why), None) => Line::styled(format!("NOT RECORDED: {why} "), BAD),
    };
    let [from, to] = Layout::horizontal([Constraint::Fill(1), Constraint::Length(right.width() as u16)]).areas(area);
    let bar = Style::new().add_modifier(Modifier::REVERSED);
    frame.render_widget(Paragraph::new(Line::from(left)).style(bar), from);
    frame.render_widget(Paragraph::new(right).alignment(Alignment::Right).style(bar), to);
}

fn seconds(ms: u32) -> f64 {
    f64::from(ms) / 1000.0
}

/// What the device does, and how far its sequence is.
pub fn mode(frame: &mut Frame, area: Rect, state: &State, status: &Status) {
    let Some(last) = state.last() else {
        let text = match &status.connection {
            Some(Connection::Down(why, _)) => format!(" no device: {why}"),
            _ => " waiting for the first frame".into(),
        };
        frame.render_widget(Paragraph::new(Line::styled(text, WARNING)), area);
        return;
    };
    let style = match last.mode {
        LinkMode::Faulted(_) => BAD,
        LinkMode::Running | LinkMode::Holding => GOOD.add_modifier(Modifier::BOLD),
        LinkMode::Paused | LinkMode::SelfTest => WARNING,
        LinkMode::Vented => STRONG,
    };
    let mut spans = vec![Span::styled(format!(" {} ", link_mode_name(last.mode).to_uppercase()), style)];
    let progress = state.progress();
    if let Some(progress) = progress {
        let sequence = progress.sequence;
        let (step, steps) = (last.step + 1, sequence.steps().len());
        let (repeat, repeats) = (last.repeat + 1, sequence.repeats());
        spans.push(Span::raw(format!(" {}  step {step}/{steps}  repeat {repeat}/{repeats}", sequence.name)));
    } else if matches!(last.mode, LinkMode::Running | LinkMode::Paused) {
        spans.push(Span::raw(format!(" step {}  repeat {}", last.step + 1, last.repeat + 1)));
    }
    if last.holding && last.mode == LinkMode::Running {
        spans.push(Span::styled("  at target", FAINT));
    }
    if let Some(asked) = &status.asked {
        spans.push(Span::styled(format!("  asking: {asked}"), WARNING));
    }
    let line = Line::from(spans);
    let [text, gauge] =
        Layout::horizontal([Constraint::Length(line.width() as u16 + 2), Constraint::Fill(1)]).areas(area);
    frame.render_widget(Paragraph::new(line), text);
    if let Some(progress) = progress {
        let label = format!("{:3.0} %", 100.0 * progress.share);
        let gauge_widget = LineGauge::default().ratio(progress.share).label(label).filled_style(GOOD);
        frame.render_widget(gauge_widget.unfilled_style(FAINT), gauge);
    }
}

/// Pump, dump valve, manifold, and what the whole finger does.
pub fn air(frame: &mut Frame, area: Rect, state: &State) {
    let Some(last) = state.last() else { return };
    let air = &last.actuation;
    let pump = if air.pump { Span::styled("ON ", GOOD.add_modifier(Modifier::BOLD)) } else { Span::raw("off") };
    let dump = if air.dump == Passage::Open { "open  " } else { "closed" };
    let quantity = |value: f64, unit: &str| {
        if value.is_finite() {
            Span::raw(format!("{value:6.1} {unit}"))
        } else {
            Span::styled(format!("   --- {unit}"), BAD)
        }
    };
    let force = if last.force_n.is_finite() { format!("{:5.2} N", last.force_n) } else { "  --- N".into() };
    let spans = vec![
        Span::styled(" pump ", FAINT),
        pump,
        Span::styled("  dump ", FAINT),
        Span::raw(dump),
        Span::styled("  manifold", FAINT),
        quantity(last.sensor_kpa, "kPa"),
        Span::styled("  bend", FAINT),
        quantity(last.bend_sensor_deg, "deg"),
        Span::styled("  force ", FAINT),
        Span::raw(force),
    ];
    frame.render_widget(Paragraph::new(Line::from(spans)), area);
}
