//! Figures of merit of a run, all taken from the true pressures and not from what the controller believed.
//!
//! # Words
//! - A *step* is an unbroken stretch of samples in which the controller runs (mode running or holding) with the same step and
//!   repeat. Its *setpoint* is the reference of its last sample.
//! - Its *hold* is the part in which the reference rests at the setpoint; it starts where the ramp ends. A step that was
//!   cut off before its ramp's end has no hold.
//! - *Within the band* is no more than [`BAND_KPA`] away from the setpoint.
//!
//! Nothing is left out silently: a hold in which a chamber never comes within the band adds nothing to the hold errors, and is
//! counted in `holds_not_reached`; one that ends outside the band is counted in `holds_not_settled`.

use crate::campaign::kind::fault_name;
use crate::trace::{Sample, Trace};
use model_core::actuation::{Actuation, Segment};
use model_core::controller::Mode;
use serde::Serialize;

/// Half the width of the band that counts as settled, kPa: the repeatability of the pressure sensor.
pub const BAND_KPA: f64 = 2.0;

/// Seconds in one simulated sample, and in a millisecond.
const TICK_S: f64 = 0.001;
/// A recording's rows are 10 ms apart; what lies between rows farther apart than this is not known, ms.
const GAP_MS: u32 = 100;

/// How one step went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepSummary {
    /// Which repeat of the sequence, from zero.
    pub repeat: u16,
    /// Index within the sequence, from zero.
    pub step: u16,
    /// Time of the first sample, s.
    pub start_s: f64,
    /// Time of the first sample of the hold, s; nothing when the step has no hold.
    pub hold_start_s: Option<f64>,
    /// Time of the last sample, s.
    pub end_s: f64,
    /// Setpoint of each chamber, kPa gauge.
    pub setpoint_kpa: [f64; 3],
    /// True pressure of each chamber in the last sample, kPa gauge.
    pub chamber_kpa: [f64; 3],
    /// Bend of each segment in the last sample, degrees.
    pub segment_bend_deg: [f64; 3],
    /// Bend of the whole finger in the last sample: the sum of the three, degrees.
    pub bend_deg: f64,
    /// Largest excess beyond the setpoint, in the direction in which the setpoint moved, kPa; zero where it did not move.
    pub overshoot_kpa: [f64; 3],
    /// Time from the hold's start until the chamber is within the band and stays there to the hold's end, s; nothing when it
    /// ends outside.
    pub settling_time_s: [Option<f64>; 3],
}

/// How one segment did over the whole run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SegmentSummary {
    /// The segment's name.
    pub segment: &'static str,
    /// Mean of |true pressure − setpoint|, kPa, over every hold from its first sample within the band to the hold's end; nothing
    /// when no hold came that far.
    pub hold_mean_abs_error_kpa: Option<f64>,
    /// The largest of the same, kPa.
    pub hold_worst_abs_error_kpa: Option<f64>,
    /// Holds in which the chamber never came within the band.
    pub holds_not_reached: u32,
    /// Holds that ended with the chamber outside the band.
    pub holds_not_settled: u32,
    /// Mean of |true pressure − reference|, kPa, over every sample that runs: ramps, step changes and all.
    pub tracking_mean_abs_error_kpa: Option<f64>,
    /// Largest overshoot of all steps, kPa.
    pub overshoot_kpa: f64,
    /// Longest settling time of all holds, s; nothing when one of them did not settle, or there is none.
    pub settling_time_s: Option<f64>,
    /// How often the segment's valve was switched, either way, from the safe state on.
    pub valve_switchings: u32,
    /// Highest true pressure, kPa gauge.
    pub peak_chamber_kpa: f64,
    /// True pressure in the run's last sample, kPa gauge.
    pub vented_residual_kpa: f64,
    /// Largest bend, degrees.
    pub peak_bend_deg: f64,
}

