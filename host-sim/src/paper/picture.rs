//! The report's curves, with the paper's points on them.

use super::points::{Fit, Places, SETS};
use super::{Report, bend, combinations, equations, force};
use crate::drawing::{Area, Chart, INK, drawing, series_labels, styled, svg};
use crate::report::finger::{CHAMBER_MM, END_MM, chain};
use crate::report::plots::SEGMENT_COLOURS;
use anyhow::Result;
use model_core::calibration;
use model_core::force::DrivingForce;
use model_core::paper;
use model_core::units::Pressure;
use plotters::prelude::*;

/// The rows of Table 2 and 3: bare, exoskeleton, finger.
const ROWS: [RGBColor; 3] = [RGBColor(148, 152, 160), RGBColor(0, 114, 178), RGBColor(213, 94, 0)];
const CAVITY: RGBColor = RGBColor(0, 158, 115);
/// Tail and head.
const STIFF: RGBColor = RGBColor(138, 144, 153);

/// Axes of a panel.
fn panel<'a, 'b>(area: &'a Area<'b>, caption: &str, y: &str, most: f64) -> Result<Chart<'a, 'b>> {
    let mut chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 15, &INK))
        .margin(8)
        .x_label_area_size(36)
        .y_label_area_size(50)
        .build_cartesian_2d(0.0..160.0, 0.0..most)
        .map_err(drawing)?;
    styled(&mut chart.configure_mesh())
        .x_desc("pressure, kPa")
        .y_desc(y)
        .x_label_formatter(&|value| format!("{value:.0}"))
        .y_label_formatter(&|value| format!("{value}"))
        .draw()
        .map_err(drawing)?;
    Ok(chart)
}

fn curve(chart: &mut Chart<'_, '_>, points: Vec<(f64, f64)>, ink: RGBColor, name: &str) -> Result<()> {
    let series = LineSeries::new(points, ink.stroke_width(2));
    let drawn = chart.draw_series(series).map_err(drawing)?;
    if !name.is_empty() {
        drawn.label(name).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], ink.stroke_width(2)));
    }
    Ok(())
}

fn dots(chart: &mut Chart<'_, '_>, points: Vec<(f64, f64)>, ink: RGBColor) -> Result<()> {
    chart.draw_series(points.into_iter().map(|at| Circle::new(at, 4, ink.filled()))).map_err(drawing)?;
    Ok(())
}

fn crosses(chart: &mut Chart<'_, '_>, points: Vec<(f64, f64)>, ink: RGBColor) -> Result<()> {
    chart.draw_series(points.into_iter().map(|at| Cross::new(at, 5, ink.stroke_width(2)))).map_err(drawing)?;
    Ok(())
}

/// What the marks mean, and the legend.
fn legend<'a, 'b: 'a>(chart: &mut Chart<'a, 'b>, position: SeriesLabelPosition) -> Result<()> {
    chart
        .draw_series(std::iter::empty::<Circle<(f64, f64), i32>>())
        .map_err(drawing)?
        .label("measured")
        .legend(|(x, y)| Circle::new((x + 9, y), 4, INK.filled()));
    chart
        .draw_series(std::iter::empty::<Circle<(f64, f64), i32>>())
        .map_err(drawing)?
        .label("paper's finite elements")
        .legend(|(x, y)| Cross::new((x + 9, y), 5, INK.stroke_width(2)));
    series_labels(chart, position)
}

fn pressures() -> impl Iterator<Item = f64> {
    (0..=300).map(|step| 0.5 * f64::from(step))
}

/// Bend against pressure: a small cavity and the chamber on the left, the finger on the right.
pub fn bend(report: &Report) -> Result<String> {
    svg((1100, 440), &|area| {
        let (left, right) = area.split_horizontally(550);
        let mut chart = panel(&left, "Chamber and small cavity (figures 13, 23, 38)", "bend, degrees", 125.0)?;
        for (row, ink) in report.bend.iter().zip(ROWS).take(2) {
            bend_row(&mut chart, row, ink)?;
        }
        if let [_, exoskeleton, _] = report.bend.as_slice() {
            let coefficients = bend::coefficients(exoskeleton.coefficients_kpa)?;
            let share = |kpa: f64| bend::bend_deg(&coefficients, kpa) / paper::SMALL_CAVITIES;
            curve(&mut chart, pressures().map(|kpa| (kpa, share(kpa))).collect(), CAVITY, "small cavity: a fifth")?;
        }
        crosses(&mut chart, vec![(150.0, report.small_cavity.fem_150_deg)], CAVITY)?;
        legend(&mut chart, SeriesLabelPosition::UpperLeft)?;
        let mut chart = panel(&right, "Finger of three chambers (figure 41)", "bend, degrees", 375.0)?;
        for (row, ink) in report.bend.iter().zip(ROWS).skip(2) {
            bend_row(&mut chart, row, ink)?;
        }
        legend(&mut chart, SeriesLabelPosition::UpperLeft)
    })
}

