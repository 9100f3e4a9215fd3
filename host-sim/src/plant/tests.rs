use super::*;

const FILL: Actuation = Actuation { pump: true, dump: Passage::Closed, segments: [Passage::Open; 3] };
const EQUALISE: Actuation = Actuation { pump: false, ..FILL };
const FILL_ONE: Actuation =
    Actuation { pump: true, dump: Passage::Closed, segments: [Passage::Open, Passage::Closed, Passage::Closed] };

fn plant(scene: Scene) -> Plant {
    Plant::new(PlantParameters::default(), scene, 1)
}

fn run(plant: &mut Plant, actuation: Actuation, ticks: u32) {
    for _ in 0..ticks {
        plant.step(&actuation);
    }
}

/// Steps until `done`, at most 20 s; returns the ticks it took.
fn run_until(plant: &mut Plant, actuation: Actuation, done: impl Fn(&Truth) -> bool) -> u32 {
    (1..=20_000)
        .find(|_| {
            plant.step(&actuation);
            done(&plant.truth())
        })
        .expect("within 20 s")
}

#[test]
fn starts_vented_at_rest() {
    let plant = plant(Scene::ideal());
    let truth = plant.truth();
    assert!(truth.manifold_kpa.abs() < 1e-12 && truth.chambers_kpa.iter().all(|kpa| kpa.abs() < 1e-12));
    assert_eq!(plant.inputs().now, Millis::ZERO);
    assert_eq!(plant.inputs().manifold, Reading::Valid(model_core::units::Pressure::ZERO));
    // 5 mL and three times 6.786 mL at 101.325 kPa, in litres at 100 kPa.
    assert!((truth.content_nl - 0.025_358 * 1.013_25).abs() < 1e-12);
}

#[test]
fn nothing_moves_while_vented() {
    let mut plant = plant(Scene::default());
    run(&mut plant, Actuation::SAFE, 2000);
    let truth = plant.truth();
    assert!(truth.manifold_kpa.abs() < 1e-9 && truth.bends_deg.iter().all(|deg| deg.abs() < 1e-3), "{truth:?}");
}

#[test]
fn a_closed_system_keeps_its_air() {
    let mut plant = plant(Scene::default());
    run(&mut plant, FILL_ONE, 600);
    run(&mut plant, EQUALISE, 300);
    let before = plant.truth();
    // One chamber's air spreads over all three, and the others bend.
    run(&mut plant, EQUALISE, 5000);
    let after = plant.truth();
    assert!((before.content_nl - after.content_nl).abs() < 1e-12, "{before:?} {after:?}");
    let spread = after.chambers_kpa[0] - after.chambers_kpa[2];
    assert!(after.chambers_kpa[2] > 20.0 && spread.abs() < 1e-6, "{after:?}");
}

#[test]
fn the_air_that_comes_in_is_what_the_pump_gave() {
    let mut plant = plant(Scene::ideal());
    plant.step(&EQUALISE);
    let start = plant.truth().content_nl;
    let mut pumped = 0.0;
    let mut last = 0.05;
    for _ in 0..1000 {
        plant.step(&FILL);
        let flow = plant.truth().pump_flow_nl_per_s;
        pumped += 0.5e-3 * (flow + last);
        last = flow;
    }
    let gained = plant.truth().content_nl - start;
    assert!((gained / pumped - 1.0).abs() < 1e-4, "{gained} {pumped}");
}

#[test]
fn fill_and_vent_times() {
    for (name, fill) in [("three chambers", FILL), ("one chamber", FILL_ONE)] {
        let mut plant = plant(Scene::default());
        let fill_ms = run_until(&mut plant, fill, |truth| truth.chambers_kpa[0] >= 150.0);
        let manifold = plant.truth().manifold_kpa;
        run(&mut plant, Actuation { pump: false, dump: Passage::Closed, ..fill }, 500);
        let rested = plant.truth();
        let vent_ms = run_until(&mut plant, Actuation::SAFE, |truth| truth.chambers_kpa.iter().all(|&kpa| kpa < 5.0));
        println!(
            "{name}: 150 kPa after {fill_ms} ms, manifold then {manifold:.2} kPa; rested 0.5 s: {:.2} kPa, \
             {:.1} deg; vented below 5 kPa after {vent_ms} ms",
            rested.chambers_kpa[0], rested.bends_deg[0]
        );
        assert!(vent_ms < 6000);
        assert!(manifold > 150.0);
    }
}

