//! Draws what is known; decides nothing.

mod finger;
mod header;
mod panels;
mod pressures;
mod question;

use super::keys::Keys;
use super::link::Quality;
use super::session::Connection;
use super::state::State;
use model_core::protocol::IdentifiedSegment;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

/// The smallest terminal that everything fits into: columns, rows.
pub const SMALLEST: (u16, u16) = (80, 24);

/// The segments' colours: what a terminal has nearest to those of the reports.
const SEGMENTS: [Color; 3] = [Color::LightBlue, Color::LightRed, Color::LightGreen];
/// What is less important.
const FAINT: Style = Style::new().fg(Color::Gray);
const GOOD: Style = Style::new().fg(Color::LightGreen);
const BAD: Style = Style::new().fg(Color::LightRed).add_modifier(Modifier::BOLD);
const WARNING: Style = Style::new().fg(Color::LightYellow).add_modifier(Modifier::BOLD);
const STRONG: Style = Style::new().add_modifier(Modifier::BOLD);

/// What is known beside the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// Where the rows come from, in words.
    pub source: String,
    /// The device's firmware.
    pub firmware: Option<String>,
    /// Whether frames come; nothing in a replay.
    pub connection: Option<Connection>,
    /// Time since the last frame, ms.
    pub age_ms: Option<u64>,
    /// The host's clock, ms.
    pub now_ms: u64,
    /// Counts of the link.
    pub quality: Quality,
    /// Where rows are recorded, or why they are not.
    pub recording: Result<String, String>,
    /// The request that waits for its answer.
    pub asked: Option<String>,
    /// What the device has identified, once it has answered.
    pub identified: Option<[IdentifiedSegment; 3]>,
    /// A replay's place and end, ms, and whether it stands still.
    pub replay: Option<(u32, u32, bool)>,
}

/// Draws everything.
pub fn draw(frame: &mut Frame, state: &State, keys: &Keys, status: &Status) {
    let area = frame.area();
    if area.width < SMALLEST.0 || area.height < SMALLEST.1 {
        let (columns, rows) = SMALLEST;
        let text = format!("{columns} columns and {rows} rows are needed; here are {} and {}", area.width, area.height);
        frame.render_widget(Paragraph::new(vec![Line::raw(text), Line::raw("v vents, q vents and quits")]), area);
        return;
    }
    let events = (area.height - SMALLEST.1).min(6) + 2;
    let [title, mode, air, body, log, footer] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(1),
        Constraint::Length(1),
        Constraint::Min(18),
        Constraint::Length(events),
        Constraint::Length(1),
    ])
    .areas(area);
    header::title(frame, title, status);
    header::mode(frame, mode, state, status);
    header::air(frame, air, state);
    let [left, right] = Layout::horizontal([Constraint::Fill(3), Constraint::Fill(2)]).areas(body);
    pressures::draw(frame, left, state);
    let [shape, alarms, link] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(right.height / 4), Constraint::Length(6)])
            .areas(right);
    finger::draw(frame, shape, state);
    panels::alarms(frame, alarms, state);
    panels::link(frame, link, state, status);
    panels::events(frame, log, state);
    frame.render_widget(Paragraph::new(footer_line(keys)), footer);
    question::draw(frame, area, keys, status.identified.as_ref());
}

fn footer_line(keys: &Keys) -> Line<'static> {
    let all: &[(&str, &str)] = if keys.replay {
        &[("space", "stop/go"), ("left right", "5 s"), ("a", "acknowledge"), ("?", "keys"), ("q", "quit")]
    } else {
        &[
            ("v", "VENT"),
            ("r", "run"),
            ("p", "pause"),
            ("g", "go on"),
            ("s", "kPa"),
            ("b", "deg"),
            ("c", "clear"),
            ("a", "ack"),
            ("?", "keys"),
            ("q", "quit"),
        ]
    };
    let spans = all.iter().flat_map(|(key, what)| {
        let key = Span::styled(format!(" {key} "), Style::new().add_modifier(Modifier::REVERSED));
        [key, Span::raw(format!("{what} "))]
    });
    spans.collect()
}

#[cfg(test)]
mod tests;
