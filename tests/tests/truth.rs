//! The table of true values, 50 digits each: that it is what its generator makes, and how far from it the f64
//! reference (`host_sim::mechanics`) and the fixed-point core (`model_core::inverse`) are.
//!
//! # The reference's bound
//! Every function of the reference is held to 4 ulp flat, even where the model is badly conditioned. Its condition
//! number, alpha P'/P, is 2 near zero and grows as 3 pi / (pi - alpha) towards the pole: 6e14 at 180 - 2^-40 degrees.
//! But that number magnifies the error of an argument, and the arguments here have none: degrees are taken as the exact
//! f64 they are, and are not rounded to radians first; for radians the truth is computed anew at the very f64 that the
//! function gets. What remains is the function's own rounding. The way back divides by the condition number, and ends
//! with one rounding to a neighbouring f64 and one to degrees.
//!
//! `cargo test -p finger-tests --test truth -- --nocapture` prints the worst error of each region.

use finger_tests::truth::table::{self, Inverse, Table};
use finger_tests::truth::{CoefficientBits, Definition, coefficients_kpa, error, error_ulp, pressure, slope, to_f64};
use fixed::types::I8F24;
use host_sim::mechanics::{angle_from_pressure_deg, pressure_and_slope, pressure_from_angle_kpa};
use model_core::inverse::{BEND_LIMIT, Tabulated, bend_from_pressure, pressure_from_bend};
use model_core::units::{Bend, Coefficients, Pressure};
use std::fmt::Write as _;

/// Upper ends of the regions of bend that are judged apart, in degrees.
const REGION_ENDS_DEG: [f64; 8] = [1e-9, 0.01, 1.0, 45.0, 114.6, 150.0, 170.0, 180.0];

/// The worst of something in each region, and where it was.
#[derive(Default)]
struct Worst([(f64, String); REGION_ENDS_DEG.len()]);

impl Worst {
    fn add(&mut self, bend_deg: f64, value: f64, place: impl FnOnce() -> String) {
        let region = REGION_ENDS_DEG.iter().position(|&end| bend_deg < end).expect("below 180 degrees");
        // A NaN must not pass for small.
        if value.is_nan() || value > self.0[region].0 {
            self.0[region] = (value, place());
        }
    }

    /// Prints every region and holds each to `limit`.
    fn judge(&self, what: &str, unit: &str, limit: f64) {
        let mut text = format!("{what}, worst by region (limit {limit} {unit}):\n");
        for (end, (value, place)) in REGION_ENDS_DEG.iter().zip(&self.0) {
            writeln!(text, "  bend below {end:>6} deg: {value:.3e} {unit} at {place}").expect("a string");
        }
        print!("{text}");
        assert!(self.0.iter().all(|(value, _)| *value <= limit), "{text}");
    }
}

fn truth() -> Table {
    table::read().expect("the checked-in table")
}

#[test]
fn the_table_is_what_its_generator_makes() {
    let path = table::path();
    let checked_in = std::fs::read_to_string(&path).expect("the checked-in table");
    let generated = table::write(|| ());
    for (index, (old, new)) in checked_in.lines().zip(generated.lines()).enumerate() {
        assert_eq!(old, new, "truth.csv, line {}: run `cargo xtask truth`", index + 1);
    }
    assert_eq!(checked_in.len(), generated.len(), "truth.csv has lines too many or too few: run `cargo xtask truth`");
}

#[test]
fn reference_pressure_from_degrees() {
    let mut worst = Worst::default();
    for (bend, at) in truth().forward {
        for coefficients in table::calibrations() {
            let found = pressure_from_angle_kpa(&coefficients_kpa(coefficients), bend);
            let ulp = error_ulp(found, &pressure(coefficients, &at)).abs();
            worst.add(bend, ulp, || format!("{bend} deg, {coefficients:?}"));
        }
    }
    worst.judge("pressure_from_angle_kpa", "ulp", 4.0);
}