fn bend_row(chart: &mut Chart<'_, '_>, row: &bend::Row, ink: RGBColor) -> Result<()> {
    let coefficients = bend::coefficients(row.coefficients_kpa)?;
    let line = pressures().map(|kpa| (kpa, row.segments * bend::bend_deg(&coefficients, kpa))).collect();
    curve(chart, line, ink, row.name)?;
    crosses(chart, vec![(150.0, row.fem_150_deg)], ink)?;
    dots(chart, row.points.iter().map(|point| (point.pressure_kpa, point.measured_deg)).collect(), ink)
}

/// Driving force against pressure.
pub fn force(report: &Report) -> Result<String> {
    let functions = [DrivingForce::CHAMBER_BARE, DrivingForce::CHAMBER_EXO, DrivingForce::FINGER];
    svg((760, 460), &|area| {
        let mut chart = panel(area, "Driving force (figures 24, 42)", "force, N", 13.0)?;
        for ((row, ink), function) in report.force.iter().zip(ROWS).zip(functions) {
            force_row(&mut chart, row, ink, &function)?;
        }
        crosses(&mut chart, vec![(150.0, paper::FEM_SMALL_CAVITY_N)], CAVITY)?;
        chart
            .draw_series(std::iter::empty::<Circle<(f64, f64), i32>>())
            .map_err(drawing)?
            .label("small cavity")
            .legend(|(x, y)| Cross::new((x + 9, y), 5, CAVITY.stroke_width(2)));
        legend(&mut chart, SeriesLabelPosition::UpperLeft)
    })
}

fn force_row(chart: &mut Chart<'_, '_>, row: &force::Row, ink: RGBColor, function: &DrivingForce) -> Result<()> {
    let at = |kpa: f64| function.at(Pressure::from_f64_kpa(kpa)).to_f64();
    curve(chart, pressures().map(|kpa| (kpa, at(kpa))).collect(), ink, row.name)?;
    crosses(chart, vec![(150.0, row.fem_150_n)], ink)?;
    dots(chart, row.points.iter().map(|point| (point.pressure_kpa, point.measured_n)).collect(), ink)
}

/// Equal scales: millimetres right and down.
fn plane<'a, 'b>(area: &'a Area<'b>, caption: &str, x: [f64; 2], top: f64) -> Result<Chart<'a, 'b>> {
    const LABELS: u32 = 34;
    const MARGIN: u32 = 6;
    let (width, height) = area.dim_in_pixel();
    // What is left to the plot, so that a millimetre is the same both ways.
    let plot_width = width - LABELS - 2 * MARGIN;
    let plot_height = height - LABELS - 2 * MARGIN - 24;
    let bottom = top + (x[1] - x[0]) * f64::from(plot_height) / f64::from(plot_width);
    let mut chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 14, &INK))
        .margin(MARGIN)
        .x_label_area_size(LABELS)
        .y_label_area_size(LABELS)
        .build_cartesian_2d(x[0]..x[1], bottom..top)
        .map_err(drawing)?;
    styled(&mut chart.configure_mesh())
        .label_style(("sans-serif", 10, &INK))
        .x_labels(6)
        .y_labels(6)
        .x_desc("mm")
        .x_label_formatter(&|value| format!("{value:.0}"))
        .y_label_formatter(&|value| format!("{value:.0}"))
        .draw()
        .map_err(drawing)?;
    Ok(chart)
}

/// The finger's middle line: tail, three arcs, head.
fn finger(chart: &mut Chart<'_, '_>, bends_deg: [f64; 3], place: impl Fn(f64, f64) -> (f64, f64)) -> Result<()> {
    const PARTS: u32 = 12;
    let whole = chain(bends_deg);
    let [tail, _, _, end, tip] = whole;
    let ends = [[place(tail.x - END_MM, tail.y), place(tail.x, tail.y)], [place(end.x, end.y), place(tip.x, tip.y)]];
    for line in ends {
        chart.draw_series(LineSeries::new(line, STIFF.stroke_width(6))).map_err(drawing)?;
    }
    for (segment, colour) in SEGMENT_COLOURS.into_iter().enumerate() {
        // The joint after a part of this segment's bend, over a part of its length.
        let start = whole[segment];
        let bend = bends_deg[segment].to_radians();
        let points = (0..=PARTS).map(|part| {
            let share = f64::from(part) / f64::from(PARTS);
            let along = start.arc(CHAMBER_MM * share, bend * share);
            place(along.x, along.y)
        });
        chart.draw_series(LineSeries::new(points.collect::<Vec<_>>(), colour.stroke_width(6))).map_err(drawing)?;
    }
    Ok(())
}

