//! What is left of many runs: whole numbers, so that it is the same in whatever order they come.

use super::draw::Case;
use super::judge::{Ending, Outcome, Property};
use super::kind::{fault_name, kebab};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Violations of a property that are kept one by one; those with the lowest numbers.
const KEPT: usize = 100;

/// What became of one kind of fault in one program.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cell {
    /// Runs with it.
    pub runs: u64,
    /// Runs in which it never showed in a true quantity.
    pub not_shown: u64,
    /// Runs that ended before its bound.
    pub undecided: u64,
    /// Runs in which it was detected in time.
    pub detected: u64,
    /// Of those, runs in which a latched fault called it by its name.
    pub named: u64,
    /// Runs in which it was not.
    pub missed: u64,
    /// Times to detection in ms, rounded up to two digits that count, and how often.
    pub latency_ms: BTreeMap<u32, u64>,
}

/// Rounded up to two digits that count.
fn two_digits(ms: u32) -> u32 {
    let mut unit = 1;
    while ms.div_ceil(unit) > 99 {
        unit *= 10;
    }
    ms.div_ceil(unit) * unit
}

impl Cell {
    /// Adds another's counts.
    pub fn add(&mut self, other: &Self) {
        self.runs += other.runs;
        self.not_shown += other.not_shown;
        self.undecided += other.undecided;
        self.detected += other.detected;
        self.named += other.named;
        self.missed += other.missed;
        add_counts(&mut self.latency_ms, &other.latency_ms);
    }

    /// Time within which this share (0..=1) of the detected was, ms.
    #[must_use]
    pub fn latency_at(&self, share: f64) -> Option<u32> {
        quantile(&self.latency_ms, share)
    }
}

/// The value that this share (0..=1) of the counted does not exceed.
#[must_use]
pub fn quantile(counts: &BTreeMap<u32, u64>, share: f64) -> Option<u32> {
    let total: u64 = counts.values().sum();
    let wanted = ((total as f64 * share).ceil() as u64).max(1);
    let mut so_far = 0;
    counts.iter().find_map(|(&value, &count)| {
        so_far += count;
        (so_far >= wanted).then_some(value)
    })
}

fn add_counts<K: Ord + Clone>(counts: &mut BTreeMap<K, u64>, other: &BTreeMap<K, u64>) {
    for (key, count) in other {
        *counts.entry(key.clone()).or_default() += count;
    }
}

/// Runs that broke a property.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Violations {
    /// How many.
    pub runs: u64,
    /// By the run's number, how: the first hundred.
    pub first: BTreeMap<u64, String>,
}

/// See the module's page.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Runs.
    pub runs: u64,
    /// Simulated time of them all, ms.
    pub simulated_ms: u64,
    /// Time without any fault and before any alarm, ms.
    pub fault_free_ms: u64,
    /// Alarms while nothing was broken, by the fault that was latched.
    pub false_alarms: BTreeMap<String, u64>,
    /// The first false alarms by the run's number.
    pub first_false_alarms: BTreeMap<u64, String>,
    /// Runs with one fault: by its kind, and by program.
    pub matrix: BTreeMap<String, BTreeMap<String, Cell>>,
    /// Runs with two faults at once, each by its kind.
    pub two_at_once: BTreeMap<String, Cell>,
    /// Runs with one fault: by its kind, what was latched first.
    pub first_alarms: BTreeMap<String, BTreeMap<String, u64>>,
    /// Runs in which a chamber physically could not vent, by what kept it.
    pub cannot_vent: BTreeMap<String, u64>,
    /// Runs in which a chamber was above the limit after detection whatever the controller did, by what kept it there.
    pub unavoidable_over_pressure: BTreeMap<String, u64>,
    /// Vent time of the slowest chamber over the plant's own, per cent, and how often.
    pub vent_percent: BTreeMap<u32, u64>,
    /// By property.
    pub violations: BTreeMap<String, Violations>,
}

/// A property's name in tables.
#[must_use]
pub fn property_name(property: Property) -> String {
    kebab(&format!("{property:?}"))
}

fn keep_first(first: &mut BTreeMap<u64, String>) {
    while first.len() > KEPT {
        first.pop_last();
    }
}

impl Tally {
    /// No runs yet; every row that can be filled is there.
    #[must_use]
    pub fn new() -> Self {
        let violations = Property::ALL.into_iter().map(|property| (property_name(property), Violations::default()));
        Self { violations: violations.collect(), ..Self::default() }
    }

