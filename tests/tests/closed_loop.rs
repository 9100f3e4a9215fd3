//! The core in closed loop with the simulated plant: what a run must reach on the default plant, noise on.

use host_sim::metrics::{Summary, summarise};
use host_sim::simulate::{Program, Run};
use model_core::sequence::library;

fn summary(name: &str, seed: u64) -> Summary {
    let sequence = library::find(name).expect("built in");
    summarise(&Run::new(Program::Sequence(sequence), seed).simulate(|_, _| {}).expect("the command is taken"))
}

/// The paper's reconfiguration and its seven combinations of 150 kPa.
const PAPER: [&str; 8] =
    ["reconfigure", "proximal", "middle", "distal", "proximal-middle", "proximal-distal", "middle-distal", "all"];

#[test]
fn the_papers_combinations_are_reached_held_and_vented() {
    for name in PAPER {
        for seed in 1..=5 {
            let summary = summary(name, seed);
            for segment in &summary.segments {
                let at = format!("{name}, seed {seed}, {segment:?}");
                assert!(segment.hold_mean_abs_error_kpa.is_some_and(|error| error <= 2.0), "{at}");
                assert_eq!((segment.holds_not_reached, segment.holds_not_settled), (0, 0), "{at}");
                assert!(segment.peak_chamber_kpa <= 160.0, "{at}");
                assert!(segment.vented_residual_kpa < 5.0, "{at}");
            }
            assert!(summary.faults.is_empty(), "{name}: {:?}", summary.faults);
        }
    }
}

#[test]
fn every_built_in_sequence_stays_within_the_limits_and_ends_vented() {
    for sequence in library::ALL {
        let summary = summary(sequence.name, 7);
        assert!(summary.faults.is_empty(), "{}: {:?}", sequence.name, summary.faults);
        assert!(summary.peak_chamber_kpa <= 160.0, "{}: {}", sequence.name, summary.peak_chamber_kpa);
        assert!(summary.vented_residual_kpa < 5.0, "{}: {}", sequence.name, summary.vented_residual_kpa);
        assert_eq!(summary.holds_not_reached, 0, "{}", sequence.name);
    }
}

/// The core's fixed-point model against the simulator's f64 model, which is written by another route.
#[test]
fn the_core_and_the_simulator_agree_on_the_model() {
    use host_sim::mechanics::{angle_from_pressure_deg, pressure_from_angle_kpa};
    use model_core::inverse::{bend_from_pressure, pressure_from_bend};
    use model_core::units::{Bend, Coefficients, Pressure};
    for [k, c1, c2] in [[0.0, 13.84, 0.336], [35.3, 7.24, 0.831], [0.0, 5.0, 0.0], [60.0, 40.0, 2.0]] {
        let coefficients = Coefficients::from_f64_kpa(k, c1, c2).expect("admitted");
        let exact = coefficients.to_f64_kpa();
        for step in 0..=30_000 {
            let pressure = Pressure::from_f64_kpa(f64::from(step) / 200.0);
            let ours = bend_from_pressure(&coefficients, pressure).to_f64();
            let truth = angle_from_pressure_deg(&exact, pressure.to_f64());
            assert!((ours - truth).abs() <= 0.005, "{exact:?} {pressure:?}: {ours} for {truth}");
            let bend = Bend::from_f64_deg(truth);
            let back = pressure_from_bend(&coefficients, bend).to_f64();
            let truth = pressure_from_angle_kpa(&exact, bend.to_f64());
            assert!((back - truth).abs() <= 0.005, "{exact:?} {bend:?}: {back} for {truth}");
        }
    }
}
