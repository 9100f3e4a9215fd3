//! The data of the page's plots: what its script gets, as JSON.
//!
//! Curves share their times in a plot. Up to [`ROWS`] rows all are there; of longer runs a stretch of rows becomes two points, the
//! lowest and the highest value in their order, so that no peak vanishes. Switchings are there to the millisecond.

use super::chart::{Chart, SWITCHES, bend_deg, bends, extremes, pressures, seconds};
use super::record::{Record, link_mode_name};
use anyhow::Result;
use model_core::protocol::LinkMode;
use serde::Serialize;

/// The most points of a curve.
const ROWS: usize = 20_000;
/// Frames of the moving finger are this far apart at least, ms, and so many at most.
const FRAME_MS: u32 = 40;
const FRAMES: u32 = 4_000;

/// One plot.
#[derive(Debug, Serialize)]
struct Plot {
    title: String,
    unit: &'static str,
    range: [f64; 2],
    names: Vec<&'static str>,
    colours: Vec<&'static str>,
    widths: Vec<u32>,
    /// s.
    times: Vec<f64>,
    /// A list for each name.
    values: Vec<Vec<Option<f64>>>,
}

/// The timing diagram: the state after each switching.
#[derive(Debug, Serialize)]
struct Timing {
    names: Vec<&'static str>,
    colours: Vec<&'static str>,
    /// s.
    times: Vec<f64>,
    /// A list for each name, 1 where its bar is.
    states: Vec<Vec<u8>>,
}

/// The moving finger.
#[derive(Debug, Serialize)]
struct Motion {
    start_ms: u32,
    step_ms: u32,
    /// Bends of the segments, degrees, and pressures of the chambers, kPa.
    frames: Vec<[Option<f64>; 6]>,
}

/// A stretch of the run in which something was the case.
#[derive(Debug, Serialize)]
struct Stretch {
    from_s: f64,
    to_s: f64,
    name: String,
}

#[derive(Debug, Serialize)]
struct Data {
    pressures: [Plot; 3],
    bends: Plot,
    timing: Timing,
    /// Nothing where no bend is known.
    motion: Option<Motion>,
    faults: Vec<Stretch>,
}

/// Four digits after the point are more than any sensor has.
fn rounded(value: f64, digits: i32) -> Option<f64> {
    let scale = 10_f64.powi(digits);
    value.is_finite().then(|| (value * scale).round() / scale)
}

fn plot(chart: Chart, records: &[Record]) -> Plot {
    let whole = records.len() <= ROWS;
    let stretch = if whole { 1 } else { records.len().div_ceil(ROWS / 2) };
    let stretches = || records.chunks(stretch);
    // The two points of a stretch stand at its start and its middle.
    let times = stretches()
        .flat_map(|rows| [&rows[0], &rows[rows.len() / 2]].into_iter().take(if whole { 1 } else { 2 }))
        .filter_map(|record| rounded(seconds(record), 4));
    let values = |value: &dyn Fn(&Record) -> f64| -> Vec<Option<f64>> {
        if whole {
            return records.iter().map(|record| rounded(value(record), 2)).collect();
        }
        let pair = |rows: &[Record]| {
            let ends = extremes(rows, value);
            [ends.first(), ends.last()].map(|end| end.and_then(|end| rounded(end.1, 2)))
        };
        stretches().flat_map(pair).collect()
    };
    let mut times: Vec<f64> = times.collect();
    // A last stretch of one row has one moment for its two points.
    for index in 1..times.len() {
        if times[index] <= times[index - 1] {
            times[index] = times[index - 1] + 1e-4;
        }
    }
    Plot {
        names: chart.curves.iter().map(|curve| curve.name).collect(),
        colours: chart.curves.iter().map(|curve| curve.colour.name()).collect(),
        widths: chart.curves.iter().map(|curve| curve.width).collect(),
        values: chart.curves.iter().map(|curve| values(&curve.value)).collect(),
        title: chart.title,
        unit: chart.unit,
        range: [chart.range.0, chart.range.1],
        times,
    }
}

fn timing(records: &[Record]) -> Timing {
    let states = |record: &Record| SWITCHES.map(|switch| u8::from((switch.on)(record)));
    let mut changes: Vec<&Record> =
        records.chunk_by(|a, b| states(a) == states(b)).filter_map(|chunk| chunk.first()).collect();
    changes.extend(records.last());
    changes.dedup_by_key(|record| record.time_ms);
    Timing {
        names: SWITCHES.iter().map(|switch| switch.name).collect(),
        colours: SWITCHES.iter().map(|switch| switch.colour.name()).collect(),
        times: changes.iter().map(|record| seconds(record)).collect(),
        states: (0..SWITCHES.len()).map(|index| changes.iter().map(|record| states(record)[index]).collect()).collect(),
    }
}

fn motion(records: &[Record]) -> Option<Motion> {
    let [first, .., last] = records else { return None };
    let known = |record: &Record| [0, 1, 2].iter().all(|&index| bend_deg(record, index).is_finite());
    if !records.iter().any(known) {
        return None;
    }
    let span = last.time_ms - first.time_ms;
    let step_ms = FRAME_MS.max(span.div_ceil(FRAMES));
    let frame = |time_ms: u32| {
        let after = records.partition_point(|record| record.time_ms <= time_ms);
        let record = &records[after.saturating_sub(1)];
        let kpa = |index: usize| {
            let told = record.chambers_kpa[index];
            rounded(if told.is_finite() { told } else { record.estimates_kpa[index] }, 0)
        };
        let deg = |index: usize| rounded(bend_deg(record, index), 1);
        [deg(0), deg(1), deg(2), kpa(0), kpa(1), kpa(2)]
    };
    let frames = (0..=span / step_ms).map(|index| frame(first.time_ms + index * step_ms)).collect();
    Some(Motion { start_ms: first.time_ms, step_ms, frames })
}

fn faults(records: &[Record]) -> Vec<Stretch> {
    let chunks = records.chunk_by(|a, b| a.mode == b.mode);
    let faulted = chunks.filter(|chunk| matches!(chunk[0].mode, LinkMode::Faulted(_)));
    faulted
        .map(|chunk| Stretch {
            from_s: seconds(&chunk[0]),
            to_s: seconds(&chunk[chunk.len() - 1]),
            name: link_mode_name(chunk[0].mode),
        })
        .collect()
}

/// The data as JSON that may stand in a page's script.
///
/// # Errors
/// Never in practice: all of it can be written as JSON.
pub fn data(records: &[Record]) -> Result<String> {
    let data = Data {
        pressures: pressures(records).map(|chart| plot(chart, records)),
        bends: plot(bends(records), records),
        timing: timing(records),
        motion: motion(records),
        faults: faults(records),
    };
    // No text of a recording may end the script.
    Ok(serde_json::to_string(&data)?.replace('<', "\\u003c"))
}
