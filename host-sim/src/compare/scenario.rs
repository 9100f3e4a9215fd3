//! What the regulators are asked to do: references as functions of time, and the plant they meet.
//!
//! The references go straight to the regulators, a value a millisecond: the sequences' ramps are not in the way.

use crate::plant::{FaultKind, InjectedFault, PlantParameters, Scene};
use core::f64::consts::TAU;
use model_core::actuation::Segment;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// How the references move.
#[derive(Clone, Copy, Debug)]
pub enum Reference {
    /// Steps of the three chambers, kPa, each held for so long.
    Steps {
        /// Time of each, ms.
        each_ms: u32,
        /// The chambers' references, proximal first, kPa.
        kpa: &'static [[f64; 3]],
    },
    /// Setpoints that the seed draws, each chamber its own, whole kPa in 0..=150.
    Random {
        /// Time of each, ms.
        each_ms: u32,
        /// How many.
        count: u32,
    },
    /// From the trough upwards: `middle - amplitude cos(2 pi f t)`; for a lead-in of [`LEAD_IN_MS`] it stays in the trough.
    Sine {
        /// Frequency, Hz.
        hz: f64,
        /// Middle, kPa.
        middle_kpa: f64,
        /// Amplitude of each chamber, kPa; one of 0 holds.
        amplitude_kpa: [f64; 3],
        /// Where a chamber with amplitude 0 is held, kPa.
        hold_kpa: [f64; 3],
        /// Time after the lead-in, ms.
        for_ms: u32,
    },
    /// All three rise evenly to 150 kPa, rest, fall evenly to 0, rest.
    Slow {
        /// Time of the rise, and of the fall, ms.
        ramp_ms: u32,
        /// Time of each rest, ms.
        rest_ms: u32,
    },
}

/// Time for which a sine waits in its trough; not scored.
pub const LEAD_IN_MS: u32 = 2000;

/// Top of the slow flexion, kPa.
const TOP_KPA: f64 = 150.0;

/// How the plant differs from the default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variation {
    /// Not at all.
    Default,
    /// The middle chamber leaks, about 3 kPa/s at 100 kPa.
    Leak,
    /// The pump delivers half.
    HalfPump,
    /// The chambers have twice the volume.
    DoubleVolume,
    /// Segment and dump valves take twice their dead time.
    ColdValves,
}

/// Sonic conductance of the leak, NL/(s bar): a 250th of a valve's.
const LEAK_NL_PER_S_BAR: f64 = 1e-4;

impl Variation {
    /// The plant's figures.
    #[must_use]
    pub fn parameters(self) -> PlantParameters {
        let mut parameters = PlantParameters::default();
        match self {
            Self::Default | Self::Leak => {}
            Self::HalfPump => parameters.pump.free_flow_nl_per_min *= 0.5,
            Self::DoubleVolume => parameters.finger.chamber_ml *= 2.0,
            Self::ColdValves => {
                parameters.segment_valve.dead_time_ms *= 2;
                parameters.dump_valve.dead_time_ms *= 2;
            }
        }
        parameters
    }

    /// What is modelled, and what is broken.
    #[must_use]
    pub fn scene(self) -> Scene {
        match self {
            Self::Leak => Scene::default().with_faults([InjectedFault::lasting(
                FaultKind::ChamberLeak { segment: Segment::Middle, conductance_nl_per_s_bar: LEAK_NL_PER_S_BAR },
                0,
            )]),
            _ => Scene::default(),
        }
    }

    /// Whether it is one of the robust scenarios, which have twice the room.
    #[must_use]
    pub fn is_robust(self) -> bool {
        self != Self::Default
    }
}

/// One scenario.
#[derive(Clone, Copy, Debug)]
pub struct Scenario {
    /// Name on the command line and in tables.
    pub name: &'static str,
    /// One line on it.
    pub description: &'static str,
    /// The references.
    pub reference: Reference,
    /// The plant.
    pub variation: Variation,
}

