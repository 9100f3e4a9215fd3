//! The supervisor in closed loop: no alarm on any plant within the spread it must bear, and every fault found in time.
//!
//! `SUPERVISOR_ROUNDS=20 cargo test --release -p finger-tests --test supervisor -- --nocapture` looks longer and prints the
//! times; the statistics proper are `host-sim campaign`'s.

use host_sim::plant::{FaultKind, InjectedFault, Plant, PlantParameters, Scene};
use model_core::actuation::{Passage, Segment};
use model_core::calibration;
use model_core::controller::{Command, Controller, Fault, Mode, Outputs};
use model_core::sequence::{Sequence, library};

/// Numbers from a seed, 0..1.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 31)
    }

    /// Half and double are as likely.
    fn factor(&mut self, low: f64, high: f64) -> f64 {
        (low.ln() + self.unit() * (high / low).ln()).exp()
    }
}

/// A plant that the supervisor must bear without an alarm.
fn plant(seed: u64) -> PlantParameters {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    (0..5).for_each(|_| _ = random.unit());
    let mut plant = PlantParameters::default();
    plant.pump.free_flow_nl_per_min *= random.factor(0.5, 1.3);
    plant.finger.chamber_ml *= random.factor(0.7, 2.0);
    plant.finger.lag_ms *= random.factor(0.5, 2.0);
    let mut delayed = |ms: u32| (f64::from(ms) * random.factor(0.5, 2.0)).round() as u32;
    plant.pump.dead_time_ms = delayed(plant.pump.dead_time_ms);
    plant.segment_valve.dead_time_ms = delayed(plant.segment_valve.dead_time_ms);
    plant.dump_valve.dead_time_ms = delayed(plant.dump_valve.dead_time_ms);
    plant.segment_valve.conductance_nl_per_s_bar *= random.factor(0.7, 1.4);
    plant.dump_valve.conductance_nl_per_s_bar *= random.factor(0.7, 1.4);
    for [_, c1, c2] in &mut plant.finger.coefficients_kpa {
        *c1 *= random.factor(0.93, 1.07);
        *c2 *= random.factor(0.93, 1.07);
    }
    plant
}

/// Ticks before the sequence starts: the zero is trimmed.
const STANDBY: u32 = 1000;

struct Run {
    controller: Controller,
    plant: Plant,
    ticks: u32,
    peak_kpa: f64,
}

impl Run {
    fn new(seed: u64, sequence: &'static Sequence, faults: &[InjectedFault]) -> Self {
        let plant = Plant::new(plant(seed), Scene::default().with_faults(faults.iter().copied()), seed);
        let mut run = Self { controller: Controller::new([calibration::DEFAULT; 3]), plant, ticks: 0, peak_kpa: 0.0 };
        (0..STANDBY).for_each(|_| _ = run.step());
        let _ = run.controller.command(Command::Run(sequence));
        run
    }

    fn step(&mut self) -> Outputs {
        let outputs = self.controller.step(&self.plant.inputs());
        self.plant.step(&outputs.actuation);
        self.ticks += 1;
        let highest = self.plant.truth().chambers_kpa.into_iter().fold(0.0, f64::max);
        self.peak_kpa = self.peak_kpa.max(highest);
        outputs
    }
}

