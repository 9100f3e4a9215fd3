//! Measurements out of a recording: the end of each hold that tells a pressure and the bend that belongs to it.
//!
//! The device has one bend sensor, on the whole finger. A hold tells a segment's bend when that segment alone is filled
//! (sequence `calibrate`), or when all three have one setpoint (sequence `staircase`): then a third of the bend is taken.
//! Pressures are the controller's estimates, of a simulated run too: a lab knows no truer ones.

use super::measurement::{EMPTY_KPA, MAX_DEG, MAX_KPA, Measurement, Measurements, Place, Scope};
use crate::report::chart::seconds;
use crate::report::csv::Recording;
use crate::report::record::Record;
use anyhow::{Result, ensure};
use model_core::actuation::Segment;
use model_core::paper::CHAMBERS;
use model_core::protocol::LinkMode;

/// A hold is measured over its last part, ms: the regulator and the finger's lag have come to rest, and noise is averaged.
const MEASURED_MS: u32 = 500;
/// A hold that is shorter tells nothing, ms.
const SHORTEST_MS: u32 = 1500;
/// What is left in a segment that counts as empty, kPa of its estimate: 0.5 kPa bend it by half a degree and more.
const EMPTIED_KPA: f64 = 0.5;
/// A segment's pressure may be this far from its setpoint, kPa: the regulator's band.
const REACHED_KPA: f64 = 2.0;

/// What the holds of a recording tell.
///
/// # Errors
/// When there is not one that tells anything.
pub fn measurements(recording: &Recording) -> Result<Measurements> {
    let mut found = Measurements::default();
    let same = |a: &Record, b: &Record| {
        (a.mode, a.repeat, a.step, a.holding, a.setpoints_kpa) == (b.mode, b.repeat, b.step, b.holding, b.setpoints_kpa)
    };
    for hold in recording.records.chunk_by(same) {
        let [first, .., last] = hold else { continue };
        let runs = matches!(first.mode, LinkMode::Running | LinkMode::Holding);
        if !runs || !first.holding || last.time_ms - first.time_ms < SHORTEST_MS {
            continue;
        }
        match measurement(hold, last) {
            Ok(None) => {}
            Ok(Some(measurement)) => found.all.push(measurement),
            Err(why) => found.left_out.push(format!("the hold that ends at {:.1} s {why}", seconds(last))),
        }
    }
    let why = found.left_out.first().map_or_else(String::new, |first| format!(": {first}"));
    ensure!(
        !found.all.is_empty(),
        "no hold of this recording tells a segment's bend{why}; record the sequence calibrate (each segment alone) or \
         staircase (all alike)"
    );
    Ok(found)
}

/// Mean of a quantity over the hold's end; not a number when it is missing there.
fn mean(hold: &[Record], last: &Record, quantity: impl Fn(&Record) -> f64) -> f64 {
    let end: Vec<f64> = hold.iter().filter(|r| last.time_ms - r.time_ms < MEASURED_MS).map(quantity).collect();
    end.iter().sum::<f64>() / end.len() as f64
}

