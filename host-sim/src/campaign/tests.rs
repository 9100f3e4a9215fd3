//! The campaign itself is tested: what is split is joined to the same, what failed fails again, and what is broken is caught.

use super::draw::Choice;
use super::judge::Ending;
use super::kind::Kind;
use super::shard::Part;
use super::*;
use model_core::actuation::{Actuation, Passage, PerSegment};
use model_core::controller::{Command, Controller, Inputs, Mode, Outputs};
use model_core::supervisor::fault::{Fault, FaultSet};
use model_core::units::Coefficients;

fn campaign(runs: u64) -> Campaign {
    Campaign { schema: shard::SCHEMA, seed: 9, runs, fault: None, sequence: None }
}

#[test]
fn joined_shards_are_the_whole_byte_for_byte() {
    let part = |shard: Option<Shard>| {
        let campaign = campaign(40);
        let result = run_all::<Controller>(&campaign, shard.unwrap_or(Shard::WHOLE), &ProgressBar::hidden());
        Part { campaign, shard, result }
    };
    let whole = part(None);
    let shards: Vec<_> = [3, 1, 2]
        .map(|number| part(Some(Shard { number, of: 3 })))
        .iter()
        .map(|part| ("a shard".to_owned(), part.json().expect("JSON")))
        .collect();
    let joined = shard::merge(&shards).expect("all there");
    assert_eq!(joined, whole);
    assert_eq!(joined.json().expect("JSON"), whole.json().expect("JSON"));
    assert!(whole.result.fault_free_ms > 0 && !whole.result.matrix.is_empty());
    // And drawn, they are the same pictures and tables.
    assert_eq!(picture(&joined).expect("draws"), picture(&whole).expect("draws"));
    assert_eq!(text(&joined), text(&whole));
}

#[test]
fn a_run_made_again_is_the_same_run() {
    let filter = Filter::default();
    for index in 0..12 {
        let case = Case::draw(9, index, &filter);
        let outcome = run_one::<Controller>(&case);
        let (again, trace) = replay::replay(&Case::draw(9, index, &filter), 9);
        assert_eq!(format!("{outcome:?}"), format!("{again:?}"));
        assert_eq!(trace.samples.len(), outcome.simulated_ms as usize);
        let told = replay::text(&case, &outcome);
        for fault in &case.faults {
            assert!(told.contains(&fault.kind.name()), "{told}");
        }
    }
}

/// How a broken controller goes wrong.
trait Flaw {
    /// What it lets the controller see.
    fn blind(_: &mut Inputs) {}
    /// What it makes of the controller's outputs.
    fn spoil(outputs: &mut Outputs, ticks: u32);
}

/// The core with a flaw.
struct Broken<F> {
    core: Controller,
    ticks: u32,
    flaw: core::marker::PhantomData<F>,
}

impl<F: Flaw> Core for Broken<F> {
    fn start(calibration: PerSegment<Coefficients>, report: Option<Fault>) -> Self {
        Self { core: Core::start(calibration, report), ticks: 0, flaw: core::marker::PhantomData }
    }

    fn command(&mut self, command: Command) -> bool {
        self.core.command(command).is_ok()
    }

    fn step(&mut self, inputs: &Inputs) -> Outputs {
        let mut inputs = *inputs;
        F::blind(&mut inputs);
        let mut outputs = self.core.step(&inputs);
        self.ticks += 1;
        F::spoil(&mut outputs, self.ticks);
        outputs
    }
}

/// Everything that goes on in runs with an emergency stop.
fn outcomes<C: Core>() -> Vec<Outcome> {
    let all = Choice::find("all").expect("built in");
    let filter = Filter { fault: Some(Kind::EmergencyStop), program: Some(all) };
    (0..12).map(|index| run_one::<C>(&Case::draw(4, index, &filter))).collect()
}

fn broken(outcomes: &[Outcome], property: Property) -> bool {
    outcomes.iter().any(|outcome| outcome.violations.iter().any(|(violated, _)| *violated == property))
}

