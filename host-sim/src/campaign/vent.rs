//! The plant's own vent time: the same plant from the same moment, with the same faults, de-energised by nobody's decision.

use crate::plant::Plant;
use model_core::actuation::Actuation;

/// A chamber below this counts as vented, kPa.
pub const VENTED_KPA: f64 = 10.0;
/// A chamber that is not vented by then never will be, ms. The slowest plant that is drawn takes 6 s.
pub const HORIZON_MS: u32 = 12_000;

/// A pump slower than this share of its speed delivers nothing that matters.
const RUN_DOWN: f64 = 0.01;
/// A pump that runs though nobody asks for it shows its speed by then, ms.
const STARTS_MS: u32 = 100;

/// What each chamber does when everything is de-energised.
#[derive(Clone, Copy, Debug)]
pub struct Reference {
    /// From when on it stays below [`VENTED_KPA`], ms from the start: the fuller ones may fill it first. None when it does not get
    /// there within [`HORIZON_MS`].
    pub vented_ms: [Option<u32>; 3],
    /// Where it is in the end, kPa.
    pub end_kpa: [f64; 3],
    /// Whether one is above `limit_kpa` for longer than `limit_ms` on the way.
    pub over_pressure: bool,
}

impl Reference {
    /// Lets a copy of the plant vent; to the horizon when `more_comes`, a fault that may fill it again.
    #[must_use]
    pub fn of(plant: &Plant, limit_kpa: f64, limit_ms: u32, more_comes: bool) -> Self {
        let mut plant = plant.clone();
        let mut reference = Self { vented_ms: [Some(0); 3], end_kpa: [0.0; 3], over_pressure: false };
        let mut over_ms = [0; 3];
        for ms in 0..=HORIZON_MS {
            let chambers_kpa = plant.chambers_kpa();
            for (chamber, kpa) in chambers_kpa.into_iter().enumerate() {
                if kpa >= VENTED_KPA {
                    reference.vented_ms[chamber] = (ms < HORIZON_MS).then_some(ms + 1);
                }
                over_ms[chamber] = if kpa > limit_kpa { over_ms[chamber] + 1 } else { 0 };
                reference.over_pressure |= over_ms[chamber] > limit_ms;
            }
            reference.end_kpa = chambers_kpa;
            if ms >= STARTS_MS && !more_comes && chambers_kpa.iter().all(|&kpa| kpa < VENTED_KPA) {
                let truth = plant.truth();
                if truth.manifold_kpa < VENTED_KPA && truth.pump_speed < RUN_DOWN {
                    break;
                }
            }
            plant.step(&Actuation::SAFE);
        }
        reference
    }

    /// Whether every chamber can vent.
    #[must_use]
    pub fn all_vent(&self) -> bool {
        self.vented_ms.iter().all(Option::is_some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{FaultKind, InjectedFault, PlantParameters, Scene};
    use model_core::actuation::{Passage, Segment};

    fn reference(faults: &[FaultKind]) -> Reference {
        let faults = faults.iter().map(|&kind| InjectedFault::lasting(kind, 0));
        let plant = Plant::new(PlantParameters::default(), Scene::default().with_faults(faults), 1);
        Reference::of(&plant.starting_at(100.0, [100.0, 50.0, 5.0]), 165.0, 20, false)
    }

    #[test]
    fn a_whole_plant_vents_and_a_broken_one_as_far_as_it_can() {
        let whole = reference(&[]);
        let [a, b, filled] = whole.vented_ms.map(|ms| ms.expect("vents"));
        assert!(a >= b && (200..2000).contains(&a), "{whole:?}");
        assert!(filled.abs_diff(a) < 50, "the fullest fills the emptiest before both vent: {whole:?}");

        let own = reference(&[FaultKind::SegmentValveStuck(Segment::Proximal, Passage::Closed)]);
        assert_eq!(own.vented_ms[0], None);
        assert!(own.vented_ms[1].is_some() && own.end_kpa[0] > 50.0, "{own:?}");

        let dump = reference(&[FaultKind::DumpStuck(Passage::Closed)]);
        assert!(!dump.all_vent() && dump.end_kpa.iter().all(|kpa| (20.0..100.0).contains(kpa)), "{dump:?}");

        let pump = reference(&[FaultKind::PumpStuckOn]);
        assert!(!pump.all_vent() && !pump.over_pressure, "{pump:?}");
        let both = reference(&[FaultKind::PumpStuckOn, FaultKind::DumpStuck(Passage::Closed)]);
        assert!(both.over_pressure, "{both:?}");

        let empty = Plant::new(PlantParameters::default(), Scene::default(), 1);
        assert_eq!(Reference::of(&empty, 165.0, 20, false).vented_ms, [Some(0); 3]);
        let faults = [FaultKind::PumpStuckOn, FaultKind::DumpStuck(Passage::Closed)];
        let scene = Scene::default().with_faults(faults.map(|kind| InjectedFault::lasting(kind, 0)));
        let started = Reference::of(&Plant::new(PlantParameters::default(), scene, 1), 165.0, 20, false);
        assert!(started.over_pressure && !started.all_vent(), "it fills an empty finger too: {started:?}");
    }
}
