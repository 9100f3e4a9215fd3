//! docs/hazards.md: every row names tests that exist, every fault of the table is in it, and its figures are the plant's.

use host_sim::plant::{FaultKind, InjectedFault, Plant, PlantParameters, Scene};
use model_core::actuation::{Actuation, Passage, Segment};
use model_core::supervisor::table::TABLE;
use std::path::Path;

const PAGE: &str = include_str!("../../docs/hazards.md");

/// Every `path.rs::name` between backticks.
fn named_tests() -> Vec<(&'static str, &'static str)> {
    let quoted = PAGE.split('`').skip(1).step_by(2);
    quoted
        .filter_map(|text| text.split_once("::"))
        .filter(|(path, _)| Path::new(path).extension().is_some_and(|end| end == "rs"))
        .collect()
}

#[test]
fn every_named_test_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the crate lies in the workspace");
    let named = named_tests();
    assert!(named.len() > 40, "{}", named.len());
    for (path, name) in named {
        let source = std::fs::read_to_string(root.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
        let definition = format!("fn {name}(");
        let at = source.find(&definition).unwrap_or_else(|| panic!("{path} has no test {name}"));
        // Attributes and comments stand between the last item and this one.
        let before = &source[..at];
        let item = before.rfind("\n\n").map_or(before, |start| &before[start..]);
        let in_proptest = before.contains("proptest! {");
        assert!(item.contains("#[test]") || in_proptest, "{path}::{name} is no test");
    }
}

#[test]
fn every_hazard_names_a_test_and_every_fault_is_covered() {
    let rows: Vec<_> = PAGE.lines().filter(|line| line.starts_with("| H")).collect();
    assert!(rows.len() >= 30, "{} hazards", rows.len());
    for row in &rows {
        let id = row.split('|').nth(1).unwrap_or_default();
        assert!(row.contains(".rs::") || row.contains("no test"), "{id} names no test and does not say so");
    }
    for row in TABLE {
        let name = format!("{:?}", row.fault);
        let name = name.split('(').next().unwrap_or_default();
        assert!(PAGE.contains(&format!("`{name}`")), "{name} is in no hazard");
    }
}

/// Manifold and chambers, kPa, after `ms` of the safe state with these faults: from rest, or from 150 kPa in every chamber
/// with the finger bent.
fn after_safe(filled: bool, faults: &[FaultKind], ms: u32) -> (f64, [f64; 3]) {
    const FILLED_BY_MS: u32 = 20_000;
    let from = if filled { FILLED_BY_MS } else { 0 };
    let scene = Scene::default().with_faults(faults.iter().map(|&kind| InjectedFault::lasting(kind, from)));
    let mut plant = Plant::new(PlantParameters::default(), scene, 1);
    for _ in 0..from {
        let pump = plant.truth().chambers_kpa[0] < 150.0;
        let fill = Actuation { pump, dump: Passage::Closed, segments: [Passage::Open; 3] };
        plant.step(&fill);
    }
    for _ in 0..ms {
        plant.step(&Actuation::SAFE);
    }
    let truth = plant.truth();
    (truth.manifold_kpa, truth.chambers_kpa)
}

/// What the safe state alone reaches when the parts that make it safe have failed. Prints the page's figures:
/// `cargo test -p finger-tests --test hazards -- --nocapture`.
#[test]
fn what_the_safe_state_cannot_vent() {
    let welded = after_safe(false, &[FaultKind::PumpStuckOn], 60_000);
    let blocked = after_safe(true, &[FaultKind::DumpStuck(Passage::Closed)], 60_000);
    let both = after_safe(true, &[FaultKind::DumpStuck(Passage::Closed), FaultKind::PumpStuckOn], 60_000);
    let segment = FaultKind::SegmentValveStuck(Segment::Middle, Passage::Closed);
    let shut = after_safe(true, &[segment], 60_000);
    for (name, (manifold, [p, m, d])) in [
        ("pump welded on", welded),
        ("dump stuck closed, from 150 kPa", blocked),
        ("dump stuck closed and pump welded on, from 150 kPa", both),
        ("middle valve stuck closed, from 150 kPa", shut),
    ] {
        println!("{name}: after a minute manifold {manifold:.1} kPa, chambers {p:.1} / {m:.1} / {d:.1} kPa");
    }
    assert!((40.0..90.0).contains(&welded.0) && (100.0..160.0).contains(&blocked.0));
    assert!(both.0 > 200.0 && shut.1[1] > 100.0 && shut.1[0] < 1.0);
    let sound = (500..5000)
        .step_by(10)
        .find(|&ms| after_safe(true, &[], ms).1.iter().all(|&kpa| kpa < 10.0))
        .expect("it vents");
    println!("sound: below 10 kPa after {sound} ms");
}

/// Venting opens every valve, so for a moment a full chamber's air passes through the manifold into an empty one. Prints the page's
/// figures: `cargo test -p finger-tests --test hazards -- --nocapture`.
#[test]
fn venting_lifts_an_empty_chamber_beside_full_ones() {
    let peak = |full: [f64; 3]| {
        let mut plant = Plant::new(PlantParameters::default(), Scene::default(), 1).starting_at(0.0, full);
        (0..3000).fold(0.0_f64, |peak, _| {
            plant.step(&Actuation::SAFE);
            peak.max(plant.truth().chambers_kpa[2])
        })
    };
    let (beside_one, beside_two) = (peak([150.0, 0.0, 0.0]), peak([150.0, 150.0, 0.0]));
    println!("an empty chamber beside one at 150 kPa: {beside_one:.0} kPa, beside two: {beside_two:.0} kPa");
    // The air shared, less what has left through the dump valve by then: never above it.
    assert!((10.0..50.0).contains(&beside_one), "{beside_one}");
    assert!((beside_one + 10.0..100.0).contains(&beside_two), "{beside_two}");
}
