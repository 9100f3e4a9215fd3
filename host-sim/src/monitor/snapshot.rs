//! The dashboard as an SVG picture, cell by cell: letters as text, everything that has to meet its neighbour drawn.

use crate::report::html::escape;
use core::fmt::Write as _;
use ratatui::buffer::{Buffer, Cell};
use ratatui::style::{Color, Modifier};

/// A cell's size, pixels.
const CELL: (u32, u32) = (9, 18);
const PAPER: &str = "#14171c";
const INK: &str = "#e4e7eb";

/// The picture of what is on the terminal.
#[must_use]
pub fn svg(buffer: &Buffer) -> String {
    let area = buffer.area;
    let (width, height) = (u32::from(area.width) * CELL.0, u32::from(area.height) * CELL.1);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"DejaVu Sans Mono, Menlo, Consolas, monospace\" font-size=\"15\">\
         <rect width=\"100%\" height=\"100%\" fill=\"{PAPER}\"/>\n"
    );
    for y in 0..area.height {
        row(&mut out, buffer, y);
    }
    out.push_str("</svg>\n");
    out
}

/// Cells side by side that look alike become one text.
fn row(out: &mut String, buffer: &Buffer, y: u16) {
    let cells: Vec<&Cell> = (0..buffer.area.width).map(|x| &buffer[(x, y)]).collect();
    let mut x = 0;
    for run in cells.chunk_by(|a, b| look(a) == look(b)) {
        let (ink, paper, bold) = look(run[0]);
        let (left, top) = (x * CELL.0, u32::from(y) * CELL.1);
        let width = run.len() as u32 * CELL.0;
        if paper != PAPER {
            let _ = write!(
                out,
                "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{}\" fill=\"{paper}\"/>",
                CELL.1
            );
        }
        let mut path = String::new();
        let text: String = run
            .iter()
            .zip(0..)
            .map(|(cell, index)| {
                let letter = cell.symbol().chars().next().unwrap_or(' ');
                let drawn = drawing(letter, left + index * CELL.0, top);
                path.push_str(&drawn);
                if drawn.is_empty() { letter } else { ' ' }
            })
            .collect();
        if !path.is_empty() {
            let _ = write!(out, "<path d=\"{path}\" fill=\"{ink}\"/>");
        }
        words(out, &text, (left, top), ink, bold);
        x += run.len() as u32;
    }
    out.push('\n');
}

/// Words with wide gaps between them are texts of their own: each stands in its cell, whatever the letters' width.
fn words(out: &mut String, text: &str, (left, top): (u32, u32), ink: &str, bold: bool) {
    let weight = if bold { " font-weight=\"bold\"" } else { "" };
    let mut cell = 0;
    for part in text.split("  ") {
        let word = part.trim();
        if !word.is_empty() {
            let before = (part.len() - part.trim_start().len()) as u32;
            let _ = write!(
                out,
                "<text x=\"{}\" y=\"{}\" fill=\"{ink}\"{weight} textLength=\"{}\" xml:space=\"preserve\">{}</text>",
                left + (cell + before) * CELL.0,
                top + 14,
                word.chars().count() as u32 * CELL.0,
                escape(word)
            );
        }
        cell += part.chars().count() as u32 + 2;
    }
}

/// Ink, paper, and whether it is bold.
fn look(cell: &Cell) -> (&'static str, &'static str, bool) {
    let (ink, paper) = (colour(cell.fg, INK), colour(cell.bg, PAPER));
    let reversed = cell.modifier.contains(Modifier::REVERSED);
    let (ink, paper) = if reversed { (paper, ink) } else { (ink, paper) };
    (ink, paper, cell.modifier.contains(Modifier::BOLD))
}

/// The dashboard's colours; the segments' as in the reports, a little lighter on dark paper.
fn colour(colour: Color, default: &'static str) -> &'static str {
    match colour {
        Color::LightBlue => "#4ea3e0",
        Color::LightRed => "#f0803c",
        Color::LightGreen => "#2cc295",
        Color::LightYellow => "#f0d24a",
        Color::Gray => "#8d949e",
        _ => default,
    }
}

/// A cell's drawing as an SVG path: braille dots and the lines of frames; empty for a letter.
fn drawing(letter: char, left: u32, top: u32) -> String {
    let rectangle = |x: f64, y: f64, width: f64, height: f64| {
        format!("M{:.1} {:.1}h{width}v{height}h-{width}z", f64::from(left) + x, f64::from(top) + y)
    };
    let code = u32::from(letter);
    if (0x2801..=0x28FF).contains(&code) {
        // Bits 0 to 2 and 6 are the left column from above, 3 to 5 and 7 the right one.
        const DOTS: [(u32, f64, f64); 8] = [
            (0, 0.0, 0.0),
            (1, 0.0, 1.0),
            (2, 0.0, 2.0),
            (6, 0.0, 3.0),
            (3, 1.0, 0.0),
            (4, 1.0, 1.0),
            (5, 1.0, 2.0),
            (7, 1.0, 3.0),
        ];
        let set = DOTS.iter().filter(|(bit, ..)| code >> bit & 1 == 1);
        return set.map(|(_, column, row)| rectangle(1.0 + 4.5 * column, 1.0 + 4.5 * row, 2.6, 2.6)).collect();
    }
    // Half lines from the cell's middle: left, right, up, down.
    let [to_left, to_right, up, down] = match letter {
        '─' => [true, true, false, false],
        '│' => [false, false, true, true],
        '┌' => [false, true, false, true],
        '┐' => [true, false, false, true],
        '└' => [false, true, true, false],
        '┘' => [true, false, true, false],
        '┤' => [true, false, true, true],
        '┼' => [true; 4],
        _ => return String::new(),
    };
    let (width, height) = (f64::from(CELL.0), f64::from(CELL.1));
    let (x, y) = (width / 2.0 - 0.5, height / 2.0 - 0.5);
    let halves = [
        (to_left, rectangle(0.0, y, x + 1.0, 1.0)),
        (to_right, rectangle(x, y, width - x, 1.0)),
        (up, rectangle(x, 0.0, 1.0, y + 1.0)),
        (down, rectangle(x, y, 1.0, height - y)),
    ];
    halves.into_iter().filter(|(there, _)| *there).map(|(_, path)| path).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::layout::Rect;
    use ratatui::style::Style;

    #[test]
    fn letters_are_text_at_their_place_and_dots_and_frames_are_drawn() {
        let mut buffer = Buffer::empty(Rect::new(0, 0, 12, 2));
        buffer.set_string(2, 1, "a<b", Style::new().fg(Color::LightRed));
        buffer.set_string(0, 0, "⡀─ c   d", Style::new());
        let svg = svg(&buffer);
        assert!(svg.contains("viewBox=\"0 0 108 36\""), "{svg}");
        assert!(
            svg.contains(
                "<text x=\"18\" y=\"32\" fill=\"#f0803c\" textLength=\"27\" xml:space=\"preserve\">a&lt;b</text>"
            ),
            "{svg}"
        );
        assert!(svg.contains("<text x=\"27\" y=\"14\"") && svg.contains("<text x=\"63\" y=\"14\""), "{svg}");
        // Bit 6 is the lowest dot on the left; the line goes through the second cell's whole width.
        assert!(svg.contains("M1.0 14.5h2.6"), "{svg}");
        assert!(svg.contains("M9.0 8.5h5v1") && svg.contains("M13.0 8.5h5v1"), "{svg}");
        assert!(!svg.contains('⡀') && !svg.contains('─'));
    }
}
