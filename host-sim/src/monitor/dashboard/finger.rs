//! The finger from the side, as its bends have it.

use super::{FAINT, SEGMENTS};
use crate::monitor::state::State;
use crate::report::finger::{CHAMBER_MM, END_MM, Pose, chain};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::symbols::Marker;
use ratatui::widgets::Block;
use ratatui::widgets::canvas::{Canvas, Context, Line};

/// The room that the finger needs at any bend, mm: left, right, above, below the hand's end.
const ROOM_MM: [f64; 4] = [40.0, 135.0, 20.0, 100.0];
/// Half the thickness that is drawn, mm.
const HALF_MM: f64 = 4.0;
/// Lines that an arc is drawn with.
const LINES: u32 = 12;

/// Draws it, towards the right with the palm below.
pub fn draw(frame: &mut Frame, area: Rect, state: &State) {
    let bends = state.bends_deg();
    let title = match bends {
        Some(bends) => format!(" finger {:.0} deg ", bends.iter().sum::<f64>()),
        None => " finger ".into(),
    };
    let block = Block::bordered().border_style(FAINT).title(title);
    let inner = block.inner(area);
    // A cell has two by four dots, and is twice as high as wide: dots are square.
    let (columns, rows) = (f64::from(inner.width.max(1)) * 2.0, f64::from(inner.height.max(1)) * 4.0);
    let [left, right, above, below] = ROOM_MM;
    let dot_mm = ((left + right) / columns).max((above + below) / rows);
    let (middle_x, middle_y) = ((right - left) / 2.0, (above - below) / 2.0);
    let (half_x, half_y) = (dot_mm * columns / 2.0, dot_mm * rows / 2.0);
    let canvas = Canvas::default()
        .block(block)
        .marker(Marker::Braille)
        .x_bounds([middle_x - half_x, middle_x + half_x])
        .y_bounds([middle_y - half_y, middle_y + half_y])
        .paint(|context| {
            if let Some(bends) = bends {
                shape(context, bends);
            } else {
                context.print(0.0, -20.0, "its bends are not known");
            }
        });
    frame.render_widget(canvas, area);
}

fn shape(context: &mut Context, bends_deg: [f64; 3]) {
    let joints = chain(bends_deg);
    let hand = Pose { x: 0.0, y: 0.0, direction: 0.0 };
    arc(context, hand, END_MM, 0.0, Color::Gray);
    for (index, colour) in SEGMENTS.into_iter().enumerate() {
        arc(context, joints[index], CHAMBER_MM, bends_deg[index].to_radians(), colour);
    }
    arc(context, joints[3], END_MM, 0.0, Color::Gray);
}

/// Both sides of a part of the finger.
fn arc(context: &mut Context, from: Pose, length: f64, bend: f64, color: Color) {
    for side in [-HALF_MM, HALF_MM] {
        let at = |index: u32| {
            let share = f64::from(index) / f64::from(LINES);
            let pose = from.arc(length * share, bend * share);
            let (sin, cos) = pose.direction.sin_cos();
            // The palm is below, and a canvas counts upwards.
            (pose.x - side * sin, -(pose.y + side * cos))
        };
        for index in 0..LINES {
            let ((x1, y1), (x2, y2)) = (at(index), at(index + 1));
            context.draw(&Line { x1, y1, x2, y2, color });
        }
    }
}
