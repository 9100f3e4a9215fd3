//! Worst error against instructions, both logarithmic: one mark a method, and the line of those that nothing beats.

use super::figures::{Direction, Entry, Report, grouped};
use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const SIZE: (u32, u32) = (900, 560);
const INK: RGBColor = RGBColor(60, 64, 72);
const FAINT: RGBColor = RGBColor(226, 229, 234);
const GREY: RGBColor = RGBColor(160, 165, 173);
const FRONT: RGBColor = RGBColor(0, 114, 178);
const CHOSEN: RGBColor = RGBColor(213, 94, 0);
const REFERENCE: RGBColor = RGBColor(0, 158, 115);
const FONT: i32 = 13;

/// Resolution of I16F16.
const OUTPUT_LSB: f64 = 1.0 / 65_536.0;

/// Below this a mark lies on the picture's lower edge, and its label tells the error: a thousandth of the output's LSB
/// is of no more use than a tenth.
const FLOOR: f64 = 2e-8;

/// Resolution of the sensors: 0.1 degree (BF350 with its amplifier), 1 kPa (ISE30A).
const fn sensor(direction: Direction) -> (f64, &'static str) {
    match direction {
        Direction::Bend => (0.1, "bend sensor, 0.1 degree"),
        Direction::Pressure => (1.0, "pressure sensor, 1 kPa"),
    }
}

#[expect(clippy::needless_pass_by_value, reason = "the form that map_err takes")]
fn drawing<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> anyhow::Error {
    anyhow!("cannot draw: {error}")
}

/// A rectangle in pixels: left, top, right, bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place(i32, i32, i32, i32);

impl Place {
    const fn around((x, y): (i32, i32), half: i32) -> Self {
        Self(x - half, y - half, x + half, y + half)
    }

    /// A line, level or upright, with a little air.
    fn along(one: (i32, i32), other: (i32, i32)) -> Self {
        Self(one.0.min(other.0) - 1, one.1.min(other.1) - 1, one.0.max(other.0) + 1, one.1.max(other.1) + 1)
    }

    const fn meets(&self, other: &Self) -> bool {
        self.0 < other.2 && other.0 < self.2 && self.1 < other.3 && other.1 < self.3
    }

    const fn inside(&self, other: &Self) -> bool {
        self.0 >= other.0 && self.1 >= other.1 && self.2 <= other.2 && self.3 <= other.3
    }
}

/// Room that a text of [`FONT`] takes; 0.58 of its height a letter is on the safe side for a sans-serif.
fn text_size(text: &str) -> (i32, i32) {
    ((text.chars().count() as f64 * f64::from(FONT) * 0.58).ceil() as i32 + 2, FONT + 3)
}

/// A place for each label, near its mark, that meets no mark, no other label and nothing that is `taken`.
fn label_places(marks: &[((i32, i32), String)], taken: &[Place], bounds: Place) -> Vec<Place> {
    let mut obstacles: Vec<_> = marks.iter().map(|&(mark, _)| Place::around(mark, 6)).collect();
    obstacles.extend(taken);
    let mut places = Vec::new();
    for &((x, y), ref text) in marks {
        let (width, height) = text_size(text);
        let candidates = (0..40).flat_map(|ring| {
            let away = 11 + ring * 5;
            let [right, left, middle] = [x + away.min(60), x - away.min(60) - width, x - width / 2];
            let [above, level, below] = [y - away - height / 2, y - height / 2, y + away - height / 2];
            [(right, level), (left, level), (middle, above), (middle, below)]
                .into_iter()
                .chain([(right, above), (right, below), (left, above), (left, below)])
                .map(move |(left, top)| Place(left, top, left + width, top + height))
        });
        let free = |place: &Place| place.inside(&bounds) && !obstacles.iter().any(|other| place.meets(other));
        let place = candidates.into_iter().find(free).unwrap_or(Place(x + 10, y, x + 10 + width, y + height));
        obstacles.push(place);
        places.push(place);
    }
    places
}

/// The range of the values, widened to look well on a logarithmic axis.
fn range(values: impl Iterator<Item = f64>, below: f64, above: f64) -> core::ops::Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    low * below..high * above
}

/// The picture as SVG. A method without a finite error is in the tables only.
pub fn picture(report: &Report, direction: Direction) -> Result<String> {
    let entries: Vec<_> =
        report.of(direction).into_iter().filter(|entry| entry.max_error_working.is_finite()).collect();
    let front = report.front(direction);
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE).map_err(drawing)?;
        draw(&area, direction, &entries, &front)?;
        area.present().map_err(drawing)?;
    }
    Ok(text)
}

