//! What the plots of a report show: curves and switches over time, the same for the pictures and for the page.

use super::record::Record;
use crate::drawing::INK;
use core::fmt;
use model_core::actuation::{Passage, Segment};
use plotters::style::RGBColor;

/// One colour a segment, apart in brightness too, so that they survive a grey printer and colour blindness (Okabe, Ito).
pub const SEGMENT_COLOURS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

/// A curve's colour: by name in the page, which has another shade of it on a dark background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// What belongs to the whole finger or the pump.
    Ink,
    /// What is asked for.
    Setpoint,
    /// What the controller believes.
    Estimate,
    /// What the bend sensor reads.
    Sensor,
    /// The dump valve.
    Dump,
    /// What belongs to a segment.
    Segment(Segment),
}

impl Colour {
    /// Its name among the page's colours.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ink => "ink",
            Self::Setpoint => "setpoint",
            Self::Estimate => "estimate",
            Self::Sensor => "sensor",
            Self::Dump => "dump",
            Self::Segment(segment) => segment.name(),
        }
    }

    /// On white.
    #[must_use]
    pub const fn rgb(self) -> RGBColor {
        match self {
            Self::Ink => INK,
            Self::Setpoint => RGBColor(150, 155, 165),
            Self::Estimate => RGBColor(90, 90, 90),
            Self::Sensor => RGBColor(200, 204, 212),
            Self::Dump => RGBColor(204, 121, 167),
            Self::Segment(segment) => SEGMENT_COLOURS[segment as usize],
        }
    }
}

/// One curve.
pub struct Curve {
    /// Its name.
    pub name: &'static str,
    /// Its colour.
    pub colour: Colour,
    /// Its width, pixels.
    pub width: u32,
    /// Its value at a moment; not a number where nobody knows.
    pub value: Box<dyn Fn(&Record) -> f64>,
}

impl fmt::Debug for Curve {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Curve").field("name", &self.name).finish_non_exhaustive()
    }
}

/// One plot over time.
#[derive(Debug)]
pub struct Chart {
    /// Its title.
    pub title: String,
    /// Unit of its curves.
    pub unit: &'static str,
    /// The lowest and the highest value shown while the whole run is.
    pub range: (f64, f64),
    /// Its curves, the last on top.
    pub curves: Vec<Curve>,
}

impl Chart {
    /// Without curves of which nobody knows anything; with room above the highest.
    fn new(title: String, unit: &'static str, least_top: f64, curves: Vec<Curve>, records: &[Record]) -> Self {
        let known = |curve: &Curve| records.iter().any(|record| (curve.value)(record).is_finite());
        let curves: Vec<Curve> = curves.into_iter().filter(known).collect();
        let values = curves.iter().flat_map(|curve| records.iter().map(|record| (curve.value)(record)));
        Self { title, unit, range: (-5.0, values.fold(least_top, f64::max) * 1.12), curves }
    }
}

fn curve(name: &'static str, colour: Colour, width: u32, value: impl Fn(&Record) -> f64 + 'static) -> Curve {
    Curve { name, colour, width, value: Box::new(value) }
}

/// Setpoint, estimate and, where it is known, true pressure of each chamber.
#[must_use]
pub fn pressures(records: &[Record]) -> [Chart; 3] {
    let mut charts = Segment::ALL.map(|segment| {
        let index = segment as usize;
        let told = records.iter().any(|record| record.chambers_kpa[index].is_finite());
        // Where no gauge tells the truth the estimate stands for it.
        let (colour, width) = if told { (Colour::Estimate, 1) } else { (Colour::Segment(segment), 2) };
        let curves = vec![
            curve("setpoint", Colour::Setpoint, 4, move |record| record.setpoints_kpa[index]),
            curve("estimate", colour, width, move |record| record.estimates_kpa[index]),
            curve("true pressure", Colour::Segment(segment), 2, move |record| record.chambers_kpa[index]),
        ];
        Chart::new(format!("{} chamber", segment.name()), "kPa", 20.0, curves, records)
    });
    // One scale for all three: they are read against one another.
    let top = charts.iter().map(|chart| chart.range.1).fold(0.0, f64::max);
    for chart in &mut charts {
        chart.range.1 = top;
    }
    charts
}

/// A segment's bend: the true one, else the controller's model's.
#[must_use]
pub fn bend_deg(record: &Record, index: usize) -> f64 {
    let told = record.bends_deg[index];
    if told.is_finite() { told } else { record.model_bends_deg[index] }
}

/// Bend of each segment and of the whole finger.
#[must_use]
pub fn bends(records: &[Record]) -> Chart {
    let mut curves = vec![
        // A failed sensor has no value to draw.
        curve("flex sensor", Colour::Sensor, 3, |record| record.bend_sensor_deg),
        curve("finger", Colour::Ink, 2, |record| [0, 1, 2].map(|index| bend_deg(record, index)).iter().sum()),
    ];
    for segment in Segment::ALL {
        let value = move |record: &Record| bend_deg(record, segment as usize);
        curves.push(curve(segment.name(), Colour::Segment(segment), 2, value));
    }
    Chart::new("bend".into(), "degrees", 30.0, curves, records)
}

/// One bar of the timing diagram.
#[derive(Clone, Copy, Debug)]
pub struct Switch {
    /// Its name, with the state that the bar stands for.
    pub name: &'static str,
    /// Its colour.
    pub colour: Colour,
    /// Whether the bar is drawn.
    pub on: fn(&Record) -> bool,
}

/// Pump and valves, from the top.
pub const SWITCHES: [Switch; 5] = [
    Switch { name: "pump on", colour: Colour::Ink, on: |record| record.actuation.pump },
    Switch { name: "dump open", colour: Colour::Dump, on: |record| record.actuation.dump == Passage::Open },
    Switch { name: "proximal open", colour: Colour::Segment(Segment::Proximal), on: |record| open(record, 0) },
    Switch { name: "middle open", colour: Colour::Segment(Segment::Middle), on: |record| open(record, 1) },
    Switch { name: "distal open", colour: Colour::Segment(Segment::Distal), on: |record| open(record, 2) },
];

fn open(record: &Record, index: usize) -> bool {
    record.actuation.segments[index] == Passage::Open
}

/// A row's time, s.
#[must_use]
pub fn seconds(record: &Record) -> f64 {
    f64::from(record.time_ms) / 1000.0
}

/// The lowest and the highest value of a stretch of rows, in their order, each with its time: a short peak must not
/// vanish. Nothing where no value is known.
pub fn extremes(rows: &[Record], value: impl Fn(&Record) -> f64) -> Vec<(f64, f64)> {
    let points = || rows.iter().map(|record| (seconds(record), value(record))).filter(|point| point.1.is_finite());
    let low = points().min_by(|a, b| a.1.total_cmp(&b.1));
    let high = points().max_by(|a, b| a.1.total_cmp(&b.1));
    let mut ends: Vec<_> = low.into_iter().chain(high).collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    ends.dedup();
    ends
}