/// Several levels up and down, all chambers alike.
const MULTI_STEP: Reference = Reference::Steps {
    each_ms: 3000,
    kpa: &[
        [30.0; 3], [60.0; 3], [90.0; 3], [120.0; 3], [150.0; 3], [110.0; 3], [80.0; 3], [100.0; 3], [40.0; 3], [0.0; 3],
    ],
};

/// The paper's pose and other mixed ones, each from rest.
const SIXTY_THIRTY_SIXTY: Reference =
    Reference::Steps { each_ms: 4000, kpa: &[[60.0, 30.0, 60.0], [0.0; 3], [60.0, 30.0, 60.0], [0.0; 3]] };

/// All seven combinations of chambers at 150 kPa, from rest each.
const SEVEN: Reference = Reference::Steps {
    each_ms: 3000,
    kpa: &[
        [150.0, 0.0, 0.0],
        [0.0; 3],
        [0.0, 150.0, 0.0],
        [0.0; 3],
        [0.0, 0.0, 150.0],
        [0.0; 3],
        [150.0, 150.0, 0.0],
        [0.0; 3],
        [150.0, 0.0, 150.0],
        [0.0; 3],
        [0.0, 150.0, 150.0],
        [0.0; 3],
        [150.0; 3],
        [0.0; 3],
    ],
};

const fn sine(hz: f64, amplitude_kpa: [f64; 3], for_ms: u32) -> Reference {
    Reference::Sine { hz, middle_kpa: 60.0, amplitude_kpa, hold_kpa: [60.0, 60.0, 90.0], for_ms }
}

const fn usual(name: &'static str, description: &'static str, reference: Reference) -> Scenario {
    Scenario { name, description, reference, variation: Variation::Default }
}

const fn robust(name: &'static str, description: &'static str, variation: Variation) -> Scenario {
    Scenario { name, description, reference: MULTI_STEP, variation }
}

/// All scenarios, in the tables' order.
pub const ALL: [Scenario; 13] = [
    usual("multi-step", "all three in steps between 0 and 150 kPa, 3 s each", MULTI_STEP),
    usual("sine-0.1", "all three, 60 +- 30 kPa at 0.1 Hz", sine(0.1, [30.0; 3], 20_000)),
    usual("sine-0.25", "all three, 60 +- 30 kPa at 0.25 Hz", sine(0.25, [30.0; 3], 16_000)),
    usual("sine-0.5", "all three, 60 +- 30 kPa at 0.5 Hz", sine(0.5, [30.0; 3], 12_000)),
    usual(
        "sine-one",
        "proximal 60 +- 30 kPa at 0.25 Hz while the others hold 60 and 90 kPa",
        sine(0.25, [30.0, 0.0, 0.0], 16_000),
    ),
    usual("60-30-60", "60/30/60 kPa from rest, 4 s, twice", SIXTY_THIRTY_SIXTY),
    usual("seven", "the seven combinations of chambers at 150 kPa, 3 s each, vented between", SEVEN),
    usual("random", "each chamber to setpoints of its own, 3 s each", Reference::Random { each_ms: 3000, count: 12 }),
    usual(
        "slow",
        "all three up to 150 kPa in 10 s and down in 10 s",
        Reference::Slow { ramp_ms: 10_000, rest_ms: 2000 },
    ),
    robust("leak", "multi-step with a leak in the middle chamber, about 3 kPa/s at 100 kPa", Variation::Leak),
    robust("half-pump", "multi-step with half the pump's flow", Variation::HalfPump),
    robust("double-volume", "multi-step with chambers of twice the volume", Variation::DoubleVolume),
    robust("cold-valves", "multi-step with twice the valves' dead time", Variation::ColdValves),
];

/// The scenario of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Scenario> {
    ALL.iter().find(|scenario| scenario.name == name)
}

impl Scenario {
    /// How long it takes, ms.
    #[must_use]
    pub fn duration_ms(&self) -> u32 {
        match self.reference {
            Reference::Steps { each_ms, kpa } => each_ms * kpa.len() as u32,
            Reference::Random { each_ms, count } => each_ms * count,
            Reference::Sine { for_ms, .. } => LEAD_IN_MS + for_ms,
            Reference::Slow { ramp_ms, rest_ms } => 2 * (ramp_ms + rest_ms),
        }
    }

