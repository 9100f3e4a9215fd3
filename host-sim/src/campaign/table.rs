//! A campaign's result as text, Markdown and CSV.

use super::draw::Choice;
use super::kind::Kind;
use super::shard::Part;
use super::tally::{Cell, Tally, quantile};
use anyhow::{Result, anyhow};

fn hours(ms: u64) -> f64 {
    ms as f64 / 3.6e6
}

/// `12,345`.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

fn optional(ms: Option<u32>) -> String {
    ms.map_or_else(|| "-".to_owned(), |ms| grouped(u64::from(ms)))
}

fn percent(part: u64, of: u64) -> String {
    if of == 0 { "-".to_owned() } else { format!("{:.1} %", 100.0 * part as f64 / of as f64) }
}

/// One line of `campaign`'s detection table.
fn detection_row(kind: Kind, cell: &Cell) -> Vec<String> {
    vec![
        kind.name(),
        grouped(cell.runs),
        grouped(cell.not_shown),
        grouped(cell.undecided),
        grouped(cell.detected),
        grouped(cell.missed),
        percent(cell.named, cell.detected),
        optional(cell.latency_at(0.5)),
        optional(cell.latency_at(0.95)),
        optional(cell.latency_at(1.0)),
        grouped(u64::from(kind.bound_ms())),
    ]
}

const DETECTION_HEAD: [&str; 11] = [
    "fault",
    "runs",
    "not shown",
    "undecided",
    "detected",
    "missed",
    "named",
    "median ms",
    "95 % ms",
    "worst ms",
    "bound ms",
];

fn detection_rows(tally: &Tally) -> Vec<Vec<String>> {
    let rows = Kind::ALL.into_iter().map(|kind| (kind, tally.of_kind(&kind.name())));
    rows.filter(|(_, cell)| cell.runs > 0).map(|(kind, cell)| detection_row(kind, &cell)).collect()
}

fn alarm_rows(tally: &Tally) -> Vec<Vec<String>> {
    let named = |(fault, count): (&String, &u64)| (*count, fault.clone());
    Kind::ALL
        .into_iter()
        .filter_map(|kind| {
            let alarms = tally.first_alarms.get(&kind.name())?;
            let mut alarms: Vec<_> = alarms.iter().map(named).collect();
            alarms.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
            let words: Vec<_> =
                alarms.iter().take(6).map(|(count, fault)| format!("{fault} {}", grouped(*count))).collect();
            Some(vec![kind.name(), words.join(", ")])
        })
        .collect()
}

/// Lines of the form `what: how much`.
fn facts(part: &Part) -> Vec<(String, String)> {
    let tally = &part.result;
    let false_alarms: u64 = tally.false_alarms.values().sum();
    let free = hours(tally.fault_free_ms);
    let mut facts = vec![
        ("runs".to_owned(), grouped(tally.runs)),
        ("simulated".to_owned(), format!("{:.1} h", hours(tally.simulated_ms))),
        ("fault-free".to_owned(), format!("{free:.1} h")),
        (
            "false alarms".to_owned(),
            if free > 0.0 {
                format!("{false_alarms}, {:.4} an hour", false_alarms as f64 / free)
            } else {
                false_alarms.to_string()
            },
        ),
    ];
    for (fault, count) in &tally.false_alarms {
        facts.push((format!("false alarms, {fault}"), grouped(*count)));
    }
    for (property, violations) in &tally.violations {
        facts.push((format!("violated: {property}"), format!("{} runs", grouped(violations.runs))));
    }
    if let Some(worst) = quantile(&tally.vent_percent, 1.0) {
        let median = quantile(&tally.vent_percent, 0.5).unwrap_or(worst);
        facts.push((
            "vent time over the plant's own".to_owned(),
            format!("median {median} %, worst {worst} %, bound 150 %"),
        ));
    }
    for (why, count) in &tally.cannot_vent {
        facts.push((format!("a chamber cannot vent: {why}"), format!("{} runs", grouped(*count))));
    }
    for (why, count) in &tally.unavoidable_over_pressure {
        facts.push((
            format!("over-pressure after detection that nothing can avoid: {why}"),
            format!("{} runs", grouped(*count)),
        ));
    }
    facts
}

