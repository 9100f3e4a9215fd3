//! Against batch least squares in f64 over the same points.

use super::*;
use crate::calibration::{basis, bend_deg, pressure_kpa};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

const EXO: [f64; 3] = [0.0, 13.84, 0.336];
const BARE: [f64; 3] = [35.3, 7.24, 0.831];

fn coefficients([k, c1, c2]: [f64; 3]) -> Coefficients {
    Coefficients::from_f64_kpa(k, c1, c2).expect("admitted")
}

/// Runs points (kPa, degrees) through the fixed-point work, each as a hold of its own where `holds` says so.
fn taken(base: [f64; 3], points: &[(f64, f64)]) -> Identification {
    let base = [coefficients(base); 3];
    let mut identification = Identification::new(base);
    for &(kpa, deg) in points {
        identification.bend = Bend::from_f64_deg(deg);
        identification.pressure = Pressure::from_f64_kpa(kpa);
        identification.work = Work::Regress;
        for _ in 0..30 {
            identification.work(&base);
        }
        assert!(matches!(identification.work, Work::Idle), "the work ends");
    }
    identification
}

fn found(identification: &Identification) -> Identified {
    identification.identified()[0]
}

/// The same problem in f64 at once: weights, forgetting once a hold, the prior on the difference to `base`, and the best of
/// every choice of unknowns at a bound. With what is left, in kPa and degrees.
fn batch(base: [f64; 3], points: &[(f64, f64)]) -> [f64; 3] {
    let fixed = coefficients(base);
    let mut information = Matrix3::identity() * f64::from(1_u32 << 8) / f64::from(1 << 24);
    let mut right = Vector3::zeros();
    let mut last = f64::NEG_INFINITY;
    for &(kpa, deg) in points {
        if (deg - last).abs() > 5.0 {
            // The prior stays; its share is too small to count the difference.
            information *= 1.0 - 1.0 / 32.0;
            right *= 1.0 - 1.0 / 32.0;
            last = deg;
        }
        let at = |by: f64| pressure_kpa(fixed.to_f64_kpa(), deg + by);
        let slope = ((at(1.0) - at(-1.0)) / 2.0).max(0.5);
        let [alpha, a, b] = basis(deg);
        let x = Vector3::new(a / 8.0, b / 128.0, alpha / 2.0) / slope;
        information += x * x.transpose();
        right += x * ((kpa - at(0.0)) / slope);
    }
    let scale = [8.0, 128.0, 2.0];
    let [k, c1, c2] = base;
    let ranges = [(5.0 - c1, 40.0 - c1), (-c2, 2.0 - c2), (-k, 60.0 - k)];
    let mut best: Option<(f64, Vector3<f64>)> = None;
    // Each unknown free, at its low or at its high bound.
    for choice in 0..27_u32 {
        let held = [choice % 3, choice / 3 % 3, choice / 9];
        let mut matrix = information;
        let mut target = right;
        for (i, &how) in held.iter().enumerate() {
            if how > 0 {
                let bound = if how == 1 { ranges[i].0 } else { ranges[i].1 } * scale[i];
                let column: Vector3<f64> = matrix.column(i).into();
                target -= column * bound;
                for j in 0..3 {
                    matrix[(i, j)] = 0.0;
                    matrix[(j, i)] = 0.0;
                }
                matrix[(i, i)] = 1.0;
                target[i] = bound;
            }
        }
        let Some(solution) = matrix.lu().solve(&target) else { continue };
        let inside = solution
            .iter()
            .zip(ranges)
            .zip(scale)
            .all(|((s, (low, high)), scale)| (low * scale - 1e-6..=high * scale + 1e-6).contains(s));
        let cost = (solution.transpose() * information * solution)[(0, 0)] - 2.0 * right.dot(&solution);
        if inside && best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, solution));
        }
    }
    let (_, off) = best.expect("the corners are always inside");
    [k + off[2] / 2.0, c1 + off[0] / 8.0, c2 + off[1] / 128.0]
}

/// Largest difference in bend between two sets of coefficients over a range of pressures, degrees.
fn apart_deg(one: [f64; 3], other: [f64; 3], from_kpa: u32) -> f64 {
    let pressures = (from_kpa..=150).step_by(5).map(f64::from);
    pressures.map(|kpa| (bend_deg(one, kpa) - bend_deg(other, kpa)).abs()).fold(0.0, f64::max)
}

/// The calibration sequence's points, with errors.
fn staircase(truth: [f64; 3], error: impl Fn(usize) -> (f64, f64)) -> Vec<(f64, f64)> {
    (0..15)
        .map(|index| {
            let kpa = 30.0 * f64::from(index as u32 / 3 + 1);
            let (of_kpa, of_deg) = error(index);
            (kpa + of_kpa, bend_deg(truth, kpa) + of_deg)
        })
        .collect()
}

