//! The finger's shape from the side, drawn from its three bends.

use crate::metrics::{StepSummary, Summary};
use core::fmt::Write as _;
use model_core::actuation::Segment;
use model_core::paper;

/// Length of one chamber, mm (paper, Table 1).
pub const CHAMBER_MM: f64 = paper::CHAMBER_LENGTH_MM;
/// Length of the stiff tail at the hand and of the head at the tip, mm (paper, Table 1).
pub const END_MM: f64 = 7.0;
/// Height of the exoskeleton, mm (paper, Table 1).
const HEIGHT_MM: f64 = paper::EXOSKELETON_HEIGHT_MM;
/// The segments' colours, as in the plots.
pub const COLOURS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];

/// A point and the direction there: mm, mm, radians from the x axis towards +y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Along the hand, mm.
    pub x: f64,
    /// Towards the palm, mm.
    pub y: f64,
    /// Direction, radians.
    pub direction: f64,
}

impl Pose {
    fn straight(self, length: f64) -> Self {
        let (sin, cos) = self.direction.sin_cos();
        Self { x: self.x + length * cos, y: self.y + length * sin, ..self }
    }

    /// Along an arc of `length` that turns by `bend` radians: its chord is length · sinc(bend / 2).
    pub(crate) fn arc(self, length: f64, bend: f64) -> Self {
        let half = bend / 2.0;
        let chord = if half.abs() < 1e-9 { length } else { length * half.sin() / half };
        let end = Self { direction: self.direction + half, ..self }.straight(chord);
        Self { direction: self.direction + bend, ..end }
    }
}

/// Ends of the stiff tail, of each segment, and of the head, from the hand on: the segments as arcs of constant length.
#[must_use]
pub fn chain(bends_deg: [f64; 3]) -> [Pose; 5] {
    let tail = Pose { x: 0.0, y: 0.0, direction: 0.0 }.straight(END_MM);
    let [p, m, d] = bends_deg.map(f64::to_radians);
    let proximal = tail.arc(CHAMBER_MM, p);
    let middle = proximal.arc(CHAMBER_MM, m);
    let distal = middle.arc(CHAMBER_MM, d);
    [tail, proximal, middle, distal, distal.straight(END_MM)]
}

/// The finger as SVG elements; the hand's end is the origin, the palm is below.
fn shape(bends_deg: [f64; 3]) -> String {
    const POINTS: u32 = 16;
    let chain = chain(bends_deg);
    let mut out = String::new();
    let mut path = |from: Pose, length: f64, bend: f64, colour: &str, width: f64| {
        let points = (0..=POINTS).fold(String::new(), |mut points, index| {
            let share = f64::from(index) / f64::from(POINTS);
            let at = from.arc(length * share, bend * share);
            let _ = write!(points, "{:.2},{:.2} ", at.x, at.y);
            points
        });
        let points = points.trim_end();
        let _ = write!(
            out,
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" \
             stroke-linejoin=\"round\"/>"
        );
    };
    let origin = Pose { x: 0.0, y: 0.0, direction: 0.0 };
    path(origin, END_MM, 0.0, "#8a9099", HEIGHT_MM);
    for (index, colour) in COLOURS.iter().enumerate() {
        path(chain[index], CHAMBER_MM, bends_deg[index].to_radians(), colour, HEIGHT_MM);
    }
    path(chain[3], END_MM, 0.0, "#8a9099", HEIGHT_MM);
    // The neutral fibre, and the joints between the segments.
    for (index, bend) in bends_deg.iter().enumerate() {
        path(chain[index], CHAMBER_MM, bend.to_radians(), "#ffffff", 1.2);
    }
    for pose in &chain[..4] {
        let _ = write!(out, "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"3\" fill=\"#ffffff\"/>", pose.x, pose.y);
    }
    out
}

/// The finger at the end of each step that holds, side by side: at most `most` frames, evenly chosen.
#[must_use]
pub fn filmstrip(summary: &Summary, most: usize) -> String {
    const WIDTH: f64 = 190.0;
    const HEIGHT: f64 = 230.0;
    let holds: Vec<&StepSummary> = summary.steps.iter().filter(|step| step.hold_start_s.is_some()).collect();
    let every = holds.len().div_ceil(most.max(1)).max(1);
    let frames: Vec<_> = holds.into_iter().step_by(every).collect();
    let width = WIDTH * frames.len().max(1) as f64;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {HEIGHT}\" width=\"{width}\" \
         height=\"{HEIGHT}\" font-family=\"sans-serif\"><rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>"
    );
    for (index, step) in frames.iter().enumerate() {
        let x = WIDTH * index as f64;
        let _ = write!(
            out,
            "<g transform=\"translate({x} 0)\"><g transform=\"translate(42 62) scale(0.95)\">{}</g>\
             <text x=\"95\" y=\"204\" text-anchor=\"middle\" font-size=\"12\" fill=\"#3c4048\">{:.1} s</text>\
             <text x=\"95\" y=\"221\" text-anchor=\"middle\" font-size=\"11\" fill=\"#6a7079\">{}</text></g>",
            shape(step.segment_bend_deg),
            step.end_s,
            step.segment_bend_deg.map(|bend| format!("{bend:.0}°")).join(" · "),
        );
    }
    let _ = write!(out, "<g transform=\"translate(8 16)\" font-size=\"11\">");
    for (segment, colour) in Segment::ALL.iter().zip(COLOURS) {
        let x = 62 * *segment as usize;
        let _ = write!(out, "<text x=\"{x}\" y=\"0\" fill=\"{colour}\">{}</text>", segment.name());
    }
    out.push_str("</g></svg>\n");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(pose: Pose, x: f64, y: f64, degrees: f64) {
        let off = (pose.x - x).abs().max((pose.y - y).abs()).max((pose.direction.to_degrees() - degrees).abs());
        assert!(off < 1e-9, "{pose:?}");
    }

    #[test]
    fn a_straight_finger_is_as_long_as_its_parts() {
        near(chain([0.0; 3])[4], 2.0 * END_MM + 3.0 * CHAMBER_MM, 0.0, 0.0);
    }

    #[test]
    fn a_quarter_turn_ends_one_radius_away_in_both_directions() {
        let radius = CHAMBER_MM / core::f64::consts::FRAC_PI_2;
        near(chain([90.0, 0.0, 0.0])[1], END_MM + radius, radius, 90.0);
    }

    #[test]
    fn the_bends_add_up() {
        assert!((chain([10.0, 20.0, 30.0])[4].direction.to_degrees() - 60.0).abs() < 1e-9);
    }
}
