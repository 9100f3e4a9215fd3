//! What a trial is worth.

use super::bound::{Kind, Physics};
use super::trial::{JUMP_KPA, Moment, Trial};
use crate::metrics::BAND_KPA;
use model_core::actuation::Actuation;
use serde::Serialize;

/// A reference that rests for so long is held, ms.
const HOLD_MS: usize = 1000;

/// One step of the references.
#[derive(Clone, Debug, Serialize)]
pub struct StepScore {
    /// Seed of the trial.
    pub seed: u64,
    /// When, ms.
    pub at_ms: usize,
    /// References before, kPa.
    pub from_kpa: [f64; 3],
    /// References after, kPa.
    pub to_kpa: [f64; 3],
    /// Which way they go.
    pub kind: Kind,
    /// Time until all chambers that moved stay within 2 kPa of their references; none when they never do.
    pub settling_ms: Option<f64>,
    /// The least time for anybody, from the same true state.
    pub bound_ms: f64,
    /// The least that the errors of its chambers, summed, can sum up to over that time, kPa ms.
    pub bound_error_kpa_ms: f64,
}

impl StepScore {
    /// Settling time over the bound, where both are there.
    #[must_use]
    pub fn ratio(&self) -> Option<f64> {
        self.settling_ms.filter(|_| self.bound_ms > 0.0).map(|settling| settling / self.bound_ms)
    }
}

/// The figures of one regulator in one scenario, over all seeds.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Scores {
    /// Mean absolute error of the true pressures against the references, all chambers, all the scored time, kPa.
    pub mean_absolute_error_kpa: f64,
    /// What physics allows at the least: the steps' bounds, and no error anywhere else, kPa.
    pub least_error_kpa: f64,
    /// The same where a reference above 0 rests for a second or more, from the first moment within 2 kPa on; none when no
    /// reference rests.
    pub hold_error_kpa: Option<f64>,
    /// Such holds that never came within 2 kPa.
    pub holds_not_reached: u32,
    /// Furthest past a reference that had jumped, in the direction of the jump, kPa; none when none jumps.
    pub overshoot_kpa: Option<f64>,
    /// Steps whose references all go the same way.
    pub steps: u32,
    /// Those that did not settle before the next step.
    pub steps_not_settled: u32,
    /// Mean settling time of those that did, ms.
    pub settling_ms: Option<f64>,
    /// Mean bound of the same, ms.
    pub bound_ms: Option<f64>,
    /// Mean of settling time over bound of the same.
    pub settling_over_bound: Option<f64>,
    /// Largest of the same.
    pub worst_settling_over_bound: Option<f64>,
    /// Steps with references both up and down.
    pub mixed_steps: u32,
    /// Those that did not settle.
    pub mixed_steps_not_settled: u32,
    /// Mean settling time of those that did, ms.
    pub mixed_settling_ms: Option<f64>,
    /// Mean of their loose bounds, ms.
    pub mixed_bound_ms: Option<f64>,
    /// Switchings of the three segment valves and the dump valve a minute.
    pub valve_switchings_per_min: f64,
    /// Switchings of the pump's relay a minute.
    pub relay_switchings_per_min: f64,
    /// Share of the time with the pump on.
    pub pump_duty: f64,
    /// Furthest that a chamber whose reference rests went away from it while others moved, kPa; none when none rests so.
    pub disturbance_kpa: Option<f64>,
    /// Highest true chamber pressure, kPa.
    pub peak_chamber_kpa: f64,
    /// Highest true manifold pressure, kPa.
    pub peak_manifold_kpa: f64,
    /// Mean absolute error of what the regulator took the chambers' pressures to be, kPa.
    pub estimate_error_kpa: f64,
}

impl Scores {
    /// Valves and relay together.
    #[must_use]
    pub fn switchings_per_min(&self) -> f64 {
        self.valve_switchings_per_min + self.relay_switchings_per_min
    }
}

/// A mean in the making.
#[derive(Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn get(self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

/// The larger, where there is one already.
fn raise(largest: &mut Option<f64>, value: f64) {
    *largest = Some(largest.map_or(value, |old| old.max(value)));
}

fn error_kpa(moment: &Moment, chamber: usize) -> f64 {
    moment.chambers_kpa[chamber] - moment.references_kpa[chamber]
}

