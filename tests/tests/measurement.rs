//! What the self test measures of a machine, against what the plant was given: a thousand machines of the campaign's spread.
//!
//! `cargo test -p finger-tests --test measurement -- --nocapture` prints the errors.

use host_sim::campaign::draw::{Case, Filter};
use host_sim::plant::{Plant, PlantParameters, Scene};
use model_core::observer::Pneumatics;
use model_core::self_test::{SelfTest, Verdict};
use model_core::units::Pressure;

/// What the plant says of itself, in the core's units: kPa/ms of the manifold alone, volumes of the manifold's.
struct Truth {
    pump_rate: f64,
    valve_rate: f64,
    dump_rate: f64,
    chamber_ratio: f64,
    coming_ms: f64,
    /// A multiple of the nominal.
    growth: f64,
}

impl Truth {
    fn of(plant: &PlantParameters) -> Self {
        // A normal litre is of 100 kPa and 20 degrees, at which the machine stands.
        let per_manifold = |nl_per_s: f64| nl_per_s * 100.0 / plant.gas.manifold_ml;
        Self {
            pump_rate: per_manifold(plant.pump.free_flow_nl_per_min / 60.0),
            valve_rate: per_manifold(plant.segment_valve.conductance_nl_per_s_bar / 100.0),
            dump_rate: per_manifold(plant.dump_valve.conductance_nl_per_s_bar / 100.0),
            chamber_ratio: plant.finger.chamber_ml / plant.gas.manifold_ml,
            coming_ms: f64::from(plant.pump.dead_time_ms) + plant.pump.spin_up_ms,
            growth: plant.finger.volume_growth / 0.3,
        }
    }
}

fn measured(parameters: PlantParameters, seed: u64) -> Pneumatics {
    let mut plant = Plant::new(parameters, Scene::default(), seed);
    let mut test = SelfTest::new();
    for _ in 0..10_000 {
        match test.step(&plant.inputs()) {
            Verdict::Testing(actuation) => {
                plant.step(&actuation);
            }
            Verdict::Passed => return test.measured(),
            Verdict::Failed(part) => panic!("{part:?} of a machine that works"),
        }
    }
    panic!("the test does not end");
}

/// Per cent by which measured figures are off: of a thousand machines the 0th, 5th, 50th, 95th and 100th percentile.
fn percentiles(name: &str, mut errors: Vec<f64>) -> [f64; 5] {
    errors.sort_by(f64::total_cmp);
    let at = [0, 5, 50, 95, 100].map(|per_cent| 100.0 * errors[(errors.len() - 1) * per_cent / 100]);
    println!("{name}: {:+.0} {:+.0} {:+.0} {:+.0} {:+.0} %", at[0], at[1], at[2], at[3], at[4]);
    at
}

#[test]
fn pump_valves_and_chambers_are_measured() {
    let mut errors: [Vec<f64>; 7] = Default::default();
    for index in 0..1000 {
        let case = Case::draw(2026, index, &Filter::default());
        let truth = Truth::of(&case.plant);
        let found = measured(case.plant, case.noise_seed);
        // In ms, not per cent: dead time and run-down together.
        let coming_ms = found.pump_run_down.to_num::<f64>() + f64::from(found.dead_ticks.get());
        errors[6].push(0.01 * (coming_ms - truth.coming_ms));
        errors[0].push(found.pump_rate.to_num::<f64>() / truth.pump_rate - 1.0);
        errors[1].push(found.dump_rate.to_num::<f64>() / truth.dump_rate - 1.0);
        for (ratio, rate) in found.chamber_ratios.into_iter().zip(found.valve_rates) {
            errors[2].push(ratio.to_num::<f64>() / truth.chamber_ratio - 1.0);
            errors[3].push(rate.to_num::<f64>() / truth.valve_rate - 1.0);
        }
        for (slot, kpa) in [(4, 40), (5, 120)] {
            let at = Pressure::from_kpa(kpa);
            let nominal = Pneumatics::NOMINAL.growth(at).to_num::<f64>();
            let full = truth.chamber_ratio * (1.0 + truth.growth * nominal);
            for ratio in found.chamber_ratios {
                errors[slot].push(ratio.to_num::<f64>() * (1.0 + found.growth(at).to_num::<f64>()) / full - 1.0);
            }
        }
    }
    let [pump, dump, ratio, rate, at40, at120, coming] = errors;
    // Of nine in ten machines; the worst of a thousand may be off twice as far.
    let bounds = [
        ("pump", pump, 3.0),
        ("dump valve", dump, 12.0),
        ("segment valve", rate, 14.0),
        ("chamber, straight", ratio, 25.0),
        ("chamber at 40 kPa", at40, 20.0),
        ("chamber at 120 kPa", at120, 15.0),
        ("pump after its stop, ms instead of %", coming, 9.0),
    ];
    for (name, errors, bound) in bounds {
        let [least, low, _, high, most] = percentiles(name, errors);
        assert!(low > -bound && high < bound, "{name}: {low} to {high} %");
        assert!(least > -2.0 * bound && most < 2.0 * bound, "{name}: {least} to {most} %");
    }
}
