use super::*;
use crate::plant::{InjectedFault, PlantParameters};
use model_core::actuation::{Actuation, Passage};

const FIXED: [Method; 6] = [
    Method::Euler,
    Method::Heun,
    Method::RungeKutta4,
    Method::RosenbrockEuler,
    Method::LinearlyImplicitMidpoint,
    Method::Rosenbrock2,
];

fn replay(case: &Case, method: Method, sub_steps: u32) -> case::Outcome {
    case.replay(case.plant(method, sub_steps, Scene::default(), SEED))
}

#[test]
fn the_default_is_within_its_target_in_the_default_scene() {
    let scene = case::default_scene().expect("solved");
    let default = Choice::of_the_plant();
    let outcome = replay(&scene, default.method, default.sub_steps);
    println!("{outcome:?}");
    assert!(outcome.max_error_kpa <= ERROR_TARGET_KPA, "{outcome:?}");
    assert!(outcome.rms_error_kpa <= 0.01 && outcome.max_bend_error_deg <= 0.1, "{outcome:?}");
    // No more than one step of two evaluations a tick.
    assert!(outcome.evaluations_per_tick <= 2.0, "{outcome:?}");
}

#[test]
fn the_default_takes_every_stiff_case() {
    let default = Choice::of_the_plant();
    for case in case::stiff_cases().expect("solved") {
        let outcome = replay(&case, default.method, default.sub_steps);
        println!("{}: {outcome:?}", case.name);
        assert!(outcome.late_error_kpa <= ERROR_TARGET_KPA, "{}: {outcome:?}", case.name);
        // While a chamber bursts or a tiny manifold swings, a millisecond is long: see docs/simulator.md.
        assert!(outcome.max_error_kpa <= 0.5, "{}: {outcome:?}", case.name);
        assert!(outcome.max_content_error_nl <= 1e-4, "{}: {outcome:?}", case.name);
    }
}

#[test]
fn a_closed_system_keeps_its_air_with_every_choice() {
    for choice in choices() {
        let drift = case::closed_drift_nl(choice.method, choice.sub_steps);
        assert!(drift < 1e-14, "{choice:?}: {drift:e} NL");
    }
}