#[test]
fn exact_points_give_the_coefficients_back() {
    for (base, truth) in [(EXO, BARE), (BARE, EXO), (EXO, [12.0, 20.0, 0.0]), (EXO, [0.0, 13.79, 0.323]), (EXO, EXO)] {
        let points = staircase(truth, |_| (0.0, 0.0));
        let identified = found(&taken(base, &points));
        let apart = apart_deg(identified.coefficients.to_f64_kpa(), truth, 5);
        println!("{truth:?}: {:.3?}, {apart:.4} deg", identified.coefficients.to_f64_kpa());
        assert!(identified.ready && identified.points == 15, "{identified:?}");
        assert!(apart < 0.1, "{truth:?}: {identified:?}");
        assert!(identified.residual_bend < Bend::from_milli_deg(150), "{identified:?}");
        assert!(identified.residual_pressure < Pressure::from_milli_kpa(400), "{identified:?}");
    }
}

#[test]
fn the_residual_is_the_scatter_of_the_points() {
    // One degree either side, in turn: 1 degree rms.
    let points = staircase(BARE, |index| (0.0, if index % 2 == 0 { 1.0 } else { -1.0 }));
    // From the coefficients that are right, whose slopes turn pressures into degrees.
    let identified = found(&taken(BARE, &points));
    assert!((0.8..1.3).contains(&identified.residual_bend.to_f64()), "{identified:?}");
    let slope = |deg: f64| pressure_kpa(BARE, deg + 0.5) - pressure_kpa(BARE, deg - 0.5);
    let rms = (points.iter().map(|&(_, deg)| slope(deg).powi(2)).sum::<f64>() / 15.0).sqrt();
    assert!((0.6..1.5).contains(&(identified.residual_pressure.to_f64() / rms)), "{identified:?} {rms}");
}

#[test]
fn poor_excitation_is_not_offered_and_nothing_winds_up() {
    // One bend for an hour: a point each 0.26 s.
    let held = vec![(60.0, 60.0); 14_000];
    let identification = taken(EXO, &held);
    let identified = found(&identification);
    assert!(!identified.ready);
    assert!(identified.points <= u16::from(POINTS_A_HOLD), "{identified:?}");
    // Two bends in turn, for as long.
    let two: Vec<_> = (0..7000).map(|i| if i % 2 == 0 { (60.0, 60.0) } else { (90.0, 80.0) }).collect();
    let identification = taken(EXO, &two);
    assert!(!found(&identification).ready);
    // Both are met all the same, and a calibration after it still finds the finger.
    let after = found(&identification).coefficients.to_f64_kpa();
    assert!((bend_deg(after, 60.0) - 60.0).abs() < 0.1 && (bend_deg(after, 90.0) - 80.0).abs() < 0.1, "{after:?}");
    let mut points = two;
    (0..8).for_each(|_| points.extend(staircase(BARE, |_| (0.0, 0.0))));
    let apart = apart_deg(found(&taken(EXO, &points)).coefficients.to_f64_kpa(), BARE, 20);
    assert!(apart < 1.0, "{apart}");
}

#[test]
fn outliers_are_left_out_and_a_changed_finger_is_not() {
    let mut points = staircase(BARE, |_| (0.0, 0.0));
    let clean = found(&taken(EXO, &points));
    for at in [6, 10, 14] {
        points.insert(at, (points[at].0, points[at].1 + 25.0));
    }
    let points: Vec<_> = staircase(BARE, |_| (0.0, 0.0)).into_iter().chain(points).collect();
    let dirty = found(&taken(EXO, &points));
    assert_eq!(dirty.points, 2 * clean.points, "three are left out");
    let apart = apart_deg(dirty.coefficients.to_f64_kpa(), BARE, 5);
    assert!(apart < 0.1, "{apart}");
    // Another finger on the same device: followed after some calibrations.
    let mut points = staircase(BARE, |_| (0.0, 0.0));
    (0..12).for_each(|_| points.extend(staircase(EXO, |_| (0.0, 0.0))));
    let apart = apart_deg(found(&taken(EXO, &points)).coefficients.to_f64_kpa(), EXO, 20);
    assert!(apart < 1.0, "{apart}");
}