    /// Adds a run.
    pub fn count(&mut self, case: &Case, outcome: &Outcome) {
        self.runs += 1;
        self.simulated_ms += u64::from(outcome.simulated_ms);
        self.fault_free_ms += u64::from(outcome.fault_free_ms);
        if let Some(fault) = outcome.false_alarm {
            *self.false_alarms.entry(fault_name(fault)).or_default() += 1;
            self.first_false_alarms.insert(case.index, fault_name(fault));
            keep_first(&mut self.first_false_alarms);
        }
        let alone = outcome.fates.len() == 1;
        for fate in &outcome.fates {
            let kind = fate.drawn.kind.name();
            let cell = if alone {
                self.matrix.entry(kind).or_default().entry(case.program.name().to_owned()).or_default()
            } else {
                self.two_at_once.entry(kind).or_default()
            };
            cell.runs += 1;
            match fate.ending {
                Ending::NotShown => cell.not_shown += 1,
                Ending::Undecided => cell.undecided += 1,
                Ending::Missed => cell.missed += 1,
                Ending::Detected { latency_ms } => {
                    cell.detected += 1;
                    cell.named += u64::from(fate.named);
                    *cell.latency_ms.entry(two_digits(latency_ms)).or_default() += 1;
                }
            }
        }
        if let (true, [fate]) = (outcome.false_alarm.is_none(), outcome.fates.as_slice()) {
            let first = outcome.first_alarm.map_or_else(|| "none".to_owned(), fault_name);
            *self.first_alarms.entry(fate.drawn.kind.name()).or_default().entry(first).or_default() += 1;
        }
        for (counts, why) in
            [(&mut self.cannot_vent, &outcome.cannot_vent), (&mut self.unavoidable_over_pressure, &outcome.unavoidable)]
        {
            if let Some(why) = why {
                *counts.entry(why.clone()).or_default() += 1;
            }
        }
        if let Some(percent) = outcome.vent_percent {
            *self.vent_percent.entry(percent).or_default() += 1;
        }
        for (property, how) in &outcome.violations {
            let violations = self.violations.entry(property_name(*property)).or_default();
            violations.runs += 1;
            violations.first.insert(case.index, how.clone());
            keep_first(&mut violations.first);
        }
    }

    /// Adds another's runs.
    pub fn add(&mut self, other: &Self) {
        self.runs += other.runs;
        self.simulated_ms += other.simulated_ms;
        self.fault_free_ms += other.fault_free_ms;
        add_counts(&mut self.false_alarms, &other.false_alarms);
        self.first_false_alarms.extend(other.first_false_alarms.clone());
        keep_first(&mut self.first_false_alarms);
        for (kind, row) in &other.matrix {
            for (program, cell) in row {
                self.matrix.entry(kind.clone()).or_default().entry(program.clone()).or_default().add(cell);
            }
        }
        for (kind, cell) in &other.two_at_once {
            self.two_at_once.entry(kind.clone()).or_default().add(cell);
        }
        for (kind, alarms) in &other.first_alarms {
            add_counts(self.first_alarms.entry(kind.clone()).or_default(), alarms);
        }
        add_counts(&mut self.cannot_vent, &other.cannot_vent);
        add_counts(&mut self.unavoidable_over_pressure, &other.unavoidable_over_pressure);
        add_counts(&mut self.vent_percent, &other.vent_percent);
        for (property, violations) in &other.violations {
            let mine = self.violations.entry(property.clone()).or_default();
            mine.runs += violations.runs;
            mine.first.extend(violations.first.clone());
            keep_first(&mut mine.first);
        }
    }

    /// Runs' numbers that broke something, as far as they were kept, and what.
    #[must_use]
    pub fn failing(&self) -> BTreeMap<u64, Vec<String>> {
        let mut runs: BTreeMap<u64, Vec<String>> = BTreeMap::new();
        for (property, violations) in &self.violations {
            for (&run, how) in &violations.first {
                runs.entry(run).or_default().push(format!("{property}: {how}"));
            }
        }
        for (&run, fault) in &self.first_false_alarms {
            runs.entry(run).or_default().push(format!("false alarm: {fault}"));
        }
        runs
    }

    /// How often anything was violated.
    #[must_use]
    pub fn violated(&self) -> u64 {
        self.violations.values().map(|violations| violations.runs).sum()
    }

    /// One kind's runs over all programs.
    #[must_use]
    pub fn of_kind(&self, kind: &str) -> Cell {
        let mut sum = Cell::default();
        for cell in self.matrix.get(kind).into_iter().flat_map(BTreeMap::values) {
            sum.add(cell);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_count_and_rounding_goes_up() {
        for (ms, expected) in
            [(0, 0), (7, 7), (99, 99), (100, 100), (101, 110), (990, 990), (991, 1000), (12_345, 13_000)]
        {
            assert_eq!(two_digits(ms), expected);
        }
    }

    #[test]
    fn quantiles_are_values_that_were_counted() {
        let counts = BTreeMap::from([(1, 5), (10, 4), (100, 1)]);
        assert_eq!(
            [0.0, 0.5, 0.51, 0.9, 0.95, 1.0].map(|share| quantile(&counts, share)),
            [1, 1, 10, 10, 100, 100].map(Some)
        );
        assert_eq!(quantile(&BTreeMap::new(), 0.5), None);
    }
}
