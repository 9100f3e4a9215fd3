//! The regulator against the plant with noise and dead times, scenario by scenario and seed by seed: the bounds of `compare`'s
//! targets, and for a plant other than assumed twice those.

use host_sim::compare::bound::Physics;
use host_sim::compare::contender::Kind;
use host_sim::compare::scenario::find;
use host_sim::compare::score::{Scores, score};
use host_sim::compare::trial::run;

fn scores(name: &str, seed: u64) -> Scores {
    let scenario = find(name).expect("there");
    let physics = Physics::new(scenario.variation.parameters(), &scenario.variation.scene());
    let trial = run(scenario, seed, Kind::Ours.make().as_mut()).expect("the sensor works");
    score(&[(seed, trial)], &physics, scenario.scored_from_ms() as usize).0
}

#[test]
fn steps_are_reached_near_the_bound_without_overshoot_and_held() {
    for name in ["multi-step", "60-30-60"] {
        for seed in 1..=5 {
            let scores = scores(name, seed);
            let at = format!("{name}, seed {seed}: {scores:?}");
            assert!(scores.hold_error_kpa.is_some_and(|error| error <= 1.0), "{at}");
            assert!(scores.overshoot_kpa.is_some_and(|overshoot| overshoot <= 2.0), "{at}");
            assert!(scores.settling_over_bound.is_some_and(|ratio| ratio <= 1.2), "{at}");
            assert_eq!((scores.steps_not_settled, scores.holds_not_reached), (0, 0), "{at}");
            assert!(scores.peak_manifold_kpa <= 160.0, "{at}");
        }
    }
}

#[test]
fn random_setpoints_are_all_reached() {
    for seed in 1..=5 {
        let scores = scores("random", seed);
        let at = format!("seed {seed}: {scores:?}");
        assert_eq!(
            (scores.steps_not_settled, scores.mixed_steps_not_settled, scores.holds_not_reached),
            (0, 0, 0),
            "{at}"
        );
        assert!(scores.hold_error_kpa.is_some_and(|error| error <= 1.0), "{at}");
        assert!(scores.overshoot_kpa.is_some_and(|overshoot| overshoot <= 2.5), "{at}");
    }
}

#[test]
fn moving_setpoints_are_followed_with_few_switchings() {
    for (name, error_kpa, switchings_per_min) in [
        ("sine-0.1", 1.5, 600.0),
        ("sine-0.25", 1.5, 1000.0),
        ("sine-0.5", 2.0, 1000.0),
        ("sine-one", 1.5, 1500.0),
        ("slow", 1.5, 600.0),
    ] {
        for seed in 1..=3 {
            let scores = scores(name, seed);
            let at = format!("{name}, seed {seed}: {scores:?}");
            assert!(scores.mean_absolute_error_kpa <= error_kpa, "{at}");
            assert!(scores.switchings_per_min() <= switchings_per_min, "{at}");
        }
    }
}

#[test]
fn another_plant_than_assumed_has_twice_the_room() {
    for name in ["leak", "half-pump", "double-volume", "cold-valves"] {
        for seed in 1..=3 {
            let scores = scores(name, seed);
            let at = format!("{name}, seed {seed}: {scores:?}");
            assert!(scores.hold_error_kpa.is_some_and(|error| error <= 2.0), "{at}");
            assert!(scores.overshoot_kpa.is_some_and(|overshoot| overshoot <= 4.0), "{at}");
            assert!(scores.peak_manifold_kpa <= 165.0, "{at}");
        }
    }
}