fn rounds() -> u64 {
    std::env::var("SUPERVISOR_ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(1)
}

#[test]
fn no_alarm_on_a_sound_machine() {
    let (mut ticks, mut alarms) = (0_u64, vec![]);
    for round in 0..rounds() {
        for (index, sequence) in library::ALL.into_iter().enumerate() {
            let seed = 1 + round * 100 + index as u64;
            let mut run = Run::new(seed, sequence, &[]);
            for _ in 0..sequence.duration().0 + 4000 {
                let outputs = run.step();
                if !outputs.faults.is_empty() {
                    let faults: Vec<_> = outputs.faults.iter().collect();
                    alarms.push(format!("{}, seed {seed}, {} ms: {faults:?}", sequence.name, run.ticks));
                    break;
                }
            }
            ticks += u64::from(run.ticks);
        }
    }
    println!("{:.2} h without a fault, {} alarms", ticks as f64 / 3.6e6, alarms.len());
    assert!(alarms.is_empty(), "{}", alarms.join("\n"));
}

/// What breaks, what it may be called, and within how many ms from when it breaks in mid-sequence.
fn cases() -> Vec<(FaultKind, Vec<Fault>, u32)> {
    use FaultKind as K;
    let valve = |segment, passage| K::SegmentValveStuck(segment, passage);
    let leak = |conductance_nl_per_s_bar| K::ChamberLeak { segment: Segment::Middle, conductance_nl_per_s_bar };
    vec![
        (K::PressureSensorOpen, vec![Fault::PressureSensorBelowRange], 10),
        (K::PressureSensorShort, vec![Fault::PressureSensorAboveRange], 10),
        (K::PressureSensorNoisy { times: 10.0 }, vec![Fault::PressureSensorNoisy], 200),
        (K::PressureSensorFrozen, vec![Fault::PressureSensorStuck], 12_000),
        (K::PressureSwitchStuck(true), vec![Fault::OverPressureSwitch, Fault::SwitchDisagrees], 5000),
        (K::BendSensorOpen, vec![Fault::BendSensorFailed], 10),
        (K::BendSensorShort, vec![Fault::BendSensorFailed], 10),
        (K::BendSensorFrozen, vec![Fault::BendSensorFailed], 12_000),
        (K::EmergencyStop, vec![Fault::EmergencyStop], 1),
        (K::PumpStuckOn, vec![Fault::PumpStuckOn], 5000),
        (K::PumpDead, vec![Fault::PumpNotDelivering], 12_000),
        (K::DumpStuck(Passage::Open), vec![Fault::DumpStuckOpen], 12_000),
        (K::DumpStuck(Passage::Closed), vec![Fault::DumpStuckClosed], 12_000),
        (valve(Segment::Middle, Passage::Open), vec![Fault::SegmentValveStuckOpen(Segment::Middle)], 15_000),
        (valve(Segment::Middle, Passage::Closed), vec![Fault::SegmentValveStuckClosed(Segment::Middle)], 15_000),
        (leak(2e-4), vec![Fault::LeakSlow], 20_000),
        (leak(2e-2), vec![Fault::LeakBurst], 12_000),
        (K::FingerBlocked(Segment::Proximal), vec![Fault::BendDisagrees], 12_000),
        (K::FingerPushed { segment: Segment::Distal, degrees: 60.0 }, vec![Fault::BendDisagrees], 1500),
    ]
}

#[test]
fn every_fault_is_found_named_and_vented() {
    let (mut missed, mut unnamed) = (vec![], vec![]);
    for (kind, names, within) in cases() {
        let mut times = vec![];
        let mut told = vec![];
        for round in 0..rounds().max(2) {
            let only = std::env::var("ONLY").unwrap_or_default();
            if !format!("{kind:?}").contains(&only) {
                continue;
            }
            for sequence in ["reconfigure", "all", "wave", "grasp"] {
                let sequence = library::find(sequence).expect("built in");
                let from = STANDBY + 1500 + (round as u32 * 777) % 4000;
                let seed = 1000 + round;
                let mut run = Run::new(seed, sequence, &[InjectedFault::lasting(kind, from)]);
                let (mut first, mut all) = (None, vec![]);
                for _ in 0..from + within + 8000 {
                    let outputs = run.step();
                    if first.is_none() && !outputs.faults.is_empty() {
                        first = Some((run.ticks.saturating_sub(from), outputs.mode));
                    }
                    all = outputs.faults.iter().collect();
                }
                let at = format!("{kind:?}, {}, seed {seed}", sequence.name);
                match first {
                    Some((ms, mode)) if ms <= within => {
                        times.push(ms);
                        told.push(all.clone());
                        if !names.iter().any(|name| all.contains(name)) {
                            unnamed.push(format!("{at}: {all:?}"));
                        }
                        let venting =
                            all.iter().any(|fault| fault.action() == model_core::supervisor::fault::Action::Vent);
                        assert_eq!(venting, matches!(mode, Mode::Faulted(_)) || venting, "{at}");
                    }
                    other => missed.push(format!("{at}: {other:?}")),
                }
                assert!(run.peak_kpa < 165.0, "{at}: {} kPa", run.peak_kpa);
            }
        }
        times.sort_unstable();
        let mid = times.get(times.len() / 2);
        println!("{kind:?}: {} found, median {mid:?} ms, last {:?} ms", times.len(), times.last());
    }
    println!("not named:\n{}", unnamed.join("\n"));
    assert!(missed.is_empty(), "missed:\n{}", missed.join("\n"));
}
