//! One run of a campaign once more, with everything that happened and the ordinary report.

use super::draw::Case;
use super::drive::drive;
use super::judge::{Ending, Outcome, describe};
use super::kind::fault_name;
use crate::trace::Trace;
use model_core::controller::Controller;

/// Drives it again and keeps every sample.
#[must_use]
pub fn replay(case: &Case, seed: u64) -> (Outcome, Trace) {
    let mut samples = Vec::new();
    let outcome = drive::<Controller>(case, |sample| samples.push(sample()));
    let faults: Vec<_> = case.faults.iter().map(describe).collect();
    let what = if faults.is_empty() { "nothing breaks".to_owned() } else { faults.join("; ") };
    let trace = Trace {
        name: format!("{}-run-{}", case.program.name(), case.index),
        description: format!("Campaign {seed}, run {}: {what}", case.index),
        seed: case.noise_seed,
        samples,
    };
    (outcome, trace)
}

/// What happened, for people.
#[must_use]
pub fn text(case: &Case, outcome: &Outcome) -> String {
    let p = &case.plant;
    let mut out = format!("run {}: {}\n", case.index, case.program.name());
    out += &format!(
        "  plant: pump {:.2} NL/min, chambers {:.2} mL, valves {:.4}, dump {:.4} NL/(s bar), dead times {}/{}/{} ms (pump, valves, dump), lag {:.0} ms\n",
        p.pump.free_flow_nl_per_min,
        p.finger.chamber_ml,
        p.segment_valve.conductance_nl_per_s_bar,
        p.dump_valve.conductance_nl_per_s_bar,
        p.pump.dead_time_ms,
        p.segment_valve.dead_time_ms,
        p.dump_valve.dead_time_ms,
        p.finger.lag_ms,
    );
    if case.faults.is_empty() {
        out += "  nothing breaks\n";
    }
    for (ms, what) in &outcome.timeline {
        out += &format!("  {:>9.3} s  {what}\n", f64::from(*ms) / 1000.0);
    }
    for fate in &outcome.fates {
        let ending = match fate.ending {
            Ending::NotShown => "never showed".to_owned(),
            Ending::Undecided => "showed, and the run ended before its bound".to_owned(),
            Ending::Missed => format!("MISSED its bound of {} ms", fate.drawn.kind.bound_ms()),
            Ending::Detected { latency_ms } => format!("detected {latency_ms} ms after it showed"),
        };
        let named = if fate.named { ", named" } else { "" };
        out += &format!("  {}: {ending}{named}\n", fate.drawn.kind.name());
    }
    if let Some(fault) = outcome.false_alarm {
        out += &format!("  FALSE ALARM {}\n", fault_name(fault));
    }
    for (property, how) in &outcome.violations {
        out += &format!("  VIOLATED {property:?}: {how}\n");
    }
    out
}