    /// From when on tracking is scored, ms.
    #[must_use]
    pub fn scored_from_ms(&self) -> u32 {
        match self.reference {
            Reference::Sine { .. } => LEAD_IN_MS,
            _ => 0,
        }
    }

    /// The references of the whole scenario, kPa: one of each chamber a millisecond. Only random setpoints need the seed.
    #[must_use]
    pub fn references_kpa(&self, seed: u64) -> Vec<[f64; 3]> {
        let duration_ms = self.duration_ms();
        match self.reference {
            Reference::Steps { each_ms, kpa } => stairs(each_ms, kpa),
            Reference::Random { each_ms, count } => {
                // Not the plant's own stream: the same setpoints whatever the sensors draw.
                let mut rng = Pcg64::seed_from_u64(seed ^ 0x5e7b_0125);
                let setpoints: Vec<[f64; 3]> =
                    (0..count).map(|_| core::array::from_fn(|_| f64::from(rng.random_range(0..=150_u32)))).collect();
                stairs(each_ms, &setpoints)
            }
            Reference::Sine { hz, middle_kpa, amplitude_kpa, hold_kpa, .. } => (0..duration_ms)
                .map(|time_ms| {
                    let seconds = 1e-3 * f64::from(time_ms.saturating_sub(LEAD_IN_MS));
                    let height = -(TAU * hz * seconds).cos();
                    core::array::from_fn(|i| {
                        if amplitude_kpa[i] > 0.0 { middle_kpa + amplitude_kpa[i] * height } else { hold_kpa[i] }
                    })
                })
                .collect(),
            Reference::Slow { ramp_ms, rest_ms } => (0..duration_ms)
                .map(|time_ms| {
                    let share =
                        |from_ms: u32| f64::from(time_ms.saturating_sub(from_ms).min(ramp_ms)) / f64::from(ramp_ms);
                    [TOP_KPA * (share(0) - share(ramp_ms + rest_ms)); 3]
                })
                .collect(),
        }
    }
}

/// Each setpoint for its time.
fn stairs(each_ms: u32, kpa: &[[f64; 3]]) -> Vec<[f64; 3]> {
    kpa.iter().flat_map(|&setpoints| core::iter::repeat_n(setpoints, each_ms as usize)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_stay_in_the_working_range_and_last_as_long_as_they_say() {
        for scenario in ALL {
            let references = scenario.references_kpa(3);
            assert_eq!(references.len(), scenario.duration_ms() as usize, "{}", scenario.name);
            assert!(references.iter().flatten().all(|kpa| (0.0..=150.0).contains(kpa)), "{}", scenario.name);
            assert!(find(scenario.name).is_some());
        }
        assert!(find("polka").is_none());
    }

    #[test]
    fn references_at_moments_worked_out_by_hand() {
        let at = |name: &str, time_ms: usize| find(name).expect("there").references_kpa(1)[time_ms][0];
        // In the trough, at the crest half a period later, in the middle a quarter later.
        assert!((at("sine-0.5", 2000) - 30.0).abs() < 1e-9);
        assert!((at("sine-0.5", 3000) - 90.0).abs() < 1e-9);
        assert!((at("sine-0.5", 3500) - 60.0).abs() < 1e-9);
        assert!((at("slow", 5000) - 75.0).abs() < 1e-9);
        assert!((at("slow", 11_000) - 150.0).abs() < 1e-9);
        assert!((at("slow", 14_000) - 120.0).abs() < 1e-9);
        assert!((at("multi-step", 2999) - 30.0).abs() < 1e-9 && (at("multi-step", 3000) - 60.0).abs() < 1e-9);
    }

    #[test]
    fn only_random_setpoints_depend_on_the_seed() {
        for scenario in ALL {
            let same = scenario.references_kpa(1) == scenario.references_kpa(2);
            assert_eq!(same, scenario.name != "random", "{}", scenario.name);
        }
    }
}