/// A run in figures. The keys of its JSON are the fields' names; every pressure is gauge.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Length of the run, s.
    pub duration_s: f64,
    /// Mean hold error over all three segments' samples, kPa; see [`SegmentSummary::hold_mean_abs_error_kpa`].
    pub hold_mean_abs_error_kpa: Option<f64>,
    /// Worst hold error of all segments, kPa.
    pub hold_worst_abs_error_kpa: Option<f64>,
    /// Holds not reached, summed over the segments.
    pub holds_not_reached: u32,
    /// Holds not settled, summed over the segments.
    pub holds_not_settled: u32,
    /// Mean error of everything that runs, over all three segments, kPa.
    pub tracking_mean_abs_error_kpa: Option<f64>,
    /// Largest overshoot of all segments, kPa.
    pub overshoot_kpa: f64,
    /// Longest settling time of all segments, s; nothing when a hold did not settle.
    pub settling_time_s: Option<f64>,
    /// Switchings of the three segments' valves together.
    pub valve_switchings: u32,
    /// Switchings of the dump valve.
    pub dump_switchings: u32,
    /// How often the pump was started.
    pub pump_starts: u32,
    /// Time the pump was on, s.
    pub pump_on_s: f64,
    /// Highest true pressure of all chambers, kPa.
    pub peak_chamber_kpa: f64,
    /// Highest true pressure of the manifold, kPa.
    pub peak_manifold_kpa: f64,
    /// Highest of the chambers' pressures in the run's last sample, kPa.
    pub vented_residual_kpa: f64,
    /// Largest bend of the whole finger, degrees.
    pub peak_bend_deg: f64,
    /// Faults that latched, in order of time.
    pub faults: Vec<String>,
    /// Each segment, proximal first.
    pub segments: [SegmentSummary; 3],
    /// Each step in order of time.
    pub steps: Vec<StepSummary>,
}

/// Sum, count and largest of absolute errors.
#[derive(Clone, Copy, Default)]
struct Errors {
    sum: f64,
    count: u32,
    worst: f64,
}

impl Errors {
    fn add(&mut self, error: f64) {
        self.sum += error.abs();
        self.count += 1;
        self.worst = self.worst.max(error.abs());
    }

    fn mean(self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }

    fn worst(self) -> Option<f64> {
        (self.count > 0).then_some(self.worst)
    }

    fn joined(all: [Self; 3]) -> Self {
        all.into_iter().fold(Self::default(), |a, b| Self {
            sum: a.sum + b.sum,
            count: a.count + b.count,
            worst: a.worst.max(b.worst),
        })
    }
}

/// True while the controller follows a reference.
#[must_use]
pub fn runs(sample: &Sample) -> bool {
    matches!(sample.mode, Mode::Running | Mode::Holding)
}

/// Splits a run into its steps.
#[must_use]
pub fn steps_of(samples: &[Sample]) -> Vec<&[Sample]> {
    samples
        .chunk_by(|a, b| (a.mode, a.repeat, a.step) == (b.mode, b.repeat, b.step))
        .filter(|chunk| runs(&chunk[0]))
        .collect()
}

/// The part of a step in which the reference rests; empty when the step was cut off.
fn hold_of(step: &[Sample]) -> &[Sample] {
    let start = step.iter().rposition(|sample| !sample.holding).map_or(0, |last_ramp| last_ramp + 1);
    &step[start..]
}

