//! What the methods are tested against: the model by a route that none of them takes, and the checks that all share.

use super::{Method, Quantity, Representation, coefficients_kpa};
use crate::units::Coefficients;

/// Default finger and bare chamber, and corners of the admitted range.
pub const CALIBRATIONS: [(f64, f64, f64); 8] = [
    (0.0, 13.835_501, 0.335_61),
    (35.3, 7.24, 0.831),
    (0.0, 5.0, 0.0),
    (60.0, 40.0, 2.0),
    (0.0, 40.0, 0.0),
    (0.0, 5.0, 2.0),
    (60.0, 5.0, 0.0),
    (0.01, 5.0, 0.0),
];

/// What a method's worst errors over 0..1000 kPa and 0..170 degrees may be.
#[derive(Clone, Copy)]
pub struct Limits {
    pub bend_deg: f64,
    pub pressure_kpa: f64,
}

/// The logarithm of the stretch from sin itself, differences through `exp_m1`.
pub fn pressure_kpa(coefficients: &Coefficients, degrees: f64) -> f64 {
    let [k, c1, c2] = coefficients_kpa(coefficients);
    let alpha = degrees.to_radians();
    if alpha <= 0.0 {
        return 0.0;
    }
    // α − sin α, by its own series where the difference would cancel.
    let excess = if alpha < 0.5 {
        let mut term = alpha * alpha * alpha / 6.0;
        let mut sum = 0.0;
        for n in 2..12 {
            sum += term;
            term *= -alpha * alpha / f64::from(2 * n * (2 * n + 1));
        }
        sum
    } else {
        alpha - alpha.sin()
    };
    let log = (excess / alpha.sin()).ln_1p();
    let a = -4.0 * log.exp() * (-6.0 * log).exp_m1();
    let invariant = 2.0 * (2.0 * log).exp_m1() + (-4.0 * log).exp_m1();
    k * alpha + c1 * a + c2 * 2.0 * a * invariant
}

