//! One self-contained page: figures of merit, pictures, and the finger moving.

use super::finger::{CHAMBER_MM, COLOURS, END_MM};
use crate::metrics::Summary;
use crate::plant::PlantParameters;
use crate::trace::Trace;
use anyhow::Result;
use core::fmt::Write as _;

/// The pictures that the page shows, as SVG texts.
#[derive(Clone, Debug)]
pub struct Pictures {
    /// The finger at the end of each hold.
    pub finger: String,
    /// Pressures with setpoints.
    pub pressures: String,
    /// Pump and valves.
    pub actuation: String,
    /// Bends.
    pub bends: String,
}

/// Samples of the moving finger are this far apart, ms.
const FRAME_MS: usize = 40;

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn optional(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "—".to_owned(), |value| format!("{value:.digits$}"))
}

fn table(summary: &Summary) -> String {
    let mut out = String::from(
        "<table><thead><tr><th>segment</th><th>mean error<br>while holding, kPa</th><th>worst error<br>while holding, \
         kPa</th><th>overshoot, kPa</th><th>settling, s</th><th>valve<br>switchings</th><th>highest<br>pressure, kPa\
         </th><th>left after<br>venting, kPa</th><th>largest<br>bend, °</th></tr></thead><tbody>",
    );
    for (segment, colour) in summary.segments.iter().zip(COLOURS) {
        let _ = write!(
            out,
            "<tr><th style=\"color:{colour}\">{}</th><td>{}</td><td>{}</td><td>{:.2}</td><td>{}</td><td>{}</td>\
             <td>{:.1}</td><td>{:.2}</td><td>{:.1}</td></tr>",
            segment.segment,
            optional(segment.hold_mean_abs_error_kpa, 2),
            optional(segment.hold_worst_abs_error_kpa, 2),
            segment.overshoot_kpa,
            optional(segment.settling_time_s, 2),
            segment.valve_switchings,
            segment.peak_chamber_kpa,
            segment.vented_residual_kpa,
            segment.peak_bend_deg,
        );
    }
    let _ = write!(
        out,
        "</tbody></table><p>Pump: {} starts, {:.2} s on. Dump valve: {} switchings. Largest bend of the finger: \
         {:.1}°. Holds not reached: {}; not settled within ±2 kPa at their end: {}. Faults: {}.</p>",
        summary.pump_starts,
        summary.pump_on_s,
        summary.dump_switchings,
        summary.peak_bend_deg,
        summary.holds_not_reached,
        summary.holds_not_settled,
        if summary.faults.is_empty() { "none".to_owned() } else { escape(&summary.faults.join(", ")) },
    );
    out
}

/// Bends and pressures of the moving finger as a JavaScript array.
fn frames(trace: &Trace) -> String {
    let mut out = String::from("[");
    for sample in trace.samples.iter().step_by(FRAME_MS) {
        let [a, b, c] = sample.bends_deg;
        let [p, m, d] = sample.chambers_kpa;
        let _ = write!(out, "[{a:.1},{b:.1},{c:.1},{p:.0},{m:.0},{d:.0}],");
    }
    out.push(']');
    out
}