fn seconds(time_ms: u32) -> f64 {
    f64::from(time_ms) * TICK_S
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// The longest of times, or nothing as soon as one is missing.
fn longest(times: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let mut seen = None;
    for time in times {
        seen = Some(time?.max(seen.unwrap_or(0.0)));
    }
    seen
}

fn summarise_step(step: &[Sample], previous_kpa: [f64; 3]) -> Option<StepSummary> {
    let (first, last) = (step.first()?, step.last()?);
    let hold = hold_of(step);
    let segments = [0, 1, 2];
    let overshoot_kpa = segments.map(|i| {
        let target = last.setpoints_kpa[i];
        let direction = if target > previous_kpa[i] {
            1.0
        } else if target < previous_kpa[i] {
            -1.0
        } else {
            0.0
        };
        largest(step.iter().map(|sample| direction * (sample.chambers_kpa[i] - target)))
    });
    let settling_time_s = segments.map(|i| {
        let target = last.setpoints_kpa[i];
        let outside = |sample: &Sample| (sample.chambers_kpa[i] - target).abs() > BAND_KPA;
        let settled = hold.iter().rposition(outside).map_or(0, |last_outside| last_outside + 1);
        hold.get(settled).map(|sample| seconds(sample.time_ms - hold[0].time_ms))
    });
    Some(StepSummary {
        repeat: first.repeat,
        step: first.step,
        start_s: seconds(first.time_ms),
        hold_start_s: hold.first().map(|sample| seconds(sample.time_ms)),
        end_s: seconds(last.time_ms),
        setpoint_kpa: last.setpoints_kpa,
        chamber_kpa: last.chambers_kpa,
        segment_bend_deg: last.bends_deg,
        bend_deg: last.bends_deg.iter().sum(),
        overshoot_kpa,
        settling_time_s,
    })
}

/// Errors while holding, how many holds were not reached, and errors over everything that runs.
fn errors_of(samples: &[Sample], steps: &[&[Sample]], segment: usize) -> (Errors, u32, Errors) {
    let (mut held, mut not_reached, mut tracked) = (Errors::default(), 0, Errors::default());
    let error = |sample: &Sample| sample.chambers_kpa[segment] - sample.setpoints_kpa[segment];
    for hold in steps.iter().map(|step| hold_of(step)).filter(|hold| !hold.is_empty()) {
        match hold.iter().position(|sample| error(sample).abs() <= BAND_KPA) {
            Some(reached) => hold[reached..].iter().for_each(|sample| held.add(error(sample))),
            None => not_reached += 1,
        }
    }
    samples.iter().filter(|sample| runs(sample)).for_each(|sample| tracked.add(error(sample)));
    (held, not_reached, tracked)
}

/// How often `output` changes, starting from the safe state.
fn switchings<T: PartialEq>(samples: &[Sample], output: impl Fn(&Actuation) -> T) -> u32 {
    let mut last = output(&Actuation::SAFE);
    let mut count = 0;
    for sample in samples {
        let now = output(&sample.actuation);
        count += u32::from(now != last);
        last = now;
    }
    count
}

/// Time for which a condition held, s: from each sample to the next, the last for a millisecond.
fn lasting(samples: &[Sample], held: impl Fn(&Sample) -> bool) -> f64 {
    let next = samples.iter().skip(1).map(Some).chain([None]);
    let pairs = samples.iter().zip(next).filter(|(sample, _)| held(sample));
    let ms: u32 = pairs.map(|(sample, next)| next.map_or(1, |next| (next.time_ms - sample.time_ms).min(GAP_MS))).sum();
    seconds(ms)
}

/// Works out the figures of a run; an empty run gives zeros and nothing.
#[must_use]
pub fn summarise(trace: &Trace) -> Summary {
    let samples = trace.samples.as_slice();
    let parts = steps_of(samples);
    let mut previous_kpa = [0.0; 3];
    let mut steps = Vec::with_capacity(parts.len());
    for part in &parts {
        if let Some(step) = summarise_step(part, previous_kpa) {
            previous_kpa = step.setpoint_kpa;
            steps.push(step);
        }
    }

    let errors = [0, 1, 2].map(|i| errors_of(samples, &parts, i));
    let segments = Segment::ALL.map(|segment| {
        let i = segment as usize;
        let (held, holds_not_reached, tracked) = errors[i];
        let holds = || steps.iter().filter(|step| step.hold_start_s.is_some()).map(|step| step.settling_time_s[i]);
        SegmentSummary {
            segment: segment.name(),
            hold_mean_abs_error_kpa: held.mean(),
            hold_worst_abs_error_kpa: held.worst(),
            holds_not_reached,
            holds_not_settled: holds().filter(Option::is_none).count() as u32,
            tracking_mean_abs_error_kpa: tracked.mean(),
            overshoot_kpa: largest(steps.iter().map(|step| step.overshoot_kpa[i])),
            settling_time_s: longest(holds()),
            valve_switchings: switchings(samples, |actuation| actuation.segments[i]),
            peak_chamber_kpa: largest(samples.iter().map(|sample| sample.chambers_kpa[i])),
            vented_residual_kpa: samples.last().map_or(0.0, |sample| sample.chambers_kpa[i]),
            peak_bend_deg: largest(samples.iter().map(|sample| sample.bends_deg[i])),
        }
    });

    let mut faults = Vec::new();
    let mut last_mode = Mode::Vented;
    for sample in samples {
        if let Mode::Faulted(fault) = sample.mode
            && sample.mode != last_mode
        {
            faults.push(fault_name(fault));
        }
        last_mode = sample.mode;
    }

    let held = Errors::joined(errors.map(|(held, ..)| held));
    let tracked = Errors::joined(errors.map(|(.., tracked)| tracked));
    // The pump rests in the safe state: of n switchings every odd one starts it.
    let pump_starts = switchings(samples, |actuation| actuation.pump).div_ceil(2);
    Summary {
        duration_s: samples
            .first()
            .zip(samples.last())
            .map_or(0.0, |(first, last)| seconds(last.time_ms - first.time_ms + 1)),
        hold_mean_abs_error_kpa: held.mean(),
        hold_worst_abs_error_kpa: held.worst(),
        holds_not_reached: segments.iter().map(|segment| segment.holds_not_reached).sum(),
        holds_not_settled: segments.iter().map(|segment| segment.holds_not_settled).sum(),
        tracking_mean_abs_error_kpa: tracked.mean(),
        overshoot_kpa: largest(segments.iter().map(|segment| segment.overshoot_kpa)),
        settling_time_s: longest(segments.iter().map(|segment| segment.settling_time_s)),
        valve_switchings: segments.iter().map(|segment| segment.valve_switchings).sum(),
        dump_switchings: switchings(samples, |actuation| actuation.dump),
        pump_starts,
        pump_on_s: lasting(samples, |sample| sample.actuation.pump),
        peak_chamber_kpa: largest(segments.iter().map(|segment| segment.peak_chamber_kpa)),
        peak_manifold_kpa: largest(samples.iter().map(|sample| sample.manifold_kpa)),
        vented_residual_kpa: largest(segments.iter().map(|segment| segment.vented_residual_kpa)),
        peak_bend_deg: largest(samples.iter().map(|sample| sample.bends_deg.iter().sum())),
        faults,
        segments,
        steps,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::record::mode_name;
    use model_core::actuation::Passage;
    use model_core::controller::Fault;
    use model_core::supervisor::fault::FaultSet;

    /// A sample at which nothing happens, vented.
    fn rest(time_ms: u32) -> Sample {
        Sample {
            time_ms,
            actuation: Actuation::SAFE,
            mode: Mode::Vented,
            faults: FaultSet::EMPTY,
            step: 0,
            repeat: 0,
            holding: false,
            setpoints_kpa: [0.0; 3],
            estimates_kpa: [0.0; 3],
            chambers_kpa: [0.0; 3],
            manifold_kpa: 0.0,
            sensor_kpa: 0.0,
            bends_deg: [0.0; 3],
            bend_sensor_deg: 0.0,
        }
    }

    fn trace(samples: Vec<Sample>) -> Trace {
        Trace { name: "hand".into(), description: String::new(), seed: 0, samples }
    }

    /// One step of the proximal chamber: its setpoint, and for every sample the reference and the true pressure.
    fn step(index: u16, start_ms: u32, ramp: &[(f64, f64)], hold: &[(f64, f64)]) -> Vec<Sample> {
        let sample = |(offset, (&(reference, chamber), holding)): (usize, (&(f64, f64), bool))| Sample {
            mode: Mode::Running,
            step: index,
            holding,
            setpoints_kpa: [reference, 0.0, 0.0],
            chambers_kpa: [chamber, 0.0, 0.0],
            bends_deg: [chamber, 1.0, 2.0],
            ..rest(start_ms + offset as u32)
        };
        let ramp = ramp.iter().map(|pair| (pair, false));
        ramp.chain(hold.iter().map(|pair| (pair, true))).enumerate().map(sample).collect()
    }

    fn close(a: Option<f64>, b: f64) {
        assert!(a.is_some_and(|a| (a - b).abs() < 1e-12), "{a:?} is not {b}");
    }

    #[test]
    fn hold_errors_start_with_the_first_sample_within_the_band() {
        // Two ramp samples, then a hold at 20: 15 is outside, 18 within, 23 outside again, 21 and 20 within.
        let samples = step(
            0,
            0,
            &[(5.0, 0.0), (10.0, 4.0)],
            &[(20.0, 15.0), (20.0, 18.0), (20.0, 23.0), (20.0, 21.0), (20.0, 20.0)],
        );
        let summary = summarise(&trace(samples));
        let proximal = &summary.segments[0];
        close(proximal.hold_mean_abs_error_kpa, (2.0 + 3.0 + 1.0 + 0.0) / 4.0);
        close(proximal.hold_worst_abs_error_kpa, 3.0);
        close(proximal.tracking_mean_abs_error_kpa, (5.0 + 6.0 + 5.0 + 2.0 + 3.0 + 1.0 + 0.0) / 7.0);
        // The last sample outside is the hold's third, at 2 ms into it.
        close(proximal.settling_time_s, 0.003);
        assert!((proximal.overshoot_kpa - 3.0).abs() < 1e-12);
        assert_eq!((proximal.holds_not_reached, proximal.holds_not_settled), (0, 0));
        // All three segments together: the other two sit at their setpoint of zero for all five samples of the hold.
        close(summary.hold_mean_abs_error_kpa, 6.0 / 14.0);
        close(summary.tracking_mean_abs_error_kpa, 22.0 / 21.0);
        assert!((summary.steps[0].bend_deg - 23.0).abs() < 1e-12);
        close(summary.steps[0].hold_start_s, 0.002);
    }

    #[test]
    fn what_never_gets_there_is_counted_and_not_averaged() {
        let summary = summarise(&trace(step(0, 0, &[], &[(20.0, 10.0), (20.0, 12.0)])));
        let proximal = &summary.segments[0];
        assert_eq!((proximal.hold_mean_abs_error_kpa, proximal.settling_time_s), (None, None));
        assert_eq!((proximal.holds_not_reached, proximal.holds_not_settled), (1, 1));
        assert_eq!(summary.settling_time_s, None);
        let json = serde_json::to_value(&summary).unwrap();
        assert!(json["settling_time_s"].is_null() && json["segments"][0]["hold_mean_abs_error_kpa"].is_null());
    }

    #[test]
    fn overshoot_takes_the_direction_of_the_step() {
        let mut samples = step(0, 0, &[], &[(20.0, 20.5), (20.0, 20.0)]);
        samples.extend(step(1, 2, &[(15.0, 20.0)], &[(10.0, 8.5), (10.0, 11.9)]));
        // The setpoint stays: this is no overshoot, only a hold error.
        samples.extend(step(2, 5, &[], &[(10.0, 11.5)]));
        let summary = summarise(&trace(samples));
        let overshoots: Vec<f64> = summary.steps.iter().map(|step| step.overshoot_kpa[0]).collect();
        assert_eq!(overshoots, [0.5, 1.5, 0.0]);
    }

    #[test]
    fn a_step_cut_off_in_its_ramp_has_no_hold() {
        let summary = summarise(&trace(step(0, 0, &[(5.0, 0.0), (10.0, 4.0)], &[])));
        assert_eq!(summary.steps[0].hold_start_s, None);
        assert_eq!((summary.holds_not_reached, summary.holds_not_settled), (0, 0));
        assert_eq!(summary.hold_mean_abs_error_kpa, None);
    }

    #[test]
    fn switchings_count_from_the_safe_state() {
        let shut = Actuation::HOLD;
        let fill = Actuation { pump: true, segments: [Passage::Open, Passage::Closed, Passage::Closed], ..shut };
        let actuations = [shut, fill, fill, shut, fill, Actuation::SAFE];
        let samples = actuations.iter().zip(0..).map(|(&actuation, time)| Sample { actuation, ..rest(time) }).collect();
        let summary = summarise(&trace(samples));
        // Proximal: closed, open, closed, open, open. The others: closed, and open at the end.
        assert_eq!(summary.segments.each_ref().map(|segment| segment.valve_switchings), [4, 2, 2]);
        assert_eq!((summary.dump_switchings, summary.pump_starts), (2, 2));
        assert!((summary.pump_on_s - 0.003).abs() < 1e-12);
        assert_eq!(summary.valve_switchings, 8);
    }

    #[test]
    fn peaks_residuals_and_faults() {
        let mut samples = vec![rest(0), rest(1), rest(2), rest(3)];
        samples[1].chambers_kpa = [3.0, 151.0, 2.0];
        samples[1].manifold_kpa = 160.0;
        samples[2].mode = Mode::Faulted(Fault::OverPressure);
        samples[3].mode = Mode::Faulted(Fault::OverPressure);
        samples[3].chambers_kpa = [0.25, 0.5, 0.0];
        let summary = summarise(&trace(samples));
        assert!((summary.peak_chamber_kpa - 151.0).abs() < 1e-12 && (summary.peak_manifold_kpa - 160.0).abs() < 1e-12);
        assert!((summary.vented_residual_kpa - 0.5).abs() < 1e-12);
        assert_eq!(summary.faults, ["over-pressure"]);
        assert_eq!(mode_name(Mode::Faulted(Fault::EmergencyStop)), "faulted:emergency-stop");
        assert_eq!(mode_name(Mode::Running), "running");
    }

    #[test]
    fn an_empty_run_gives_nothing() {
        let summary = summarise(&trace(Vec::new()));
        assert_eq!((summary.hold_mean_abs_error_kpa, summary.steps.len()), (None, 0));
    }
}