#[test]
fn equalised_volumes_do_not_chatter() {
    for scene in [Scene::default(), Scene::ideal()] {
        for fill_ms in [0, 30, 100, 1500] {
            let mut plant = plant(scene.clone());
            run(&mut plant, FILL, fill_ms);
            run(&mut plant, EQUALISE, 3000);
            let mut last = plant.truth();
            for _ in 0..1000 {
                plant.step(&EQUALISE);
                let truth = plant.truth();
                for (now, before) in truth.chambers_kpa.iter().zip(&last.chambers_kpa) {
                    assert!((now - before).abs() < 1e-6, "{fill_ms} ms: {last:?} {truth:?}");
                }
                assert!((truth.manifold_kpa - truth.chambers_kpa[0]).abs() < 1e-6);
                last = truth;
            }
        }
    }
}

#[test]
fn dead_times_are_exact() {
    let mut plant = plant(Scene::default());
    for tick in 0..10 {
        plant.step(&FILL_ONE);
        let truth = plant.truth();
        assert_eq!((truth.dump, truth.segments), (Passage::Open, [Passage::Open; 3]), "{tick}");
        assert!(truth.pump_speed <= 0.0);
    }
    plant.step(&FILL_ONE);
    let truth = plant.truth();
    assert_eq!((truth.dump, truth.segments), (Passage::Closed, FILL_ONE.segments));
    assert!(truth.pump_speed > 0.0);
}

#[test]
fn finer_sub_steps_change_little() {
    let run_with = |sub_steps| {
        let mut parameters = PlantParameters::default();
        parameters.integration.sub_steps = sub_steps;
        let mut plant = Plant::new(parameters, Scene::default(), 1);
        let mut trace = Vec::new();
        for (actuation, ticks) in [
            (FILL_ONE, 300),
            (FILL, 400),
            (Actuation::HOLD, 50),
            (Actuation { segments: FILL_ONE.segments, ..Actuation::SAFE }, 60),
            (EQUALISE, 100),
            (FILL, 900),
            (Actuation::SAFE, 1500),
        ] {
            for _ in 0..ticks {
                plant.step(&actuation);
                let truth = plant.truth();
                let [a, b, c] = truth.chambers_kpa;
                trace.push([truth.manifold_kpa, a, b, c]);
            }
        }
        trace
    };
    let fine = run_with(200);
    for (sub_steps, allowed) in [(5, 0.01), (10, 0.003), (20, 0.001)] {
        let worst = run_with(sub_steps)
            .iter()
            .flatten()
            .zip(fine.iter().flatten())
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        println!("{sub_steps} sub-steps: {worst:.6} kPa from 200");
        assert!(worst < allowed, "{sub_steps}: {worst}");
    }
}

#[test]
fn a_seed_repeats_itself_and_another_differs() {
    let readings = |seed| {
        let mut plant = Plant::new(PlantParameters::default(), Scene::default(), seed);
        (0..500).map(|_| plant.step(&FILL)).collect::<Vec<_>>()
    };
    assert_eq!(readings(7), readings(7));
    assert_ne!(readings(7), readings(8));
}

#[test]
fn noise_has_its_figure_and_errors_stay_apart_from_the_truth() {
    let mut noisy = plant(Scene::default());
    let mut quiet = plant(Scene { sensor_errors: Part::LeftOut, ..Scene::default() });
    let mut differences = Vec::new();
    for _ in 0..5000 {
        let (Reading::Valid(a), Reading::Valid(b)) = (noisy.step(&FILL).manifold, quiet.step(&FILL).manifold) else {
            panic!("both sensors are well");
        };
        differences.push(a.to_f64() - b.to_f64());
        assert_eq!(noisy.truth(), quiet.truth());
    }
    let mean = differences.iter().sum::<f64>() / 5000.0;
    let rms = (differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 5000.0).sqrt();
    // 0.3 kPa, and the quiet sensor's undithered steps of 0.305 / sqrt(12) = 0.088 kPa at most.
    assert!((0.28..0.34).contains(&rms) && mean.abs() < 1.5, "{mean} {rms}");
}

