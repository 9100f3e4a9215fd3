//! A part of what `cargo xtask exhaustive` visits, small enough for every test run: a prime stride over all of i32 and
//! a finer one over the domain, and the surroundings of every edge.

use finger_tests::exhaustive::run::visit_some;
use finger_tests::exhaustive::{Direction, Subject, subjects};
use finger_tests::truth::table::calibrations;
use fixed::types::I8F24;
use model_core::calibration::DEFAULT;
use model_core::inverse::pressure_from_bend;
use model_core::units::{Bend, Coefficients};

/// Inputs on either side of an edge.
const RADIUS: i32 = 40;

/// Bends where a table's segment ends, in bits: every 8 degrees, and every eighth of an octave of the distance to 180
/// degrees.
fn segment_ends() -> impl Iterator<Item = i32> {
    let eights = (0..=21).map(|index| (8 * index) << 16);
    let octaves = (3..=7).flat_map(|m| (8..16).map(move |eighths| (180 << 16) - ((eighths << 16) << m) / 8));
    eights.chain(octaves).filter(|bits| (0..=170 << 16).contains(bits))
}

/// The inputs, rising.
fn inputs(subject: &Subject, calibration: &Coefficients, whole_stride: usize, domain_stride: usize) -> Vec<i32> {
    let end = subject.direction.domain_end();
    let mut inputs: Vec<i32> =
        (i32::MIN..=i32::MAX).step_by(whole_stride).chain((0..=end).step_by(domain_stride)).collect();
    let edges = segment_ends()
        .map(|bend| match subject.direction {
            Direction::PressureFromBend => bend,
            Direction::BendFromPressure => pressure_from_bend(calibration, Bend::from_bits(bend)).to_bits(),
        })
        .chain([i32::MIN, 0, end, i32::MAX])
        // Powers of two: where normalisation shifts change.
        .chain((0..31).map(|exponent| 1 << exponent));
    for edge in edges {
        inputs.extend(edge.saturating_sub(RADIUS)..=edge.saturating_add(RADIUS));
    }
    inputs.sort_unstable();
    inputs.dedup();
    inputs
}

fn hold(calibration: &Coefficients, whole_stride: usize, domain_stride: usize) {
    for subject in subjects(calibration) {
        let outcome = visit_some(&subject, &inputs(&subject, calibration, whole_stride, domain_stride));
        println!(
            "{} at {:?}: {} inputs, {} in the domain, worst {:.4} LSB",
            outcome.function, outcome.calibration_kpa, outcome.inputs, outcome.domain_inputs, outcome.worst_error_lsb
        );
        assert!(outcome.inputs > 10_000 && outcome.domain_inputs > 5_000, "{outcome:?}");
        assert_eq!(outcome.failures, 0, "{}", outcome.complaint());
    }
}

#[test]
fn default_calibration() {
    hold(&DEFAULT, 2_039, 31);
}

#[test]
fn other_calibrations() {
    for [k, c1, c2] in calibrations() {
        let bits = I8F24::from_bits;
        hold(&Coefficients::new(bits(k), bits(c1), bits(c2)).expect("admitted"), 131_071, 503);
    }
}