fn draw(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    direction: Direction,
    entries: &[&Entry],
    front: &[&Entry],
) -> Result<()> {
    let point = |entry: &Entry| (entry.instructions_mean.max(1.0), entry.max_error_working.max(FLOOR));
    let (sensor, sensor_name) = sensor(direction);
    let x = range(entries.iter().map(|entry| point(entry).0), 0.6, 2.5);
    let y = range(entries.iter().map(|entry| point(entry).1).chain([OUTPUT_LSB, sensor]), 0.3, 3.0);
    let title = match direction {
        Direction::Bend => "Bend from pressure",
        Direction::Pressure => "Pressure from bend",
    };
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 17, &INK))
        .margin(8)
        .margin_right(18)
        .x_label_area_size(44)
        .y_label_area_size(66)
        .build_cartesian_2d(x.clone().log_scale(), y.clone().log_scale())
        .map_err(drawing)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE.mix(0.0))
        .bold_line_style(FAINT)
        .axis_style(INK)
        .label_style(("sans-serif", 12, &INK))
        .x_label_formatter(&|value| grouped(value.round() as u64))
        .y_label_formatter(&|value| format!("{value:.0e}"))
        .x_desc("instructions on the Cortex-M4, mean over 0-150 kPa")
        .y_desc(format!("worst error over 0-150 kPa, any calibration, {}", direction.unit()))
        .draw()
        .map_err(drawing)?;

    let mut taken = Vec::new();
    let (left, right) = (chart.backend_coord(&(x.start, y.end)), chart.backend_coord(&(x.end, y.start)));
    let bounds = Place(left.0 + 4, left.1 + 4, right.0 - 4, right.1 - 4);
    for (value, name) in [(OUTPUT_LSB, "output's LSB, 2⁻¹⁶".to_owned()), (sensor, sensor_name.to_owned())] {
        let line = DashedLineSeries::new([(x.start, value), (x.end, value)], 5, 4, REFERENCE.stroke_width(1));
        chart.draw_series(line).map_err(drawing)?;
        let end = chart.backend_coord(&(x.end, value));
        let (width, height) = text_size(&name);
        let place = Place(end.0 - width - 4, end.1 - height, end.0 - 4, end.1 - 1);
        write(area, &name, place, REFERENCE)?;
        taken.extend([place, Place::along(chart.backend_coord(&(x.start, value)), end)]);
    }

    // From one to the next the line goes along what is already reached: right, then down.
    let mut steps: Vec<(f64, f64)> = Vec::new();
    for entry in front {
        let (across, down) = point(entry);
        steps.extend(steps.last().map(|&(_, level)| (across, level)));
        steps.push((across, down));
    }
    steps.extend(steps.last().map(|&(_, level)| (x.end, level)));
    let corners: Vec<_> = steps.iter().map(|step| chart.backend_coord(step)).collect();
    taken.extend(corners.windows(2).map(|ends| Place::along(ends[0], ends[1])));
    chart.draw_series(LineSeries::new(steps, FRONT.mix(0.6).stroke_width(2))).map_err(drawing)?;

    let label = |entry: &Entry| {
        let Entry { method, max_error_working: error, .. } = entry;
        if *error < FLOOR { format!("{method}, {error:.0e}") } else { method.clone() }
    };
    let marks: Vec<_> = entries.iter().map(|entry| (chart.backend_coord(&point(entry)), label(entry))).collect();
    let places = label_places(&marks, &taken, bounds);
    for ((entry, &(mark, ref name)), place) in entries.iter().zip(&marks).zip(places) {
        let on_front = front.iter().any(|other| other.method == entry.method);
        let colour = if entry.chosen() {
            CHOSEN
        } else if on_front {
            FRONT
        } else {
            GREY
        };
        // A line to a label that had to go further away.
        let near = (mark.0.clamp(place.0, place.2), mark.1.clamp(place.1, place.3));
        if (near.0 - mark.0).pow(2) + (near.1 - mark.1).pow(2) > 13 * 13 {
            area.draw(&PathElement::new([mark, near], GREY.stroke_width(1))).map_err(drawing)?;
        }
        let radius = if entry.chosen() { 6 } else { 4 };
        area.draw(&Circle::new(mark, radius, colour.filled())).map_err(drawing)?;
        write(area, name, place, colour)?;
    }
    Ok(())
}

fn write(area: &DrawingArea<SVGBackend<'_>, Shift>, text: &str, place: Place, colour: RGBColor) -> Result<()> {
    let style = ("sans-serif", FONT).into_font().color(&colour).pos(Pos::new(HPos::Left, VPos::Top));
    area.draw(&Text::new(text.to_owned(), (place.0, place.1), style)).map_err(drawing)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pareto::figures::tests::report;

    #[test]
    fn labels_meet_neither_marks_nor_one_another() {
        // Thirteen marks on top of one another, nearly.
        let marks: Vec<_> = (0..13).map(|n| ((400 + n % 4, 300 + n / 4), format!("a-method-{n}"))).collect();
        let bounds = Place(60, 20, 880, 500);
        let places = label_places(&marks, &[], bounds);
        for (index, place) in places.iter().enumerate() {
            assert!(place.inside(&bounds), "{place:?}");
            assert!(!marks.iter().any(|&(mark, _)| place.meets(&Place::around(mark, 6))), "{place:?}");
            assert!(!places[..index].iter().any(|other| place.meets(other)), "{place:?}");
        }
    }

    #[test]
    fn every_method_is_named_and_the_same_figures_give_the_same_bytes() {
        let report =
            report(&[("segment-newton", 1e-5, 1300.0), ("beaten", 2e-5, 2000.0), ("floating-quartic", 1e-2, 50.0)]);
        let svg = picture(&report, Direction::Bend).expect("draws");
        for name in ["segment-newton", "beaten", "floating-quartic", "bend sensor"] {
            assert!(svg.contains(name), "{name}");
        }
        assert_eq!(svg, picture(&report, Direction::Bend).expect("draws"));
    }
}