/// The seven combinations at 30, 90 and 150 kPa.
pub fn combinations(report: &Report) -> Result<String> {
    svg((1100, 620), &|area| {
        let panels = area.split_evenly((2, 4));
        for ((_, name), panel) in combinations::ALL.into_iter().zip(&panels) {
            let mut chart = plane(panel, &format!("{name}: 30, 90, 150 kPa"), [-62.0, 138.0], -70.0)?;
            let shown =
                |row: &&combinations::Row| row.segments == name && [30.0, 90.0, 150.0].contains(&row.pressure_kpa);
            for row in report.combinations.iter().filter(shown) {
                finger(&mut chart, row.bends_deg, |x, y| (x, y))?;
            }
        }
        if let Some(last) = panels.last() {
            let lines = [
                ("proximal", SEGMENT_COLOURS[0]),
                ("middle", SEGMENT_COLOURS[1]),
                ("distal", SEGMENT_COLOURS[2]),
                ("tail and head", STIFF),
            ];
            for (place, (name, ink)) in (0..).zip(lines) {
                let style = ("sans-serif", 14, &ink).into_text_style(last);
                last.draw_text(name, &style, (40, 50 + 24 * place)).map_err(drawing)?;
            }
            let style = ("sans-serif", 12, &INK).into_text_style(last);
            last.draw_text("The paper's values: not given", &style, (40, 160)).map_err(drawing)?;
        }
        Ok(())
    })
}

/// The points A, B, C and what the readings make of them.
pub fn points(report: &Report) -> Result<String> {
    let fits = &report.kinematics.fits;
    let find = |reading: &str| fits.iter().find(|fit| fit.reading == reading && fit.points == "measured");
    svg((1100, 520), &|area| {
        let panels = area.split_evenly((1, 3));
        let shown = [
            ("arcs, Table 1", "Arcs of 38 mm, nothing fitted"),
            ("arcs, length and height", "Equal arcs, length and height fitted"),
            ("links turned by the sum, unequal", "Three rigid links and their start fitted"),
        ];
        for ((reading, caption), panel) in shown.into_iter().zip(&panels) {
            let Some(fit) = find(reading) else { continue };
            let caption = format!("{caption}: rms {:.1} mm", fit.rms_mm);
            points_panel(panel, fit, &caption)?;
        }
        Ok(())
    })
}

fn points_panel(area: &Area<'_>, fit: &Fit, caption: &str) -> Result<()> {
    let mut chart = plane(area, caption, [-40.0, 60.0], -5.0)?;
    let pairs = |places: &Places| places.iter().map(|&[x, y]| (x, y)).collect::<Vec<_>>();
    let start = |name: &str| fit.open_mm.iter().find(|(open, _)| *open == name).map(|(_, value)| *value);
    if fit.reading.starts_with("arcs") {
        let y0 = start("y0").unwrap_or(paper::EXOSKELETON_HEIGHT_MM);
        let length = start("arc").unwrap_or(paper::CHAMBER_LENGTH_MM) / paper::CHAMBER_LENGTH_MM;
        let [at_30, at_60, ..] = paper::CHAMBER_EXO_DEG;
        // The chain's tail ends where the proximal segment begins.
        finger(&mut chart, [at_60, at_30, at_60], |x, y| ((x - END_MM) * length, y * length + y0))?;
    } else {
        let from = (start("x0").unwrap_or(0.0), start("y0").unwrap_or(0.0));
        let mut line = vec![from];
        line.extend(pairs(&fit.places_mm));
        for (leg, colour) in line.windows(2).zip(SEGMENT_COLOURS) {
            chart.draw_series(LineSeries::new(leg.to_vec(), colour.stroke_width(6))).map_err(drawing)?;
        }
    }
    for (place, given) in pairs(&fit.places_mm).into_iter().zip(pairs(&paper::POINTS_MEASURED_MM)) {
        chart.draw_series(LineSeries::new([place, given], INK.stroke_width(1))).map_err(drawing)?;
    }
    // The model's and the finite elements' points nearly cover each other.
    let given: [(&str, RGBColor, i32, &Places); 3] = [
        ("paper's model", RGBColor(240, 180, 40), 6, &SETS[0].1),
        ("finite elements", RGBColor(204, 121, 167), 3, &SETS[1].1),
        ("measured", INK, 4, &SETS[2].1),
    ];
    for (name, ink, size, places) in given {
        chart
            .draw_series(pairs(places).into_iter().map(|at| Circle::new(at, size, ink.filled())))
            .map_err(drawing)?
            .label(name)
            .legend(move |(x, y)| Circle::new((x + 9, y), size, ink.filled()));
    }
    chart
        .draw_series(pairs(&fit.places_mm).into_iter().map(|at| Circle::new(at, 5, INK.stroke_width(1))))
        .map_err(drawing)?
        .label("this reading")
        .legend(|(x, y)| Circle::new((x + 9, y), 5, INK.stroke_width(1)));
    // Beside the finger, where no reading runs.
    let beside = [(9.0, -2.0), (-9.0, -3.0), (-7.0, -6.0)];
    for ((letter, (x, y)), (right, down)) in
        ["A", "B", "C"].into_iter().zip(pairs(&paper::POINTS_MEASURED_MM)).zip(beside)
    {
        let style = ("sans-serif", 16, &INK).into_text_style(area);
        chart.draw_series([Text::new(letter, (x + right, y + down), style)]).map_err(drawing)?;
    }
    chart.draw_series([Cross::new((0.0, 0.0), 5, INK.stroke_width(1))]).map_err(drawing)?;
    let style = ("sans-serif", 11, &INK).into_text_style(area);
    chart.draw_series([Text::new("origin: the section's corner", (3.0, -1.5), style)]).map_err(drawing)?;
    series_labels(&mut chart, SeriesLabelPosition::LowerRight)
}