const STYLE: &str = "
:root{color-scheme:light dark;--ink:#22262c;--soft:#6a7079;--line:#dfe3e8;--back:#fff;--card:#f6f7f9}
@media(prefers-color-scheme:dark){:root{--ink:#e6e8eb;--soft:#9aa1ab;--line:#343a42;--back:#16191d;--card:#1f2328}}
body{font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--back);max-width:1000px;margin:2rem auto;padding:0 1rem}
h1{margin-bottom:0}h2{margin-top:2rem;font-size:1.1rem}.soft{color:var(--soft);margin-top:.2rem}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
th,td{padding:.35rem .6rem;text-align:right;border-bottom:1px solid var(--line)}thead th{font-weight:500;color:var(--soft);font-size:.8rem}
tbody th{text-align:left}.picture{overflow-x:auto;background:#fff;border:1px solid var(--line);border-radius:8px;padding:4px}
.picture svg{max-width:100%;height:auto;display:block;margin:auto}
.move{display:flex;gap:1rem;align-items:center;background:var(--card);border-radius:8px;padding:.6rem 1rem}
.move input{flex:1}.move button{padding:.3rem 1rem}pre{background:var(--card);padding:1rem;border-radius:8px;overflow-x:auto}
";

const SCRIPT: &str = "
const svg=document.getElementById('live'),slider=document.getElementById('time'),label=document.getElementById('now'),button=document.getElementById('play');
slider.max=frames.length-1;let timer=null;
function arc(p,l,b){const h=b/2,c=Math.abs(h)<1e-9?l:l*Math.sin(h)/h;return{x:p.x+c*Math.cos(p.t+h),y:p.y+c*Math.sin(p.t+h),t:p.t+b}}
function path(p,l,b,colour,width){let s='';for(let i=0;i<=16;i++){const q=arc(p,l*i/16,b*i/16);s+=q.x.toFixed(2)+','+q.y.toFixed(2)+' '}
return `<polyline points='${s}' fill='none' stroke='${colour}' stroke-width='${width}' stroke-linejoin='round'/>`}
function show(i){const f=frames[i];let p={x:0,y:0,t:0},s=path(p,END,0,'#8a9099',22.5);p=arc(p,END,0);
for(let k=0;k<3;k++){const b=f[k]*Math.PI/180;s+=path(p,CHAMBER,b,colours[k],22.5)+path(p,CHAMBER,b,'#fff',1.2);p=arc(p,CHAMBER,b)}
s+=path(p,END,0,'#8a9099',22.5);svg.innerHTML=s;
label.textContent=(i*STEP/1000).toFixed(1)+' s   '+f.slice(0,3).map(v=>v.toFixed(0)+'°').join(' · ')+'   '+f.slice(3).map(v=>v+' kPa').join(' · ')}
slider.oninput=()=>show(+slider.value);
button.onclick=()=>{if(timer){clearInterval(timer);timer=null;button.textContent='Play';return}
button.textContent='Pause';timer=setInterval(()=>{slider.value=(+slider.value+1)%frames.length;show(+slider.value)},STEP)};
show(0);
";

/// The page.
///
/// # Errors
/// When the plant's parameters cannot be written as JSON.
pub fn page(trace: &Trace, summary: &Summary, parameters: &PlantParameters, pictures: &Pictures) -> Result<String> {
    let name = escape(&trace.name);
    let description = escape(&trace.description);
    let parameters = escape(&serde_json::to_string_pretty(parameters)?);
    let (table, frames, seed) = (table(summary), frames(trace), trace.seed);
    let Pictures { finger, pressures, actuation, bends } = pictures;
    let duration = summary.duration_s;
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>{name} · soft rehabilitation finger</title><style>{STYLE}</style></head>\
         <body>\n<h1>{name}</h1><p class=\"soft\">{description}. Simulated finger, seed {seed}, {duration:.1} s.</p>\n\
         <h2>How well it went</h2>{table}\n\
         <h2>The finger at the end of each hold</h2><div class=\"picture\">{finger}</div>\n\
         <h2>The finger in motion</h2><div class=\"picture\"><svg id=\"live\" viewBox=\"-30 -40 230 190\" \
         width=\"460\" height=\"380\"></svg></div><div class=\"move\"><button id=\"play\">Play</button>\
         <input id=\"time\" type=\"range\" min=\"0\" value=\"0\" aria-label=\"time\"><span id=\"now\"></span></div>\n\
         <h2>Pressures</h2><div class=\"picture\">{pressures}</div>\n\
         <h2>Pump and valves</h2><div class=\"picture\">{actuation}</div>\n\
         <h2>Bend</h2><div class=\"picture\">{bends}</div>\n\
         <h2>The plant</h2><details><summary>Parameters</summary><pre>{parameters}</pre></details>\n\
         <script>const frames={frames},colours=['{}','{}','{}'],CHAMBER={CHAMBER_MM},END={END_MM},STEP={FRAME_MS};\
         {SCRIPT}</script>\n</body></html>\n",
        COLOURS[0], COLOURS[1], COLOURS[2],
    ))
}
