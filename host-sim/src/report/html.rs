//! One self-contained page: figures of merit, plots to zoom into, and the finger moving. Without scripts it shows pictures.

use super::finger::{CHAMBER_MM, END_MM};
use super::record::Record;
use super::{Content, chart, interactive};
use crate::metrics::Summary;
use anyhow::Result;
use core::fmt::Write as _;

/// The pictures that the page shows, as SVG texts.
#[derive(Clone, Debug)]
pub struct Pictures {
    /// The finger at the end of each hold; nothing where its bends are not known.
    pub finger: Option<String>,
    /// Pressures with setpoints.
    pub pressures: String,
    /// Pump and valves.
    pub actuation: String,
    /// Bends.
    pub bends: String,
}

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
const UPLOT_SCRIPT: &str = include_str!("vendor/uplot/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("vendor/uplot/uPlot.min.css");
/// It asks to stand in every copy, and a report has one.
const UPLOT_LICENSE: &str = include_str!("vendor/uplot/LICENSE");
/// What the browser lets the page do: run what stands in it, and load nothing.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn number(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "—".to_owned() }
}

fn optional(value: Option<f64>) -> String {
    number(value.unwrap_or(f64::NAN), 2)
}

fn figures(summary: &Summary) -> String {
    let mut out = String::from(
        "<table class=\"figures\"><thead><tr><th>segment</th><th>mean error<br>while holding, kPa</th><th>worst error<br>while holding, \
         kPa</th><th>overshoot, kPa</th><th>settling, s</th><th>valve<br>switchings</th><th>highest<br>pressure, kPa\
         </th><th>left after<br>venting, kPa</th><th>largest<br>bend, °</th></tr></thead><tbody>",
    );
    for segment in &summary.segments {
        let _ = write!(
            out,
            "<tr><th class=\"{}\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>\
             <td>{}</td><td>{}</td><td>{}</td></tr>",
            segment.segment,
            segment.segment,
            optional(segment.hold_mean_abs_error_kpa),
            optional(segment.hold_worst_abs_error_kpa),
            number(segment.overshoot_kpa, 2),
            optional(segment.settling_time_s),
            segment.valve_switchings,
            number(segment.peak_chamber_kpa, 1),
            number(segment.vented_residual_kpa, 2),
            number(segment.peak_bend_deg, 1),
        );
    }
    let _ = write!(
        out,
        "</tbody></table><p>Pump: {} starts, {:.2} s on. Dump valve: {} switchings. Largest bend of the finger: \
         {}°. Holds not reached: {}; not settled within ±2 kPa at their end: {}. Faults: {}.</p>",
        summary.pump_starts,
        summary.pump_on_s,
        summary.dump_switchings,
        number(summary.peak_bend_deg, 1),
        summary.holds_not_reached,
        summary.holds_not_settled,
        if summary.faults.is_empty() { "none".to_owned() } else { escape(&summary.faults.join(", ")) },
    );
    out
}

fn notes(notes: &[String]) -> String {
    if notes.is_empty() {
        return String::new();
    }
    let items = notes.iter().map(|note| format!("<li>{}</li>", escape(note))).collect::<Vec<_>>().concat();
    format!("<ul class=\"notes\">{items}</ul>\n")
}

/// What happened in words, of a recording.
fn events(records: &[Record]) -> String {
    let rows = records
        .iter()
        .filter(|record| !record.event.is_empty())
        .map(|record| format!("<tr><td>{:.2} s</td><td>{}</td></tr>", chart::seconds(record), escape(&record.event)))
        .collect::<Vec<_>>()
        .concat();
    if rows.is_empty() {
        return rows;
    }
    format!(
        "<h2>What happened</h2><div class=\"scroll\"><table class=\"figures events\"><thead><tr><th>time</th><th>event</th></tr></thead>\
         <tbody>{rows}</tbody></table></div>\n"
    )
}

/// The finger in motion, moved by the page's script.
const MOTION: &str = "<h2>The finger in motion</h2><div class=\"live\"><svg id=\"live\" viewBox=\"-30 -40 230 190\" width=\"460\" \
    height=\"380\" role=\"img\" aria-label=\"the finger from the side\"></svg></div><div class=\"bar\"><button id=\"play\">Play</button>\
    <input id=\"time\" type=\"range\" min=\"0\" value=\"0\" aria-label=\"time\"><output id=\"now\"></output></div>\n";

/// The page.
///
/// # Errors
/// When the plant's parameters cannot be written as JSON.
pub fn page(content: &Content<'_>, pictures: &Pictures) -> Result<String> {
    let name = escape(content.name);
    let description = escape(&content.description);
    let data = interactive::data(content.records)?;
    let (figures, notes, events) = (figures(content.summary), notes(&content.notes), events(content.records));
    let Pictures { finger, pressures, actuation, bends } = pictures;
    let (holds, motion) = match finger {
        None => (String::new(), ""),
        Some(finger) => {
            (format!("<h2>The finger at the end of each hold</h2><div class=\"picture\">{finger}</div>\n"), MOTION)
        }
    };
    let plant = match content.parameters {
        None => String::new(),
        Some(parameters) => {
            let parameters = escape(&serde_json::to_string_pretty(parameters)?);
            format!("<h2>The plant</h2><details><summary>Parameters</summary><pre>{parameters}</pre></details>\n")
        }
    };
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"><meta name=\"viewport\" \
         content=\"width=device-width\"><link rel=\"icon\" href=\"data:,\"><title>{name} · soft rehabilitation finger</title>\
         <style>{UPLOT_STYLE}</style><style>{STYLE}</style></head>\
         <body>\n<h1>{name}</h1><p class=\"soft\">{description}</p>\n{notes}\
         <h2>How well it went</h2>{figures}\n{events}{holds}\
         <div id=\"scripted\" hidden>{motion}<h2>Over time</h2><div class=\"bar sticky\"><span>Drag across a plot to zoom in, double-click \
         to see all.</span><output id=\"shown\"></output><button id=\"whole\">Whole run</button></div>\n\
         <div class=\"chart\" id=\"pressure-0\"></div><div class=\"chart\" id=\"pressure-1\"></div><div class=\"chart\" \
         id=\"pressure-2\"></div><div class=\"chart\" id=\"timing\"></div><div class=\"chart\" id=\"bend\"></div></div>\n\
         <noscript><h2>Pressures</h2><div class=\"picture\">{pressures}</div>\n\
         <h2>Pump and valves</h2><div class=\"picture\">{actuation}</div>\n\
         <h2>Bend</h2><div class=\"picture\">{bends}</div></noscript>\n{plant}\
         <script>/*\nuPlot:\n{UPLOT_LICENSE}\n*/\n{UPLOT_SCRIPT}</script>\n\
         <script>const data={data},CHAMBER_MM={CHAMBER_MM},END_MM={END_MM};\
         document.getElementById('scripted').hidden=false;\n{SCRIPT}</script>\n</body></html>\n",
    ))
}
