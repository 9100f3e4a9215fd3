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

/// The room that is shown in any case, mm from the hand's end: left, right, above, below. A straight finger fits.
const ROOM_MM: [f64; 4] = [15.0, 135.0, 15.0, 40.0];
/// The room beside the farthest joint, mm.
const MARGIN_MM: f64 = 12.0;
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
    let [mut left, mut right, mut above, mut below] = ROOM_MM;
    for joint in bends.into_iter().flat_map(chain) {
        left = left.max(MARGIN_MM - joint.x);
        right = right.max(MARGIN_MM + joint.x);
        above = above.max(MARGIN_MM - joint.y);
        below = below.max(MARGIN_MM + joint.y);
    }
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
                context.print(0.0, -10.0, "bends are not known");
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
