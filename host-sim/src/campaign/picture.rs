//! The detection matrix as SVG: a row a fault, a column a program.

use super::draw::Choice;
use super::kind::Kind;
use super::shard::Part;
use super::tally::Cell;
use crate::drawing::{FAINT, INK, drawing, svg};
use anyhow::Result;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const MISSED: RGBColor = RGBColor(213, 94, 0);
const NOT_SHOWN: RGBColor = RGBColor(244, 245, 247);
const UNDECIDED: RGBColor = RGBColor(200, 204, 210);
const QUICK: RGBColor = RGBColor(222, 238, 247);
const SLOW: RGBColor = RGBColor(0, 114, 178);

/// Where the matrix begins, and a cell's size, pixels.
const LEFT: i32 = 170;
const TOP: i32 = 128;
const CELL: (i32, i32) = (52, 22);

/// Paler when soon, darker when late: from 1 ms to 30 s.
fn colour(latency_ms: u32) -> RGBColor {
    let share = (f64::from(latency_ms.max(1)).log10() / 30_000_f64.log10()).clamp(0.0, 1.0);
    let mix = |from: u8, to: u8| (f64::from(from) + (f64::from(to) - f64::from(from)) * share) as u8;
    RGBColor(mix(QUICK.0, SLOW.0), mix(QUICK.1, SLOW.1), mix(QUICK.2, SLOW.2))
}

/// A cell's ground, letters and ink.
fn face(cell: &Cell) -> (RGBColor, String, RGBColor) {
    if cell.missed > 0 {
        return (MISSED, format!("{} missed", cell.missed), WHITE);
    }
    match cell.latency_at(0.5) {
        Some(ms) => {
            let words = if ms >= 1000 { format!("{:.1} s", f64::from(ms) / 1000.0) } else { format!("{ms} ms") };
            (colour(ms), words, if ms > 1000 { WHITE } else { INK })
        }
        None if cell.undecided > 0 => (UNDECIDED, "undecided".to_owned(), INK),
        None if cell.runs > 0 => (NOT_SHOWN, "not shown".to_owned(), INK),
        None => (WHITE, String::new(), INK),
    }
}

/// The matrix of runs with one fault: median time to detection, and in orange where one was missed.
///
/// # Errors
/// When the drawing backend fails.
pub fn picture(part: &Part) -> Result<String> {
    let programs = Choice::all();
    let empty = Cell::default();
    let width = LEFT + programs.len() as i32 * CELL.0 + 16;
    let height = TOP + Kind::ALL.len() as i32 * CELL.1 + 46;
    svg((width as u32, height as u32), &|area| {
        let title = ("sans-serif", 16, &INK).into_text_style(area);
        let words = format!("Detection: median time from when the fault shows, {} runs", part.result.runs);
        area.draw_text(&words, &title, (12, 10)).map_err(drawing)?;
        let column = ("sans-serif", 11, &INK)
            .into_text_style(area)
            .transform(FontTransform::Rotate270)
            .pos(Pos::new(HPos::Left, VPos::Center));
        for (index, choice) in programs.iter().enumerate() {
            let x = LEFT + index as i32 * CELL.0 + CELL.0 / 2;
            area.draw_text(choice.name(), &column, (x, TOP - 6)).map_err(drawing)?;
        }
        let row_style = ("sans-serif", 12, &INK).into_text_style(area).pos(Pos::new(HPos::Right, VPos::Center));
        for (row, kind) in Kind::ALL.into_iter().enumerate() {
            let name = kind.name();
            let top = TOP + row as i32 * CELL.1;
            area.draw_text(&name, &row_style, (LEFT - 8, top + CELL.1 / 2)).map_err(drawing)?;
            for (index, choice) in programs.iter().enumerate() {
                let cell = part.result.matrix.get(&name).and_then(|row| row.get(choice.name())).unwrap_or(&empty);
                let left = LEFT + index as i32 * CELL.0;
                let (ground, words, ink) = face(cell);
                let corners = [(left, top), (left + CELL.0, top + CELL.1)];
                area.draw(&Rectangle::new(corners, ground.filled())).map_err(drawing)?;
                area.draw(&Rectangle::new(corners, FAINT.stroke_width(1))).map_err(drawing)?;
                let style = ("sans-serif", 10, &ink).into_text_style(area).pos(Pos::new(HPos::Center, VPos::Center));
                area.draw_text(&words, &style, (left + CELL.0 / 2, top + CELL.1 / 2)).map_err(drawing)?;
            }
        }
        legend(area, height)
    })
}

fn legend(area: &crate::drawing::Area<'_>, height: i32) -> Result<()> {
    let style = ("sans-serif", 11, &INK).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
    let entries = [
        (colour(1), "at once"),
        (colour(1000), "1 s"),
        (colour(30_000), "30 s"),
        (MISSED, "missed its bound in so many runs"),
        (UNDECIDED, "run ended before the bound"),
        (NOT_SHOWN, "never showed in a true quantity"),
    ];
    let (mut x, y) = (LEFT, height - 30);
    for (ground, words) in entries {
        let corners = [(x, y), (x + 14, y + 14)];
        area.draw(&Rectangle::new(corners, ground.filled())).map_err(drawing)?;
        area.draw(&Rectangle::new(corners, FAINT.stroke_width(1))).map_err(drawing)?;
        area.draw_text(words, &style, (x + 19, y + 7)).map_err(drawing)?;
        x += 34 + words.len() as i32 * 6;
    }
    Ok(())
}
