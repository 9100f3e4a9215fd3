//! What is asked of the operator, in a box over everything else.

use super::{BAD, FAINT};
use crate::monitor::event::coefficients_kpa;
use crate::monitor::keys::{Keys, Question};
use model_core::actuation::Segment;
use model_core::protocol::IdentifiedSegment;
use model_core::sequence::library;
use model_core::units::Bend;
use ratatui::Frame;
use ratatui::layout::{Constraint, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph};

/// The keys, for the box that explains them.
const HELP: [&str; 15] = [
    "v        vents at once, whatever is open",
    "r        runs a sequence: choose it from a list",
    "p  g     pauses; goes on",
    "s        goes to pressures by hand, kPa",
    "b        goes to bends by hand, degrees",
    "c        clears a latched fault whose cause is gone",
    "a        marks all alarms as seen",
    "z        takes what the vented sensors read as zero",
    "i        what the device has identified; takes it",
    "l        loads the coefficients of --calibration",
    "q ctrl-c vents and quits",
    "Q        quits and leaves the device as it is; one that",
    "         is driven by hand vents within a second",
    "space    in a replay: stops, goes on",
    "arrows   in a replay: 5 s back, 5 s on",
];

/// Draws the open question, if there is one.
pub fn draw(frame: &mut Frame, area: Rect, keys: &Keys, identified: Option<&[IdentifiedSegment; 3]>) {
    let (title, lines) = match &keys.question {
        Question::None => return,
        Question::Help => (" keys, Esc closes ", HELP.into_iter().map(Line::raw).collect()),
        Question::Sequence(chosen) => (" run which? Enter runs, Esc does not ", sequences(*chosen)),
        Question::Values { bends, text, wrong } => {
            let title = if *bends { " bends P,M,D in degrees " } else { " pressures P,M,D in kPa " };
            let mut lines = vec![Line::from(vec![Span::raw(text.clone()), Span::styled("_", FAINT)])];
            lines.push(match wrong {
                Some(why) => Line::styled(why.clone(), BAD),
                None => Line::styled("Enter goes there at once, Esc does not", FAINT),
            });
            (title, lines)
        }
        Question::Zero => (
            " zero the sensors? ",
            vec![
                Line::raw("Takes what both sensors read now as zero."),
                Line::raw("The finger must be vented and at rest. y / n"),
            ],
        ),
        Question::Calibrate => (" load coefficients? y / n ", coefficients(keys)),
        Question::Adopt => (" use what was identified? y / n ", found(identified)),
    };
    let width = lines.iter().map(Line::width).max().unwrap_or(0).max(title.len()) as u16 + 4;
    let place: Rect = area.centered(
        Constraint::Length(width.min(area.width)),
        Constraint::Length((lines.len() as u16 + 2).min(area.height)),
    );
    frame.render_widget(Clear, place);
    frame.render_widget(Paragraph::new(lines).block(Block::bordered().title(title)), place);
}

fn sequences(chosen: usize) -> Vec<Line<'static>> {
    let line = |(index, sequence): (usize, &&model_core::sequence::Sequence)| {
        let seconds = f64::from(sequence.duration().0) / 1000.0;
        let style = if index == chosen { Style::new().add_modifier(Modifier::REVERSED) } else { Style::new() };
        let description: String = sequence.description.chars().take(44).collect();
        Line::styled(format!("{:<16}{seconds:7.1} s  {description:<44}", sequence.name), style)
    };
    library::ALL.iter().enumerate().map(line).collect()
}

fn found(identified: Option<&[IdentifiedSegment; 3]>) -> Vec<Line<'static>> {
    let Some(identified) = identified else { return vec![Line::styled("the device has not answered yet", FAINT)] };
    let line = |(segment, own): (Segment, &IdentifiedSegment)| {
        let name = segment.name();
        if !own.ready {
            return Line::styled(format!("{name:<9} not yet: {} points", own.points), FAINT);
        }
        let [k, c1, c2] = coefficients_kpa(own.coefficients);
        let off = Bend::from_bits(own.residual_bend).to_f64();
        Line::raw(format!("{name:<9} k {k:.3}  c1 {c1:.3}  c2 {c2:.3} kPa  {off:.2} deg off  {} points", own.points))
    };
    let mut lines: Vec<_> = Segment::ALL.into_iter().zip(identified).map(line).collect();
    lines.push(Line::styled("What is ready is taken and stored. The finger must be vented.", FAINT));
    lines
}

fn coefficients(keys: &Keys) -> Vec<Line<'static>> {
    let line = |(segment, own): (Segment, &Option<model_core::units::Coefficients>)| {
        let text = own.map_or_else(
            || "as it is".into(),
            |own| {
                let [k, c1, c2] = own.to_f64_kpa();
                format!("k {k:.4}  c1 {c1:.4}  c2 {c2:.4} kPa")
            },
        );
        Line::raw(format!("{:<9} {text}", segment.name()))
    };
    Segment::ALL.into_iter().zip(&keys.calibration).map(line).collect()
}