/// Air flows over from one chamber to the others, with fixed volumes and no pump: nothing but the method errs.
fn flow_over(choice: Choice) -> [f64; 3] {
    let mut parameters = PlantParameters::default();
    parameters.integration.method = choice.method;
    parameters.integration.sub_steps = choice.sub_steps;
    let scene = Scene { volume_growth: Part::LeftOut, actuator_delays: Part::LeftOut, ..Scene::default() };
    let mut plant = Plant::new(parameters, scene, SEED).starting_at(40.0, [100.0, 0.0, 20.0]);
    let command = Actuation { pump: false, dump: Passage::Closed, segments: [Passage::Open; 3] };
    // It ends before the pressures meet: the laminar zone's edge is a kink, which no method's order survives.
    for _ in 0..16 {
        plant.step(&command);
    }
    plant.truth().chambers_kpa
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn each_method_has_its_order() {
    let exact = flow_over(Choice { method: Method::RungeKutta4, sub_steps: 256 });
    for (method, order) in FIXED.into_iter().zip([1.0, 2.0, 4.0, 1.0, 2.0, 2.0]) {
        let error = |sub_steps| distance(flow_over(Choice { method, sub_steps }), exact);
        let (coarse, fine) = (error(2), error(8));
        let observed = (coarse / fine).log2() / 2.0;
        println!("{method:?}: {coarse:.2e} kPa, {fine:.2e} kPa, order {observed:.2}");
        assert!((observed - order).abs() < 0.35, "{method:?}: {coarse:e} {fine:e} {observed}");
    }
    let adaptive =
        |tolerance_kpa| distance(flow_over(Choice { method: Method::Adaptive { tolerance_kpa }, sub_steps: 1 }), exact);
    let errors = [1e-6, 1e-8, 1e-10].map(adaptive);
    println!("adaptive: {errors:?}");
    assert!(errors[1] < 0.1 * errors[0] && errors[2] < 0.1 * errors[1], "{errors:?}");
}

/// The whole plant, pump, bends and all, against the reference: gas and finger take turns, and that is of second order.
#[test]
fn the_whole_plant_is_of_second_order() {
    let open_one = [Passage::Open, Passage::Closed, Passage::Closed];
    let commands = vec![Actuation { pump: true, dump: Passage::Closed, segments: open_one }; 60];
    let mut parameters = PlantParameters::default();
    (parameters.pump.dead_time_ms, parameters.segment_valve.dead_time_ms) = (0, 0);
    parameters.dump_valve.dead_time_ms = 0;
    // Air rushes from the manifold into a chamber that bends: no flow law's edge and no P = 0 on the way.
    let start_kpa = [150.0, 30.0, 20.0, 10.0];
    let faults: Vec<InjectedFault> = Vec::new();
    let reference = reference::solve(&parameters, &faults, start_kpa, &commands, 1e-12).expect("solved");
    let case = Case { name: "rushing in", parameters, faults, start_kpa, commands, reference };
    for method in [Method::Heun, Method::RungeKutta4, Method::LinearlyImplicitMidpoint, Method::Rosenbrock2] {
        let [coarse, fine] = [1, 8].map(|sub_steps| replay(&case, method, sub_steps).rms_error_kpa);
        let observed = (coarse / fine).log2() / 3.0;
        println!("{method:?}: {coarse:.2e} kPa, {fine:.2e} kPa, order {observed:.2}");
        assert!((observed - 2.0).abs() < 0.3, "{method:?}: {coarse:e} {fine:e} {observed}");
    }
}

#[test]
fn the_reference_has_converged() {
    for case in case::stiff_cases().expect("solved") {
        let coarse =
            reference::solve(&case.parameters, &case.faults, case.start_kpa, &case.commands, 1e-7).expect("solved");
        let off = coarse
            .iter()
            .zip(&case.reference)
            .map(|(a, b)| distance(a.chambers_kpa, b.chambers_kpa))
            .fold(0.0, f64::max);
        println!("{}: tolerances of 1e-7 and {:e}: {off:.1e} kPa apart", case.name, reference::TOLERANCE);
        assert!(off < 1e-4, "{}: {off:e}", case.name);
    }
}

#[test]
fn same_seed_same_bytes_with_every_method() {
    let command = Actuation { pump: true, dump: Passage::Closed, segments: [Passage::Open; 3] };
    for choice in choices() {
        let readings = |seed| {
            let mut parameters = PlantParameters::default();
            parameters.integration.method = choice.method;
            parameters.integration.sub_steps = choice.sub_steps;
            let mut plant = Plant::new(parameters, Scene::default(), seed);
            (0..200).map(|_| (plant.step(&command), plant.truth())).collect::<Vec<_>>()
        };
        let (one, again, other) = (readings(3), readings(3), readings(4));
        assert!(one == again && one != other, "{choice:?}");
    }
}

#[test]
fn dominated_are_those_that_another_beats() {
    let row = |speed, error| IntegratorRow {
        integrator: "",
        step: String::new(),
        default: false,
        dominated: false,
        max_error_kpa: error,
        rms_error_kpa: error,
        max_bend_error_deg: 0.0,
        evaluations_per_tick: 0.0,
        simulated_seconds_per_second: speed,
        fastest_simulated_seconds_per_second: speed,
        stiff: Vec::new(),
        closed_drift_nl: 0.0,
    };
    let mut rows = [row(10.0, 1.0), row(20.0, 1.0), row(5.0, 0.1), row(4.0, 0.2)];
    mark_dominated(&mut rows);
    assert_eq!(rows.map(|row| row.dominated), [true, false, false, true]);
}
