//! Where a tick's time goes: the default plant's ticks cut off after each of their parts.

use super::case::Case;
use super::{Choice, SEED, median_and_fastest};
use crate::plant::{Plant, Scene};
use core::hint::black_box;
use serde::Serialize;
use std::time::Instant;

/// A part of a tick.
#[derive(Clone, Debug, Serialize)]
pub struct PartRow {
    /// The part.
    pub part: &'static str,
    /// What it adds to a tick that ends before it, ns: median of the rounds.
    pub ns_per_tick: f64,
    /// The same between the fastest rounds.
    pub fastest_ns_per_tick: f64,
}

/// The default integrator in the default scene.
#[derive(Clone, Debug, Serialize)]
pub struct Breakdown {
    /// The parts, in their order; they sum up to the tick.
    pub parts: Vec<PartRow>,
    /// Evaluations of the flows for each tick: the same on every machine, as the next two.
    pub flow_evaluations_per_tick: f64,
    /// Share of the ticks in which all three bends took one step of Newton's method, side by side.
    pub bends_side_by_side_share: f64,
    /// Share of the ticks in which the bends were iterated one after another; in the rest nothing moved.
    pub bends_iterated_share: f64,
}

/// Measures it in so many rounds; the cuts take turns, so that a machine that slows down slows all of them.
///
/// Without the finger's part the chambers keep their volumes, so the air that flows is not quite the same.
#[must_use]
pub fn measure(scene: &Case, rounds: usize, mut progress: impl FnMut()) -> Breakdown {
    let default = Choice::of_the_plant();
    let plant = scene.plant(default.method, default.sub_steps, Scene::default(), SEED);
    let ticks = scene.commands.len() as f64;
    let mut taken = vec![Vec::with_capacity(rounds); Plant::CUT_AFTER.len()];
    let mut counts = plant.counts();
    for _ in 0..rounds {
        for ((_, tick), taken) in Plant::CUT_AFTER.iter().zip(&mut taken) {
            let mut plant = plant.clone();
            let start = Instant::now();
            for command in &scene.commands {
                black_box(tick(&mut plant, *command));
            }
            taken.push(start.elapsed().as_secs_f64() * 1e9 / ticks);
            counts = plant.counts();
        }
        progress();
    }
    let mut before = (0.0, 0.0);
    let parts = Plant::CUT_AFTER
        .iter()
        .zip(taken)
        .map(|(&(part, _), taken)| {
            let until = median_and_fastest(taken);
            let row = PartRow { part, ns_per_tick: until.0 - before.0, fastest_ns_per_tick: until.1 - before.1 };
            before = until;
            row
        })
        .collect();
    // The last cut is after the last part: a whole tick.
    Breakdown {
        parts,
        flow_evaluations_per_tick: counts.flow_evaluations as f64 / ticks,
        bends_side_by_side_share: counts.bends_side_by_side as f64 / ticks,
        bends_iterated_share: counts.bends_iterated as f64 / ticks,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pareto::plant::case;

    #[test]
    fn parts_sum_up_to_a_whole_tick_and_counts_are_those_of_a_replay() {
        let scene = case::default_scene().expect("solved");
        let breakdown = measure(&scene, 2, || {});
        assert_eq!(breakdown.parts.len(), 4);
        let default = Choice::of_the_plant();
        let outcome = scene.replay(scene.plant(default.method, default.sub_steps, Scene::default(), SEED));
        assert!((breakdown.flow_evaluations_per_tick - outcome.evaluations_per_tick).abs() <= 0.0);
        let (fast, slow) = (breakdown.bends_side_by_side_share, breakdown.bends_iterated_share);
        println!("{breakdown:?}");
        // Iterating is for switchings and for the neighbourhood of P = 0.
        assert!(fast > 0.5 && slow < 0.1 && fast + slow <= 1.0, "{fast} {slow}");
    }

    #[test]
    fn the_last_cut_is_the_plants_own_tick() {
        let scene = case::default_scene().expect("solved");
        let plant = scene.plant(Choice::of_the_plant().method, 1, Scene::default(), SEED);
        let (mut whole, mut cut) = (plant.clone(), plant);
        let last = Plant::CUT_AFTER[Plant::CUT_AFTER.len() - 1].1;
        for command in scene.commands.iter().take(2000) {
            assert_eq!(whole.step(command), last(&mut cut, *command));
        }
        assert_eq!(whole.truth(), cut.truth());
    }
}
