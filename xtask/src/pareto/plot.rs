//! Worst error against instructions, both logarithmic: one mark a method, and the line of those that nothing beats.

use super::figures::{Direction, Entry, Report, grouped};
use super::labels::{self, FONT, Place, text_size};
use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const SIZE: (u32, u32) = (900, 660);
const INK: RGBColor = RGBColor(60, 64, 72);
const FAINT: RGBColor = RGBColor(226, 229, 234);
const GREY: RGBColor = RGBColor(160, 165, 173);
/// For letters, which need more contrast than marks.
const DARK_GREY: RGBColor = RGBColor(112, 117, 126);
const FRONT: RGBColor = RGBColor(0, 114, 178);
const CHOSEN: RGBColor = RGBColor(213, 94, 0);
const REFERENCE: RGBColor = RGBColor(0, 158, 115);

/// Resolution of I16F16.
const OUTPUT_LSB: f64 = 1.0 / 65_536.0;

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
    let point = |entry: &Entry| (entry.instructions_mean.max(1.0), entry.max_error_working.max(f64::EPSILON));
    let (sensor, sensor_name) = sensor(direction);
    let x = range(entries.iter().map(|entry| point(entry).0), 0.6, 2.0);
    let y = range(entries.iter().map(|entry| point(entry).1).chain([OUTPUT_LSB, sensor]), 0.2, 6.0);
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
        .y_labels(20)
        .y_label_formatter(&|value| power_of_ten(*value))
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
        write(area, &name, place, HPos::Right, REFERENCE)?;
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

    legend(area, bounds, &mut taken)?;

    let mut marks: Vec<((i32, i32), String)> = Vec::new();
    let mut kinds: Vec<Kind> = Vec::new();
    for entry in entries {
        let mark = chart.backend_coord(&point(entry));
        let kind = Kind::of(entry, front);
        // Two on the same spot share a label.
        if let Some(index) = marks.iter().position(|(other, _)| *other == mark) {
            marks[index].1 += &format!(", {}", entry.method);
            kinds[index] = kinds[index].min(kind);
        } else {
            marks.push((mark, entry.method.clone()));
            kinds.push(kind);
        }
    }
    let places = labels::places(&marks, &taken, bounds);
    for (&(mark, _), place) in marks.iter().zip(&places) {
        if let Some((from, to)) = labels::leader(mark, place) {
            area.draw(&PathElement::new([from, to], GREY.stroke_width(1))).map_err(drawing)?;
        }
    }
    for (((mark, name), kind), place) in marks.iter().zip(kinds).zip(places) {
        area.draw(&kind.circle(*mark)).map_err(drawing)?;
        let side = match mark.0 {
            x if x <= place.0 => HPos::Left,
            x if x >= place.2 => HPos::Right,
            _ => HPos::Center,
        };
        write(area, name, place, side, kind.ink())?;
    }
    Ok(())
}

/// How a method fares; the first is the most to be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Chosen,
    OnFront,
    Beaten,
}

impl Kind {
    /// Each with what the legend says.
    const ALL: [(Self, &'static str); 3] = [
        (Self::Chosen, "the core's own"),
        (Self::OnFront, "beaten by no other"),
        (Self::Beaten, "beaten in both error and instructions"),
    ];

    fn of(entry: &Entry, front: &[&Entry]) -> Self {
        if entry.chosen() {
            Self::Chosen
        } else if front.iter().any(|other| other.method == entry.method) {
            Self::OnFront
        } else {
            Self::Beaten
        }
    }

    fn circle(self, mark: (i32, i32)) -> Circle<(i32, i32), i32> {
        let (radius, colour) = match self {
            Self::Chosen => (6, CHOSEN),
            Self::OnFront => (4, FRONT),
            Self::Beaten => (4, GREY),
        };
        Circle::new(mark, radius, colour.filled())
    }

    const fn ink(self) -> RGBColor {
        match self {
            Self::Chosen => CHOSEN,
            Self::OnFront => FRONT,
            Self::Beaten => DARK_GREY,
        }
    }
}

/// What the colours mean, in the corner where nothing can be: few instructions and no error.
fn legend(area: &DrawingArea<SVGBackend<'_>, Shift>, bounds: Place, taken: &mut Vec<Place>) -> Result<()> {
    for (line, (kind, text)) in (1..).zip(Kind::ALL.iter().rev()) {
        let (width, height) = text_size(text);
        let (left, top) = (bounds.0 + 22, bounds.3 - 20 * line);
        let place = Place(left, top, left + width, top + height);
        area.draw(&kind.circle((left - 12, top + height / 2))).map_err(drawing)?;
        write(area, text, place, HPos::Left, kind.ink())?;
        taken.push(Place(bounds.0, top, left + width, top + height));
    }
    Ok(())
}

/// A power of ten as people write it.
fn power_of_ten(value: f64) -> String {
    let exponent = value.log10().round() as i32;
    let superscript = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    match exponent {
        -2..=2 => format!("{}", 10_f64.powi(exponent)),
        _ => format!("10{}", exponent.to_string().chars().map(superscript).collect::<String>()),
    }
}

/// Writes into a place, which is a little wider than the text: on the side that is nearer to what it belongs to.
fn write(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    text: &str,
    place: Place,
    side: HPos,
    colour: RGBColor,
) -> Result<()> {
    let x = match side {
        HPos::Left => place.0,
        HPos::Center => i32::midpoint(place.0, place.2),
        HPos::Right => place.2,
    };
    let style = ("sans-serif", FONT).into_font().color(&colour).pos(Pos::new(side, VPos::Top));
    // The letters' top is above that of their line.
    area.draw(&Text::new(text.to_owned(), (x, place.1 + 2), style)).map_err(drawing)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pareto::figures::tests::report;

    #[test]
    fn powers_of_ten_are_readable() {
        assert_eq!([1e1, 1.0, 0.01, 1e-3, 1e-14, 1e25].map(power_of_ten), ["10", "1", "0.01", "10⁻³", "10⁻¹⁴", "10²⁵"]);
    }

    #[test]
    fn methods_on_one_spot_share_a_label() {
        let methods = [("segment-newton", 1e-5, 1300.0), ("twin", 1e-5, 1300.0), ("floating-quartic", 1e-2, 50.0)];
        let svg = picture(&report(&methods), Direction::Pressure).expect("draws");
        assert!(svg.contains("segment-newton, twin"));
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
