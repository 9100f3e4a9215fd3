//! Alarms, link quality, and what happened.

use super::{BAD, FAINT, GOOD, Status, WARNING};
use crate::monitor::session::Connection;
use crate::monitor::state::{Alarm, State};
use crate::report::record::PRIORITIES;
use model_core::supervisor::fault::Priority;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph};

/// Latched faults, the most urgent first; those that nobody has seen stand out.
pub fn alarms(frame: &mut Frame, area: Rect, state: &State) {
    let all = state.alarms();
    let priority = state.last().map_or(0, |last| usize::from(last.priority.min(3)));
    let style = if all.is_empty() { FAINT } else { style(all.first().and_then(|alarm| alarm.priority)) };
    let title =
        if all.is_empty() { " alarms ".into() } else { format!(" alarms: {} {} ", all.len(), PRIORITIES[priority]) };
    let block = Block::bordered().border_style(style).title(title);
    let rows = usize::from(block.inner(area).height);
    let mut lines: Vec<Line> = all.iter().take(if all.len() > rows { rows - 1 } else { rows }).map(line).collect();
    if all.len() > rows {
        lines.push(Line::styled(format!("and {} more", all.len() - rows + 1), FAINT));
    }
    if all.is_empty() {
        lines.push(Line::styled("none", FAINT));
    }
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn style(priority: Option<Priority>) -> Style {
    match priority {
        Some(Priority::High) => BAD,
        _ => WARNING,
    }
}

fn line(alarm: &Alarm) -> Line<'_> {
    let mark = match alarm.priority {
        Some(Priority::High) => "!!!",
        Some(Priority::Medium) => "!! ",
        Some(Priority::Low) => "!  ",
        None => "?  ",
    };
    let style = style(alarm.priority);
    let style = if alarm.seen { style } else { style.add_modifier(Modifier::REVERSED) };
    Line::from(vec![Span::styled(format!("{mark} "), style), Span::styled(alarm.name.as_str(), style)])
}

/// How good the line is.
pub fn link(frame: &mut Frame, area: Rect, state: &State, status: &Status) {
    let (word, style) = match &status.connection {
        None => ("as recorded".to_owned(), FAINT),
        Some(Connection::Waiting) => ("waiting".to_owned(), WARNING),
        Some(Connection::Up) => ("up".to_owned(), GOOD),
        Some(Connection::Down(_, since)) => {
            (format!("LOST for {:.1} s", status.now_ms.saturating_sub(*since) as f64 / 1000.0), BAD)
        }
    };
    let block = Block::bordered().border_style(FAINT);
    let block = block.title(Line::from(vec![Span::raw(" link "), Span::styled(word, style), Span::raw(" ")]));
    let quality = &status.quality;
    let age = status.age_ms.map_or_else(|| "---".into(), |age| format!("{age} ms"));
    let rows = state.last().map(|last| last.link).unwrap_or_default();
    let known = |count: Option<u32>| count.map_or_else(|| "-".into(), |count| count.to_string());
    let lost = status.connection.as_ref().map_or(rows.frames_lost, |_| Some(quality.lost));
    let bad = status.connection.as_ref().map_or(rows.frames_bad, |_| Some(quality.bad()));
    let bad_crc = status.connection.as_ref().map(|_| quality.bad_crc);
    let count = |name: &'static str, count: Option<u32>| {
        let style = if count.unwrap_or(0) > 0 { WARNING } else { Style::new() };
        [Span::styled(name, FAINT), Span::styled(known(count), style)]
    };
    let frames = status.connection.as_ref().map_or_else(|| "-".into(), |_| quality.frames.to_string());
    let (gaps, restarts) = state.gaps_and_restarts();
    let mut lines = vec![
        Line::from(vec![
            Span::styled("frames ", FAINT),
            Span::raw(frames),
            Span::styled("  age ", FAINT),
            Span::raw(age),
        ]),
        count("lost ", lost).into_iter().chain(count("  bad ", bad)).chain(count(" of which CRC ", bad_crc)).collect(),
        count("gaps ", Some(gaps)).into_iter().chain(count("  restarts ", Some(restarts))).collect(),
        count("late ticks ", rows.late_ticks)
            .into_iter()
            .chain(count("  it dropped ", rows.device_dropped_frames))
            .collect(),
    ];
    if let Some(version) = quality.other_version {
        let own = model_core::protocol::VERSION;
        lines[3] = Line::styled(format!("device speaks protocol {version}, not {own}"), BAD);
    }
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// What happened, the newest at the bottom.
pub fn events(frame: &mut Frame, area: Rect, state: &State) {
    let mut newest: Vec<_> = state.events().rev().take(usize::from(area.height)).collect();
    newest.reverse();
    let lines = newest.into_iter().map(|(time_ms, text)| {
        let time = Span::styled(format!("{:8.2} s  ", f64::from(*time_ms) / 1000.0), FAINT);
        let wrong = ["refused", "no answer", "not sent", "link lost"].iter().any(|start| text.starts_with(start));
        Line::from(vec![time, Span::styled(text.as_str(), if wrong { WARNING } else { Style::new() })])
    });
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), area);
}