/// The command that makes one run again.
#[must_use]
pub fn replay_command(part: &Part, run: u64) -> String {
    let mut command = format!("host-sim campaign --seed {} --replay {run}", part.campaign.seed);
    if let Some(fault) = &part.campaign.fault {
        command += &format!(" --fault {fault}");
    }
    if let Some(sequence) = &part.campaign.sequence {
        command += &format!(" --sequence {sequence}");
    }
    command
}

/// For people at a terminal.
#[must_use]
pub fn text(part: &Part) -> String {
    let mut out = String::new();
    for (name, value) in facts(part) {
        out += &format!("{name}: {value}\n");
    }
    let mut rows = vec![DETECTION_HEAD.map(str::to_owned).to_vec()];
    rows.extend(detection_rows(&part.result));
    out.push('\n');
    for row in rows {
        for (index, cell) in row.iter().enumerate() {
            out += &if index == 0 { format!("{cell:<24}") } else { format!("{cell:>10}") };
        }
        out.push('\n');
    }
    out += "\nlatched first:\n";
    for row in alarm_rows(&part.result) {
        out += &format!("{:<24}  {}\n", row[0], row[1]);
    }
    let failing = part.result.failing();
    if !failing.is_empty() {
        out += "\nfailing runs:\n";
    }
    for (run, how) in &failing {
        out += &format!("{}   # {}\n", replay_command(part, *run), how.join("; "));
    }
    let violated = part.result.violated() + part.result.false_alarms.values().sum::<u64>();
    let told: u64 = failing.values().map(|how| how.len() as u64).sum();
    if violated > told {
        out += &format!("and {} more\n", grouped(violated - told));
    }
    out
}

fn markdown_table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut out = format!("| {} |\n|---{}|\n", head.join(" | "), "|--:".repeat(head.len() - 1));
    for row in rows {
        out += &format!("| {} |\n", row.join(" | "));
    }
    out
}

/// For docs/campaign.md.
#[must_use]
pub fn markdown(part: &Part) -> String {
    let mut out = format!("Seed {}, {} runs.\n\n", part.campaign.seed, grouped(part.campaign.runs));
    let rows: Vec<_> = facts(part).into_iter().map(|(name, value)| vec![name, value]).collect();
    out += &markdown_table(&["what", "how much"], &rows);
    out += "\nOne fault, over all programs (times from when it shows, rounded up to two digits):\n\n";
    out += &markdown_table(&DETECTION_HEAD, &detection_rows(&part.result));
    out += "\nTwo faults at once, each by its kind; either's detection counts:\n\n";
    let rows: Vec<_> = Kind::ALL
        .into_iter()
        .filter_map(|kind| Some(detection_row(kind, part.result.two_at_once.get(&kind.name())?)))
        .collect();
    out += &markdown_table(&DETECTION_HEAD, &rows);
    out += "\nWhat was latched first, of one fault:\n\n";
    out += &markdown_table(&["fault", "latched first, and in how many runs"], &alarm_rows(&part.result))
        .replace("--:", "---");
    out
}

/// The detection matrix, a cell a line.
///
/// # Errors
/// When the table cannot be written.
pub fn csv(part: &Part) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "fault",
        "sequence",
        "runs",
        "not_shown",
        "undecided",
        "detected",
        "named",
        "missed",
        "median_ms",
        "p95_ms",
        "worst_ms",
    ])?;
    for kind in Kind::ALL {
        for choice in Choice::all() {
            let row = part.result.matrix.get(&kind.name());
            let Some(cell) = row.and_then(|row| row.get(choice.name())) else { continue };
            let time = |share| cell.latency_at(share).map_or_else(String::new, |ms| ms.to_string());
            let counts = [cell.runs, cell.not_shown, cell.undecided, cell.detected, cell.named, cell.missed];
            let mut record = vec![kind.name(), choice.name().to_owned()];
            record.extend(counts.map(|count| count.to_string()));
            record.extend([0.5, 0.95, 1.0].map(time));
            writer.write_record(&record)?;
        }
    }
    let bytes = writer.into_inner().map_err(|error| anyhow!("cannot write the table: {error}"))?;
    Ok(String::from_utf8(bytes)?)
}