#[test]
fn reference_pressure_and_slope_from_radians() {
    let mut definition = Definition::new();
    let (mut worst, mut worst_slope) = (Worst::default(), Worst::default());
    for (bend, at) in truth().forward {
        // The f64 nearest to the table's angle, and the truth at that f64: nothing is charged to the function that
        // belongs to its argument.
        let alpha = to_f64(&at.alpha);
        let at = definition.forward_rad(alpha);
        for coefficients in table::calibrations() {
            let (found, found_slope) = pressure_and_slope(&coefficients_kpa(coefficients), alpha);
            let place = || format!("{alpha} rad, {coefficients:?}");
            worst.add(bend, error_ulp(found, &pressure(coefficients, &at)).abs(), place);
            worst_slope.add(bend, error_ulp(found_slope, &slope(coefficients, &at)).abs(), place);
        }
    }
    worst.judge("pressure_and_slope, pressure", "ulp", 4.0);
    worst_slope.judge("pressure_and_slope, slope", "ulp", 4.0);
}

#[test]
fn reference_degrees_from_pressure() {
    let mut worst = Worst::default();
    for Inverse { coefficients, pressure_kpa, bend_deg } in truth().inverse {
        let found = angle_from_pressure_deg(&coefficients_kpa(coefficients), pressure_kpa);
        let place = || format!("{pressure_kpa} kPa, {coefficients:?}");
        worst.add(to_f64(&bend_deg), error_ulp(found, &bend_deg).abs(), place);
    }
    worst.judge("angle_from_pressure_deg", "ulp", 4.0);
}

/// Both of the core's ways, inverse and forward, at pressures and bends that they can be given, which are multiples of
/// 2^-16. The target over 0..150 kPa is 0.001 degree and 0.001 kPa; the limit here is what was reached.
#[test]
fn core_in_the_working_range() {
    const BIT: f64 = 1.0 / 65_536.0;
    const LIMIT: f64 = 5e-5;
    let fixed = |[k, c1, c2]: CoefficientBits| {
        let bits = I8F24::from_bits;
        Coefficients::new(bits(k), bits(c1), bits(c2)).expect("admitted coefficients")
    };
    let representable = |value: f64| (value / BIT).fract() == 0.0;
    let table = truth();
    let mut worst = ["bend_from_pressure", "pressure_from_bend"]
        .map(|name| [(name, "direct"), (name, "tabulated")].map(|name| (name, Worst::default())));
    let (mut bends_seen, mut pressures_seen) = (0, 0);
    for Inverse { coefficients, pressure_kpa, bend_deg } in &table.inverse {
        if *pressure_kpa > 150.0 || !representable(*pressure_kpa) {
            continue;
        }
        let (finger, given) = (fixed(*coefficients), Pressure::from_f64_kpa(*pressure_kpa));
        let ways = [bend_from_pressure(&finger, given), Tabulated::new(&finger).bend_from_pressure(given)];
        for ((_, bends), found) in worst[0].iter_mut().zip(ways) {
            let place = || format!("{pressure_kpa} kPa, {coefficients:?}");
            bends.add(to_f64(bend_deg), error(found.to_f64(), bend_deg).abs(), place);
        }
        bends_seen += 1;
    }
    for coefficients in table::calibrations() {
        let finger = fixed(coefficients);
        let tabulated = Tabulated::new(&finger);
        for (bend_deg, at) in &table.forward {
            let exact = pressure(coefficients, at);
            if *bend_deg > BEND_LIMIT.to_f64() || !representable(*bend_deg) || to_f64(&exact) > 150.0 {
                continue;
            }
            let given = Bend::from_f64_deg(*bend_deg);
            let ways = [pressure_from_bend(&finger, given), tabulated.pressure_from_bend(given)];
            for ((_, pressures), found) in worst[1].iter_mut().zip(ways) {
                let place = || format!("{bend_deg} deg, {coefficients:?}");
                pressures.add(*bend_deg, error(found.to_f64(), &exact).abs(), place);
            }
            pressures_seen += 1;
        }
    }
    println!("{bends_seen} pressures and {pressures_seen} bends of the table are multiples of 2^-16");
    assert!(bends_seen > 1000 && pressures_seen > 1000, "{bends_seen} {pressures_seen}");
    for (direction, unit) in worst.iter().zip(["deg", "kPa"]) {
        for ((name, way), worst) in direction {
            worst.judge(&format!("{name}, {way}"), unit, LIMIT);
        }
    }
}