#[test]
fn the_switch_closes_at_its_threshold() {
    let mut plant = plant(Scene::ideal());
    for _ in 0..4000 {
        let inputs = plant.step(&FILL);
        assert_eq!(
            inputs.over_pressure_switch,
            plant.truth().manifold_kpa >= PlantParameters::default().pressure_sensor.switch_kpa
        );
    }
    assert!(plant.inputs().over_pressure_switch);
}

#[test]
fn faults_do_what_they_say() {
    let faulted = |kind| plant(Scene::ideal().with_faults([InjectedFault::lasting(kind, 100)]));

    let mut wire =
        plant(Scene::default().with_faults([InjectedFault::passing(FaultKind::PressureSensorOpen, 100, 200)]));
    for _ in 0..300 {
        let inputs = wire.step(&FILL);
        let broken = (100..200).contains(&inputs.now.0);
        assert_eq!(inputs.manifold == Reading::BelowRange, broken, "{inputs:?}");
    }

    let mut short = faulted(FaultKind::PressureSensorShort);
    run(&mut short, FILL, 100);
    assert_eq!(short.inputs().manifold, Reading::AboveRange);

    let mut bend = faulted(FaultKind::BendSensorOpen);
    run(&mut bend, FILL, 100);
    assert_eq!(bend.inputs().bend, Reading::BelowRange);

    let mut stop = faulted(FaultKind::EmergencyStop);
    run(&mut stop, FILL, 99);
    assert!(!stop.inputs().emergency_stop);
    assert!(stop.step(&FILL).emergency_stop);

    let mut pump = faulted(FaultKind::PumpStuckOn);
    run(&mut pump, Actuation::HOLD, 1100);
    assert!(pump.truth().manifold_kpa > 200.0);

    let mut dead = faulted(FaultKind::PumpDead);
    run(&mut dead, FILL, 101);
    assert!(dead.truth().pump_flow_nl_per_s <= 0.0);

    let mut stuck_open = faulted(FaultKind::SegmentValveStuck(Segment::Middle, Passage::Open));
    run(&mut stuck_open, FILL_ONE, 1000);
    let [open, middle, closed] = stuck_open.truth().chambers_kpa;
    assert!(open > 50.0 && middle > 50.0 && closed.abs() < 1e-9);

    let mut stuck_closed = faulted(FaultKind::SegmentValveStuck(Segment::Distal, Passage::Closed));
    run(&mut stuck_closed, FILL, 1000);
    run(&mut stuck_closed, Actuation::SAFE, 3000);
    let [_, vented, held] = stuck_closed.truth().chambers_kpa;
    assert!(vented < 1.0 && held > 1.0);

    let mut dump_closed = faulted(FaultKind::DumpStuck(Passage::Closed));
    run(&mut dump_closed, FILL, 1000);
    run(&mut dump_closed, Actuation::SAFE, 3000);
    assert!(dump_closed.truth().manifold_kpa > 50.0);

    let mut dump_open = faulted(FaultKind::DumpStuck(Passage::Open));
    run(&mut dump_open, FILL, 3000);
    assert!(dump_open.truth().chambers_kpa[0] < 100.0);

    // A leak of 1e-4 NL/(s bar) from a held chamber is choked above 236 kPa gauge only; its start is subsonic.
    let leak = FaultKind::ChamberLeak { segment: Segment::Proximal, conductance_nl_per_s_bar: 1e-4 };
    let mut leaking = faulted(leak);
    run(&mut leaking, FILL, 1000);
    run(&mut leaking, Actuation::HOLD, 1);
    let before = leaking.truth();
    assert!(before.leak_flows_nl_per_s[0] > 1e-4);
    run(&mut leaking, Actuation::HOLD, 1000);
    let after = leaking.truth();
    let lost = before.content_nl - after.content_nl;
    let mean = 0.5 * (before.leak_flows_nl_per_s[0] + after.leak_flows_nl_per_s[0]);
    assert!((lost / mean - 1.0).abs() < 1e-3, "{lost} {mean}");
    assert!((before.chambers_kpa[1] - after.chambers_kpa[1]).abs() < 1e-6);
}