#[test]
fn the_core_breaks_nothing_when_the_emergency_stop_is_pressed() {
    let outcomes = outcomes::<Controller>();
    let alone = outcomes.iter().filter(|outcome| outcome.fates.len() == 1);
    for outcome in alone {
        assert!(outcome.violations.is_empty() && outcome.false_alarm.is_none(), "{outcome:?}");
        assert_eq!(outcome.fates[0].ending, Ending::Detected { latency_ms: 0 });
    }
}

#[test]
fn a_supervisor_that_sees_nothing_is_caught() {
    struct Deaf;
    impl Flaw for Deaf {
        fn blind(inputs: &mut Inputs) {
            inputs.emergency_stop = false;
        }
        fn spoil(_: &mut Outputs, _: u32) {}
    }
    let outcomes = outcomes::<Broken<Deaf>>();
    assert!(broken(&outcomes, Property::Detection));
    assert!(!broken(&outcomes, Property::Panic));
}

#[test]
fn a_supervisor_that_tells_and_does_not_vent_is_caught() {
    struct Stubborn;
    impl Flaw for Stubborn {
        fn spoil(outputs: &mut Outputs, _: u32) {
            if outputs.faults.intersects(FaultSet::VENTING) {
                outputs.actuation = Actuation::HOLD;
            }
        }
    }
    let outcomes = outcomes::<Broken<Stubborn>>();
    assert!(broken(&outcomes, Property::VentTime) && broken(&outcomes, Property::Energised));
}

#[test]
fn a_supervisor_that_vents_too_slowly_is_caught() {
    struct Slow;
    impl Flaw for Slow {
        fn spoil(outputs: &mut Outputs, ticks: u32) {
            // Open one tick in forty: the dead times swallow it.
            if matches!(outputs.mode, Mode::Faulted(_)) && ticks % 80 < 40 {
                outputs.actuation = Actuation::HOLD;
            }
        }
    }
    assert!(broken(&outcomes::<Broken<Slow>>(), Property::VentTime));
}

#[test]
fn a_controller_that_fills_without_end_is_caught() {
    struct Greedy;
    impl Flaw for Greedy {
        fn blind(inputs: &mut Inputs) {
            (inputs.over_pressure_switch, inputs.emergency_stop) = (false, false);
        }
        fn spoil(outputs: &mut Outputs, _: u32) {
            outputs.actuation = Actuation { pump: true, dump: Passage::Closed, segments: [Passage::Open; 3] };
            (outputs.faults, outputs.mode) = (FaultSet::EMPTY, Mode::Vented);
        }
    }
    assert!(broken(&outcomes::<Broken<Greedy>>(), Property::OverPressure));
}

#[test]
fn a_pump_that_starts_after_the_emergency_stop_is_caught() {
    struct Restless;
    impl Flaw for Restless {
        fn spoil(outputs: &mut Outputs, ticks: u32) {
            if matches!(outputs.mode, Mode::Faulted(_)) && ticks % 1000 < 5 {
                outputs.actuation.pump = true;
            }
        }
    }
    let outcomes = outcomes::<Broken<Restless>>();
    assert!(broken(&outcomes, Property::Energised));
}

#[test]
fn a_controller_that_panics_is_caught_and_the_others_run_on() {
    struct Fragile;
    impl Flaw for Fragile {
        fn spoil(_: &mut Outputs, ticks: u32) {
            assert!(ticks != 5000, "five seconds are enough");
        }
    }
    let outcomes = outcomes::<Broken<Fragile>>();
    assert!(broken(&outcomes, Property::Panic));
    assert!(outcomes.iter().any(|outcome| outcome.simulated_ms > 0));
}

#[test]
fn a_nervous_supervisor_is_counted() {
    struct Nervous;
    impl Flaw for Nervous {
        fn spoil(outputs: &mut Outputs, ticks: u32) {
            if ticks > 1000 {
                outputs.faults.insert(Fault::PressureRate);
            }
        }
    }
    let none = Filter { fault: None, program: Choice::find("all").ok() };
    let mut tally = Tally::new();
    for index in 0..20 {
        let case = Case::draw(4, index, &none);
        tally.count(&case, &run_one::<Broken<Nervous>>(&case));
    }
    assert!(tally.false_alarms.get("pressure-rate").is_some_and(|&count| count > 5), "{tally:?}");
    // A second each.
    assert!(tally.fault_free_ms <= 20 * 1001, "{tally:?}");
}