/// What the hold tells; nothing when all are empty; or why it tells nothing.
fn measurement(hold: &[Record], last: &Record) -> Result<Option<Measurement>, String> {
    let setpoints_kpa = last.setpoints_kpa;
    let estimates_kpa = [0, 1, 2].map(|index| mean(hold, last, |record| record.estimates_kpa[index]));
    let filled: Vec<Segment> =
        Segment::ALL.into_iter().filter(|&segment| setpoints_kpa[segment as usize] >= EMPTY_KPA).collect();
    let alike = setpoints_kpa.iter().all(|kpa| (kpa - setpoints_kpa[0]).abs() < 0.01);
    let (scope, chambers, pressure_kpa) = match filled.as_slice() {
        [] => return Ok(None),
        [one] => (Scope::of(*one), 1.0, estimates_kpa[*one as usize]),
        [_, _, _] if alike => (Scope::All, CHAMBERS, estimates_kpa.iter().sum::<f64>() / CHAMBERS),
        _ => return Err("fills several segments differently, and the bend sensor tells only their sum".into()),
    };
    for segment in Segment::ALL {
        let index = segment as usize;
        let (estimate, setpoint) = (estimates_kpa[index], setpoints_kpa[index]);
        if !filled.contains(&segment) && estimate > EMPTIED_KPA {
            return Err(format!(
                "has {estimate:.1} kPa left in the {} segment, more than {EMPTIED_KPA}",
                segment.name()
            ));
        }
        // A missing estimate is not close either.
        let reached = (estimate - setpoint).abs() <= REACHED_KPA;
        if filled.contains(&segment) && !reached {
            return Err(format!("has {estimate:.1} kPa in the {} segment, not its {setpoint:.1}", segment.name()));
        }
    }
    let bend_deg = mean(hold, last, |record| record.bend_sensor_deg) / chambers;
    if bend_deg.is_nan() {
        return Err("lacks readings of the bend sensor".into());
    }
    if !(bend_deg > 0.0 && bend_deg < MAX_DEG && pressure_kpa <= MAX_KPA) {
        return Err(format!("has a bend of {bend_deg:.1} degrees a segment, outside 0..{MAX_DEG}"));
    }
    Ok(Some(Measurement {
        place: Place::Time(seconds(last)),
        scope,
        repeat: Some(u32::from(last.repeat) + 1),
        pressure_kpa,
        bend_deg,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::csv::{read, table};
    use crate::simulate::{Program, Run};
    use model_core::calibration;
    use model_core::sequence::library;

    fn recorded(name: &str) -> Recording {
        let sequence = library::find(name).expect("built in");
        let trace = Run::new(Program::Sequence(sequence), 4).simulate(|_, _| {}).expect("taken");
        read(table(&trace).expect("text").as_bytes()).expect("a recording")
    }

    #[test]
    fn the_sequence_calibrate_tells_five_points_of_each_segment() {
        let found = measurements(&recorded("calibrate")).expect("holds");
        assert_eq!(found.all.len(), 15, "{:?}", found.left_out);
        for (index, measured) in found.all.iter().enumerate() {
            assert_eq!(measured.scope, Scope::One((index / 5) as u8));
            let asked_kpa = 30.0 * (index % 5 + 1) as f64;
            assert!((measured.pressure_kpa - asked_kpa).abs() < 2.0, "{measured:?}");
            // The plant's finger is the paper's; its sensor has 1 % of gain error and the estimate's own.
            let bend_deg = calibration::bend_deg(calibration::DEFAULT.to_f64_kpa(), asked_kpa);
            assert!((measured.bend_deg - bend_deg).abs() < 0.05 * bend_deg, "{measured:?}, not {bend_deg}");
        }
    }

    #[test]
    fn the_staircase_tells_both_ways_and_what_is_mixed_is_left_out() {
        let found = measurements(&recorded("staircase")).expect("holds");
        assert_eq!(found.all.len(), 9, "{:?}", found.left_out);
        assert!(found.all.iter().all(|measured| measured.scope == Scope::All));
        let error = measurements(&recorded("reconfigure")).expect_err("60/30/60 kPa tell nothing");
        assert!(error.to_string().contains("several segments") && error.to_string().contains("calibrate"), "{error}");
    }

    #[test]
    fn a_sensor_that_fails_and_a_pressure_not_reached_leave_the_hold_out() {
        let mut whole = recorded("calibrate");
        for record in whole.records.iter_mut().filter(|record| record.step == 2) {
            record.bend_sensor_deg = f64::NAN;
        }
        for record in whole.records.iter_mut().filter(|record| record.step == 3) {
            record.estimates_kpa[0] = 90.0;
        }
        let found = measurements(&whole).expect("the other holds");
        assert_eq!(found.all.len(), 13);
        assert!(found.left_out[0].contains("lacks readings"), "{:?}", found.left_out);
        assert!(found.left_out[1].contains("90.0 kPa") && found.left_out[1].contains("120.0"), "{:?}", found.left_out);
    }
}