/// Stretches of a trial in which the references of a chamber do not change, as ranges of moments.
fn rests(moments: &[Moment], chamber: usize) -> Vec<core::ops::Range<usize>> {
    let mut ranges = Vec::new();
    let mut start = 0;
    for end in 1..=moments.len() {
        let same = moments.get(end).is_some_and(|moment| {
            (moment.references_kpa[chamber] - moments[start].references_kpa[chamber]).abs() <= 0.0
        });
        if !same {
            ranges.push(start..end);
            start = end;
        }
    }
    ranges
}

/// The figures of these trials, each with its seed; tracking counts from `scored_from_ms` on.
#[must_use]
pub fn score(trials: &[(u64, Trial)], physics: &Physics, scored_from_ms: usize) -> (Scores, Vec<StepScore>) {
    let mut scores = Scores::default();
    let (mut tracking, mut hold, mut estimate) = (Mean::default(), Mean::default(), Mean::default());
    let (mut valves, mut relay, mut pumping, mut total_ms) = (0, 0, 0, 0);
    let mut steps = Vec::new();
    for (seed, trial) in trials {
        let moments = &trial.moments;
        total_ms += moments.len();
        for moment in moments {
            pumping += u32::from(moment.actuation.pump);
            for i in 0..3 {
                estimate.add((moment.estimates_kpa[i] - moment.chambers_kpa[i]).abs());
                scores.peak_chamber_kpa = scores.peak_chamber_kpa.max(moment.chambers_kpa[i]);
            }
            scores.peak_manifold_kpa = scores.peak_manifold_kpa.max(moment.manifold_kpa);
        }
        for moment in moments.iter().skip(scored_from_ms) {
            (0..3).for_each(|i| tracking.add(error_kpa(moment, i).abs()));
        }
        valves += switchings(moments, |actuation| {
            [actuation.segments[0], actuation.segments[1], actuation.segments[2], actuation.dump]
        });
        relay += switchings(moments, |actuation| [actuation.pump]);
        for chamber in 0..3 {
            score_holds(moments, chamber, &mut hold, &mut scores);
        }
        score_disturbance(trial, scored_from_ms, &mut scores);
        steps.extend(steps_of(*seed, trial, physics));
    }
    let minutes = total_ms as f64 / 60_000.0;
    if minutes > 0.0 {
        scores.valve_switchings_per_min = f64::from(valves) / minutes;
        scores.relay_switchings_per_min = f64::from(relay) / minutes;
        scores.pump_duty = f64::from(pumping) / total_ms as f64;
    }
    let scored = steps.iter().filter(|step| step.at_ms >= scored_from_ms);
    scores.least_error_kpa = scored.map(|step| step.bound_error_kpa_ms).sum::<f64>() / f64::from(tracking.count.max(1));
    scores.mean_absolute_error_kpa = tracking.get().unwrap_or(0.0);
    scores.hold_error_kpa = hold.get();
    scores.estimate_error_kpa = estimate.get().unwrap_or(0.0);
    score_steps(&steps, &mut scores);
    (scores, steps)
}

/// How often any of these outputs changes, from the safe state on.
fn switchings<T: PartialEq, const N: usize>(moments: &[Moment], outputs: impl Fn(&Actuation) -> [T; N]) -> u32 {
    let mut last = outputs(&Actuation::SAFE);
    let mut count = 0;
    for moment in moments {
        let now = outputs(&moment.actuation);
        count += last.iter().zip(&now).filter(|(last, now)| last != now).count() as u32;
        last = now;
    }
    count
}

/// Hold error and overshoot of one chamber.
fn score_holds(moments: &[Moment], chamber: usize, hold: &mut Mean, scores: &mut Scores) {
    for range in rests(moments, chamber) {
        let reference = moments[range.start].references_kpa[chamber];
        let before = range.start.checked_sub(1).map_or(0.0, |at| moments[at].references_kpa[chamber]);
        let rest = &moments[range];
        let change = reference - before;
        if change.abs() > JUMP_KPA {
            let past = rest.iter().map(|moment| change.signum() * error_kpa(moment, chamber)).fold(0.0, f64::max);
            raise(&mut scores.overshoot_kpa, past);
        }
        if rest.len() < HOLD_MS || reference <= 0.0 {
            continue;
        }
        match rest.iter().position(|moment| error_kpa(moment, chamber).abs() <= BAND_KPA) {
            Some(reached) => rest[reached..].iter().for_each(|moment| hold.add(error_kpa(moment, chamber).abs())),
            None => scores.holds_not_reached += 1,
        }
    }
}