/// By bisection, never above 170 degrees.
pub fn bend_deg(coefficients: &Coefficients, kpa: f64) -> f64 {
    let (mut low, mut high) = (0.0, 170.0);
    if pressure_kpa(coefficients, high) <= kpa {
        return high;
    }
    while f64::midpoint(low, high) > low && f64::midpoint(low, high) < high {
        let middle = f64::midpoint(low, high);
        if pressure_kpa(coefficients, middle) <= kpa {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// A grid of 0..`limit` with the first bits, the ends of uniform and of floating segments and their neighbours.
fn inputs(limit: f64) -> Vec<f64> {
    let bit = 1.0 / 65_536.0;
    let mut inputs: Vec<f64> = (1..200).map(|bits| f64::from(bits) * bit).collect();
    inputs.extend((1..4000).map(|step| limit * f64::from(step) / 4000.0));
    inputs.extend((0..400).map(|step| bit * (limit / bit).powf(f64::from(step) / 400.0)));
    let ends =
        (0..26).flat_map(|octave| (64..128).map(move |part| f64::from(part) / 64.0 * f64::from(1 << octave) * bit));
    inputs.extend(ends.flat_map(|end| [end - bit, end, end + bit]));
    inputs.retain(|input| (0.0..=limit).contains(input));
    inputs
}

fn errors<M: Method>(coefficients: &Coefficients) -> (f64, f64) {
    let method = M::prepare(coefficients);
    let (mut worst_bend, mut worst_pressure) = (0.0_f64, 0.0_f64);
    for input in inputs(1000.0) {
        let input = M::Pressure::from_f64(input);
        let error = method.bend_from_pressure(input).to_f64() - bend_deg(coefficients, input.to_f64());
        worst_bend = worst_bend.max(error.abs());
    }
    for input in inputs(170.0) {
        let input = M::Bend::from_f64(input);
        let exact = pressure_kpa(coefficients, input.to_f64());
        if exact <= 1000.0 {
            worst_pressure = worst_pressure.max((method.pressure_from_bend(input).to_f64() - exact).abs());
        }
    }
    (worst_bend, worst_pressure)
}

/// Errors within `limits` (default finger, bare chamber, worst corner), and the ends of the domain.
pub fn check<M: Method>(limits: &[Limits; 3]) {
    println!("{}: {} bytes", M::NAME, size_of::<M>());
    let mut measured = [(0.0_f64, 0.0_f64); 3];
    for (index, (k, c1, c2)) in CALIBRATIONS.into_iter().enumerate() {
        let coefficients = Coefficients::from_f64_kpa(k, c1, c2).unwrap();
        let (bend, pressure) = errors::<M>(&coefficients);
        println!("  (k, c1, c2) = ({k}, {c1}, {c2}): {bend:.2e} degree, {pressure:.2e} kPa");
        let slot = &mut measured[index.min(2)];
        *slot = (slot.0.max(bend), slot.1.max(pressure));
        ends::<M>(&coefficients);
    }
    for (limits, (bend, pressure)) in limits.iter().zip(measured) {
        assert!(bend <= limits.bend_deg && pressure <= limits.pressure_kpa, "{}: {bend:e} {pressure:e}", M::NAME);
    }
}

/// Zero at and below zero, level beyond the domain's ends.
fn ends<M: Method>(coefficients: &Coefficients) {
    let method = M::prepare(coefficients);
    let bend = |kpa| method.bend_from_pressure(M::Pressure::from_f64(kpa)).to_f64();
    let pressure = |deg| method.pressure_from_bend(M::Bend::from_f64(deg)).to_f64();
    for zero in [0.0, -1.0 / 65_536.0, -100.0, -32_768.0] {
        assert!(bend(zero).abs() <= 0.0 && pressure(zero).abs() <= 0.0, "{} at {zero}", M::NAME);
    }
    for beyond in [1000.5, 2000.0, 32_767.9] {
        assert!((bend(beyond) - bend(1000.0)).abs() <= 0.0, "{} at {beyond} kPa", M::NAME);
    }
    for beyond in [170.5, 179.99, 180.0, 360.0, 32_767.9] {
        assert!((pressure(beyond) - pressure(170.0)).abs() <= 0.0, "{} at {beyond} degrees", M::NAME);
    }
    assert!(bend(1000.0) <= 170.0, "{}", M::NAME);
    if M::Bend::REPRESENTATION == Representation::Fixed {
        let end = pressure_kpa(coefficients, 170.0);
        assert!((end < 32_768.0) || pressure(170.0) > 32_767.9, "{}: saturates at {}", M::NAME, pressure(170.0));
    }
}

/// NaN, infinities and the smallest numbers, for the float methods.
pub fn check_float_edges<M: Method>() {
    for (k, c1, c2) in CALIBRATIONS {
        let coefficients = Coefficients::from_f64_kpa(k, c1, c2).unwrap();
        let method = M::prepare(&coefficients);
        let bend = |kpa| method.bend_from_pressure(M::Pressure::from_f64(kpa)).to_f64();
        let pressure = |deg| method.pressure_from_bend(M::Bend::from_f64(deg)).to_f64();
        for zero in [f64::NAN, f64::NEG_INFINITY, -f64::MIN_POSITIVE, -0.0, f64::MIN] {
            assert!(bend(zero).abs() <= 0.0 && pressure(zero).abs() <= 0.0, "{} at {zero}", M::NAME);
        }
        assert!((bend(f64::INFINITY) - bend(1000.0)).abs() <= 0.0 && (bend(f64::MAX) - bend(1000.0)).abs() <= 0.0);
        assert!((pressure(f64::INFINITY) - pressure(170.0)).abs() <= 0.0);
        // Subnormal, smallest normal and small numbers of f32 and, for the f64 method, of f64.
        for tiny in [f64::from_bits(1), f64::MIN_POSITIVE, 1e-45, 1e-39, 1.2e-38, 1e-30, 1e-20, 1e-12] {
            for value in [bend(tiny), pressure(tiny)] {
                assert!(value.is_finite() && (0.0..1e-3).contains(&value), "{} at {tiny:e}: {value}", M::NAME);
            }
        }
    }
}