/// The plant as it is, with this fault from 1 s on; the sensors without errors when `ideal`.
fn broken(kind: FaultKind, ideal: bool) -> Plant {
    let scene = if ideal { Scene::ideal() } else { Scene::default() };
    plant(scene.with_faults([InjectedFault::lasting(kind, 1000)]))
}

#[test]
fn a_frozen_sensor_keeps_the_converters_noise_and_a_noisy_one_its_mean() {
    let readings = |kind: FaultKind| {
        let mut plant = broken(kind, false);
        run(&mut plant, FILL, 1000);
        let at = plant.truth().manifold_kpa;
        let readings: Vec<f64> =
            (0..2000).map(|_| plant.step(&Actuation::HOLD).manifold.valid().expect("in range").to_f64()).collect();
        let mean = readings.iter().sum::<f64>() / 2000.0;
        let rms = (readings.iter().map(|kpa| (kpa - mean).powi(2)).sum::<f64>() / 2000.0).sqrt();
        (at, plant.truth().manifold_kpa, mean, rms)
    };
    let (at, now, mean, rms) = readings(FaultKind::PressureSensorFrozen);
    assert!((mean - at).abs() < 2.0 && (now - at).abs() > 5.0, "{at} {now} {mean}");
    assert!((0.04..0.06).contains(&rms), "{rms}");
    let (_, now, mean, rms) = readings(FaultKind::PressureSensorNoisy { times: 10.0 });
    assert!((mean - now).abs() < 3.0 && (2.0..4.5).contains(&rms), "{now} {mean} {rms}");
}

#[test]
fn a_stuck_switch_says_the_same_at_every_pressure() {
    for closed in [false, true] {
        let mut plant = broken(FaultKind::PressureSwitchStuck(closed), true);
        run(&mut plant, Actuation::SAFE, 999);
        assert!(!plant.inputs().over_pressure_switch);
        for _ in 0..4000 {
            assert_eq!(plant.step(&FILL).over_pressure_switch, closed);
        }
        assert!(plant.truth().manifold_kpa > PlantParameters::default().pressure_sensor.switch_kpa);
    }
}

#[test]
fn a_weak_pump_gives_its_share_and_no_other() {
    let mut weak = broken(FaultKind::PumpWeak { share: 0.25 }, true);
    let mut whole = plant(Scene::ideal());
    run(&mut weak, Actuation::SAFE, 1000);
    run(&mut whole, Actuation::SAFE, 1000);
    run(&mut weak, FILL, 1);
    run(&mut whole, FILL, 1);
    let share = weak.truth().pump_flow_nl_per_s / whole.truth().pump_flow_nl_per_s;
    assert!((share - 0.25).abs() < 0.01, "{share}");
    // Its relay may stick as well: both act.
    let faults = [FaultKind::PumpStuckOn, FaultKind::PumpWeak { share: 0.5 }];
    let mut both = plant(Scene::ideal().with_faults(faults.map(|kind| InjectedFault::lasting(kind, 0))));
    run(&mut both, Actuation::SAFE, 1);
    assert!((both.truth().pump_flow_nl_per_s - 0.5 * 3.0 / 60.0).abs() < 0.005);
}

#[test]
fn a_bend_sensor_is_shorted_or_stands_still() {
    let mut short = broken(FaultKind::BendSensorShort, true);
    run(&mut short, FILL, 1000);
    assert_eq!(short.inputs().bend, Reading::AboveRange);
    let mut frozen = broken(FaultKind::BendSensorFrozen, true);
    run(&mut frozen, FILL, 999);
    let before = frozen.inputs().bend;
    run(&mut frozen, FILL, 1000);
    let Reading::Valid(bend) = frozen.inputs().bend else { panic!("in range") };
    assert!((bend.to_f64() - before.valid().expect("in range").to_f64()).abs() <= 0.1);
    assert!(frozen.truth().bends_deg.iter().sum::<f64>() > bend.to_f64() + 10.0);
}