/// By how much the error of a chamber whose reference rests grew after another's had jumped or begun to move.
fn score_disturbance(trial: &Trial, scored_from_ms: usize, scores: &mut Scores) {
    let moments = &trial.moments;
    let mut starts: Vec<usize> = trial.steps.iter().map(|step| step.at).collect();
    if scored_from_ms > 0 {
        starts.push(scored_from_ms);
    }
    for (place, &start) in starts.iter().enumerate() {
        let end = starts.get(place + 1).map_or(moments.len(), |&next| next.min(moments.len()));
        for chamber in 0..3 {
            let reference = |at: usize| moments.get(at).map_or(0.0, |moment| moment.references_kpa[chamber]);
            let before = start.checked_sub(1).map_or(0.0, reference);
            let rests = (start..end).all(|at| (reference(at) - before).abs() <= 0.0);
            let others = (0..3).any(|other| {
                (start..end).any(|at| {
                    let was = at.checked_sub(1).map_or(0.0, |at| moments[at].references_kpa[other]);
                    (moments[at].references_kpa[other] - was).abs() > 0.0
                })
            });
            if rests && others && start < end {
                let first = error_kpa(&moments[start], chamber).abs();
                let grown = moments[start..end].iter().map(|moment| error_kpa(moment, chamber).abs() - first);
                raise(&mut scores.disturbance_kpa, grown.fold(0.0, f64::max));
            }
        }
    }
}

/// The steps of a trial with their bounds.
fn steps_of(seed: u64, trial: &Trial, physics: &Physics) -> Vec<StepScore> {
    let moments = &trial.moments;
    let step = |(place, start): (usize, &super::trial::StepStart)| {
        let to_kpa = moments[start.at].references_kpa;
        let from_kpa = start.at.checked_sub(1).map_or([0.0; 3], |before| moments[before].references_kpa);
        let next = trial.steps.get(place + 1).map_or(moments.len(), |next| next.at);
        // References that begin to move end it too.
        let changed = |now: &[f64; 3]| now.iter().zip(to_kpa).any(|(now, was)| (now - was).abs() > 0.0);
        let end = (start.at..next).find(|&at| changed(&moments[at].references_kpa)).unwrap_or(next);
        let moved = |chamber: usize| (to_kpa[chamber] - from_kpa[chamber]).abs() > 0.0;
        let outside = |moment: &Moment| (0..3).any(|i| moved(i) && error_kpa(moment, i).abs() > BAND_KPA);
        let settled = moments[start.at..end].iter().rposition(outside).map_or(0, |last| last + 1);
        let bound = physics.bound(start, from_kpa, to_kpa);
        let settling_ms = (start.at + settled < end).then_some(settled as f64);
        StepScore {
            seed,
            at_ms: start.at,
            from_kpa,
            to_kpa,
            kind: bound.kind,
            settling_ms,
            bound_ms: bound.time_ms,
            // No step is longer than until the next.
            bound_error_kpa_ms: if bound.time_ms <= (end - start.at) as f64 { bound.error_kpa_ms } else { 0.0 },
        }
    };
    trial.steps.iter().enumerate().map(step).collect()
}

fn score_steps(steps: &[StepScore], scores: &mut Scores) {
    let (mut settling, mut bound, mut ratio) = (Mean::default(), Mean::default(), Mean::default());
    let (mut mixed_settling, mut mixed_bound) = (Mean::default(), Mean::default());
    for step in steps {
        let mixed = step.kind == Kind::Mixed;
        let (count, not_settled) = if mixed {
            (&mut scores.mixed_steps, &mut scores.mixed_steps_not_settled)
        } else {
            (&mut scores.steps, &mut scores.steps_not_settled)
        };
        *count += 1;
        let Some(settling_ms) = step.settling_ms else {
            *not_settled += 1;
            continue;
        };
        if mixed {
            mixed_settling.add(settling_ms);
            mixed_bound.add(step.bound_ms);
            continue;
        }
        settling.add(settling_ms);
        bound.add(step.bound_ms);
        if let Some(over) = step.ratio() {
            ratio.add(over);
            raise(&mut scores.worst_settling_over_bound, over);
        }
    }
    scores.settling_ms = settling.get();
    scores.bound_ms = bound.get();
    scores.settling_over_bound = ratio.get();
    scores.mixed_settling_ms = mixed_settling.get();
    scores.mixed_bound_ms = mixed_bound.get();
}