/// dW/dα as printed and corrected on the left, the calibrated pressure on the right.
pub fn equations() -> Result<String> {
    let rows = equations::rows(2.0, 112.0, 220);
    svg((1100, 420), &|area| {
        let (left, right) = area.split_horizontally(550);
        let along = |of: fn(&equations::Row) -> f64| rows.iter().map(|row| (row.bend_deg, of(row))).collect::<Vec<_>>();
        let axes = |area, caption: &str, y: &str, range: core::ops::Range<f64>| -> Result<Chart<'_, '_>> {
            let mut chart = ChartBuilder::on(area)
                .caption(caption, ("sans-serif", 15, &INK))
                .margin(8)
                .x_label_area_size(36)
                .y_label_area_size(54)
                .build_cartesian_2d(0.0..120.0, range)
                .map_err(drawing)?;
            styled(&mut chart.configure_mesh())
                .x_desc("bend, degrees")
                .y_desc(y)
                .x_label_formatter(&|value| format!("{value:.0}"))
                // Not "-0".
                .y_label_formatter(&|value| format!("{}", (value * 100.0).round() / 100.0 + 0.0))
                .draw()
                .map_err(drawing)?;
            Ok(chart)
        };
        let inside = |points: Vec<(f64, f64)>| points.into_iter().filter(|at| at.1 <= 1.0).collect::<Vec<_>>();
        let mut chart = axes(&left, "The wall's work: as printed, corrected", "dW/dα, MPa", -0.1..1.0)?;
        curve(&mut chart, vec![(0.0, 0.0), (120.0, 0.0)], INK, "")?;
        curve(&mut chart, inside(along(|row| row.printed_work_mpa)), ROWS[2], "as printed")?;
        curve(&mut chart, inside(along(|row| row.corrected_work_mpa)), ROWS[1], "corrected")?;
        series_labels(&mut chart, SeriesLabelPosition::UpperLeft)?;
        let mut chart = axes(&right, "Calibrated model, chamber with exoskeleton", "pressure, kPa", 0.0..160.0)?;
        let default = calibration::DEFAULT.to_f64_kpa();
        let line = rows.iter().map(|row| (row.bend_deg, calibration::pressure_kpa(default, row.bend_deg)));
        curve(&mut chart, line.filter(|at| at.1 < 158.0).collect(), ROWS[1], "calibrated")?;
        dots(&mut chart, paper::CHAMBER_EXO_DEG.into_iter().zip(paper::PRESSURE_KPA).collect(), INK)?;
        chart
            .draw_series(std::iter::empty::<Circle<(f64, f64), i32>>())
            .map_err(drawing)?
            .label("measured")
            .legend(|(x, y)| Circle::new((x + 9, y), 4, INK.filled()));
        series_labels(&mut chart, SeriesLabelPosition::UpperLeft)
    })
}