#[test]
fn what_lies_outside_the_admitted_range_ends_at_its_bound() {
    for (points, bound) in [
        // Softer than c1 = 5 kPa allows, and stiffer than everything allows.
        (staircase([0.0, 2.0, 0.1], |_| (0.0, 0.0)), "soft"),
        ((0..15).map(|i| (30.0 * f64::from(i / 3 + 1), 16.0 + 3.0 * f64::from(i / 3))).collect(), "stiff"),
        (staircase([-20.0, 18.0, 0.2], |_| (0.0, 0.0)), "k below zero"),
    ] {
        let identified = found(&taken(EXO, &points));
        let [k, c1, c2] = identified.coefficients.to_f64_kpa();
        println!("{bound}: {k} {c1} {c2}, {identified:?}");
        assert!((0.0..=60.0).contains(&k) && (5.0..=40.0).contains(&c1) && (0.0..=2.0).contains(&c2));
    }
}

#[test]
fn any_numbers_are_survived() {
    let extremes = [i32::MIN, -1, 0, 1, 1 << 16, i32::MAX];
    let base = [coefficients(EXO); 3];
    let mut identification = Identification::new(base);
    for pressure in extremes {
        for bend in extremes {
            for _ in 0..4 {
                identification.bend = Bend::from_bits(bend);
                identification.pressure = Pressure::from_bits(pressure);
                identification.work = Work::Regress;
                (0..30).for_each(|_| identification.work(&base));
            }
        }
    }
    let _ = found(&identification);
}

#[test]
fn points_come_only_from_one_segment_alone_at_rest() {
    let base = [coefficients(EXO); 3];
    let kpa = |p: i16, m: i16| [Pressure::from_kpa(p), Pressure::from_kpa(m), Pressure::ZERO];
    let run = |identification: &mut Identification, setpoints: PerSegment<Pressure>, bend: Option<i16>, air: bool| {
        let seen = Observation { setpoints, estimates: setpoints, bend: bend.map(Bend::from_deg), air_rests: air };
        for _ in 0..2000 {
            identification.observe(&seen);
            identification.work(&base);
        }
        identification.identified().map(|identified| identified.points)
    };
    let mut fresh = Identification::new(base);
    assert_eq!(run(&mut fresh, kpa(60, 0), Some(70), true), [0; 3], "the others may hold air");
    run(&mut fresh, kpa(0, 0), Some(0), true);
    let vented = fresh.clone();
    assert_eq!(run(&mut vented.clone(), kpa(60, 0), Some(70), true), [4, 0, 0]);
    assert_eq!(run(&mut vented.clone(), kpa(0, 60), Some(70), true), [0, 4, 0]);
    assert_eq!(run(&mut vented.clone(), kpa(60, 60), Some(140), true), [0; 3], "two at once");
    assert_eq!(run(&mut vented.clone(), kpa(60, 0), None, true), [0; 3], "no sensor");
    assert_eq!(run(&mut vented.clone(), kpa(60, 0), Some(70), false), [0; 3], "air flows");
    let mut both = vented;
    run(&mut both, kpa(60, 60), Some(140), true);
    assert_eq!(run(&mut both, kpa(60, 0), Some(70), true), [0; 3], "the middle one was filled");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Fixed point against f64, in what counts: the bend that the coefficients give at each pressure.
    #[test]
    fn the_same_as_batch_least_squares(
        k in 0.0..60.0, c1 in 5.0..40.0, c2 in 0.0..2.0,
        base in prop_oneof![Just(EXO), Just(BARE), Just([20.0, 10.0, 1.0])],
        errors in proptest::collection::vec((-0.5..0.5, -0.5..0.5), 15),
    ) {
        let truth = [k, c1, c2];
        let points = staircase(truth, |index| errors[index]);
        prop_assume!(points.iter().all(|&(_, deg)| (15.0..130.0).contains(&deg)));
        let identification = taken(base, &points);
        let identified = found(&identification);
        prop_assume!(usize::from(identified.points) == points.len());
        let exact = batch(base, &points);
        let apart = apart_deg(identified.coefficients.to_f64_kpa(), exact, 30);
        prop_assert!(apart < 0.15, "{apart} deg: {:?} {exact:?}", identified.coefficients.to_f64_kpa());
    }

    /// Nearly the same bend again and again: k and c1 cannot be told apart, and whatever is found fits the points.
    #[test]
    fn collinear_points_are_met(deg in 30.0..100.0, spread in 5.5..12.0) {
        let points: Vec<_> =
            (0..30).map(|i| { let deg = deg + spread * f64::from(i % 2); (pressure_kpa(BARE, deg), deg) }).collect();
        prop_assume!(points.iter().all(|&(kpa, _)| kpa < 160.0));
        let identified = found(&taken(EXO, &points));
        for (kpa, deg) in points {
            prop_assert!((bend_deg(identified.coefficients.to_f64_kpa(), kpa) - deg).abs() < 0.2, "{identified:?}");
        }
    }
}