#[test]
fn a_blocked_segment_bends_no_further_and_straightens_freely() {
    let mut free = plant(Scene::default());
    let mut blocked = broken(FaultKind::FingerBlocked(Segment::Middle), false);
    for plant in [&mut free, &mut blocked] {
        run(plant, FILL, 1000);
    }
    let [_, at, _] = blocked.truth().bends_deg;
    for plant in [&mut free, &mut blocked] {
        run(plant, FILL, 700);
        run(plant, Actuation::HOLD, 500);
    }
    let (free, held) = (free.truth(), blocked.truth());
    assert!((held.bends_deg[1] - at).abs() < 0.5, "{at} {held:?}");
    assert!(free.bends_deg[1] - held.bends_deg[1] > 10.0);
    // What its pressure, now higher, would bend it to is what the truth says it is held off.
    assert!((held.bends_deg[1] - held.forced_deg[1] - free.bends_deg[1]).abs() < 6.0 && held.forced_deg[1] < -10.0);
    assert!((held.bends_deg[0] - free.bends_deg[0]).abs() < 1.0 && held.forced_deg[0].abs() <= 0.0);
    run(&mut blocked, Actuation::SAFE, 4000);
    let vented = blocked.truth();
    assert!(vented.bends_deg[1] < 2.0 && vented.forced_deg[1].abs() <= 0.0, "{vented:?}");
}

#[test]
fn a_push_moves_a_segment_within_its_time_and_its_closed_chamber_feels_it() {
    let push = FaultKind::FingerPushed { segment: Segment::Distal, degrees: -30.0 };
    let mut held = plant(Scene::default().with_faults([InjectedFault::passing(push, 2000, 3000)]));
    run(&mut held, FILL, 1200);
    run(&mut held, Actuation::HOLD, 800);
    let before = held.truth();
    run(&mut held, Actuation::HOLD, 50);
    assert!((held.truth().forced_deg[2] + 15.0).abs() < 0.01, "{:?}", held.truth());
    run(&mut held, Actuation::HOLD, 250);
    let pushed = held.truth();
    assert!((pushed.forced_deg[2] + 30.0).abs() < 1e-9);
    // Its chamber is smaller: the pressure rises, and with it the bend that it would have.
    assert!(pushed.chambers_kpa[2] > before.chambers_kpa[2] + 3.0);
    assert!(pushed.bends_deg[2] < before.bends_deg[2] - 25.0);
    assert!((pushed.content_nl - before.content_nl).abs() < 1e-12, "no air is made");
    run(&mut held, Actuation::HOLD, 1500);
    let after = held.truth();
    assert!((after.bends_deg[2] - before.bends_deg[2]).abs() < 1.0 && after.forced_deg[2].abs() <= 0.0);
    // A straight segment is not pushed through its end.
    let mut straight = plant(Scene::ideal().with_faults([InjectedFault::lasting(push, 0)]));
    run(&mut straight, Actuation::SAFE, 300);
    assert!(straight.truth().bends_deg[2].abs() <= 0.0);
}

#[test]
fn of_two_faults_on_one_part_the_last_listed_counts() {
    let lasting = |kind| InjectedFault::lasting(kind, 0);
    let both = |faults: [FaultKind; 2]| {
        let mut plant = plant(Scene::ideal().with_faults(faults.map(lasting)));
        run(&mut plant, FILL, 20);
        plant
    };
    let plant = both([FaultKind::PressureSensorShort, FaultKind::PressureSensorOpen]);
    assert_eq!(plant.inputs().manifold, Reading::BelowRange);
    let plant = both([FaultKind::PumpStuckOn, FaultKind::PumpDead]);
    assert!(plant.truth().pump_speed <= 0.0);
    let plant = both([FaultKind::DumpStuck(Passage::Open), FaultKind::DumpStuck(Passage::Closed)]);
    assert_eq!(plant.truth().dump, Passage::Closed);
    // Different parts: both are there.
    let plant = both([FaultKind::BendSensorShort, FaultKind::PressureSwitchStuck(true)]);
    assert_eq!((plant.inputs().bend, plant.inputs().over_pressure_switch), (Reading::AboveRange, true));
}
