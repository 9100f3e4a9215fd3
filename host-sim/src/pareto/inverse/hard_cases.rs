//! The cases in which such methods go wrong, by name: what each of them returns there.

use super::samples::{self, LSB};
use super::truth;
use crate::methods::{self, Direction, Entry, Prepared, representable};
use model_core::calibration;
use model_core::methods::Representation;
use model_core::units::Coefficients;

/// Pressures of the first bits: 2⁻¹⁶ to 2⁻¹³ kPa.
const FIRST_BITS_KPA: [f64; 4] = [LSB, 2.0 * LSB, 4.0 * LSB, 8.0 * LSB];
/// One bit below zero, vacuum, and the smallest number.
const BELOW_ZERO: [f64; 3] = [-LSB, -100.0, -32_768.0];
/// Bends towards the pole in degrees.
const POLE_DEG: [f64; 4] = [170.0, 179.99, 180.0, 360.0];
/// Pressures at and beyond the domain's end in kPa; the last is the largest number.
const BEYOND_KPA: [f64; 3] = [1000.0, 1001.0, 32_767.999_984_741_21];
/// The calibration whose pressure at 170 degrees, 162 000 kPa, no fixed-point format here holds.
const SATURATING_KPA: [f64; 3] = [60.0, 40.0, 2.0];
/// The end of the working range in kPa.
const WORKING_KPA: f64 = 150.0;

/// What a float method makes of what is no ordinary number; the bend in degrees and the pressure in kPa.
#[derive(Clone, Debug, serde::Serialize)]
pub struct FloatSpecials {
    /// The smallest subnormal number of the format as a pressure.
    pub smallest_subnormal_bend_deg: f64,
    /// NaN as a pressure.
    pub nan_bend_deg: f64,
    /// NaN as a bend.
    pub nan_pressure_kpa: f64,
    /// Plus infinity as a pressure.
    pub infinity_bend_deg: f64,
    /// Plus infinity as a bend.
    pub infinity_pressure_kpa: f64,
    /// Minus infinity as a pressure.
    pub minus_infinity_bend_deg: f64,
}

/// What one method returns in the hard cases, with the default calibration unless said otherwise.
#[derive(Clone, Debug, serde::Serialize)]
pub struct HardCases {
    /// Its name.
    pub method: &'static str,
    /// At P = 0.
    pub zero_bend_deg: f64,
    /// At 2⁻¹⁶, 2⁻¹⁵, 2⁻¹⁴ and 2⁻¹³ kPa.
    pub first_bits_bend_deg: [f64; 4],
    /// The bend of the first bit against the exact one, relative: how well the infinite slope at 0 is met.
    pub first_bit_relative_error: f64,
    /// At −2⁻¹⁶, −100 and −32768 kPa.
    pub below_zero_bend_deg: [f64; 3],
    /// At −2⁻¹⁶, −100 and −32768 degrees.
    pub below_zero_pressure_kpa: [f64; 3],
    /// At 1000, 1001 and 32767.99998 kPa.
    pub beyond_bend_deg: [f64; 3],
    /// At 170, 179.99, 180 and 360 degrees.
    pub pole_pressure_kpa: [f64; 4],
    /// At 170 degrees with k = 60, c1 = 40, c2 = 2 kPa.
    pub saturating_pressure_kpa: f64,
    /// The largest jump of the bend across an end of a segment beyond the model's own rise, 0..1000 kPa, in 2⁻¹⁶ degree.
    pub largest_bend_jump_lsb: f64,
    /// The same of the pressure, up to 1000 kPa, in 2⁻¹⁶ kPa.
    pub largest_pressure_jump_lsb: f64,
    /// The worst |P(α(P)) − P| over 0..150 kPa.
    pub round_trip_error_kpa: f64,
    /// The worst |α(P(α)) − α| over 0..150 kPa.
    pub round_trip_error_deg: f64,
    /// For the float methods.
    pub floats: Option<FloatSpecials>,
}

/// What the reference says in the same cases, beside the methods' answers.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Exact {
    /// At 2⁻¹⁶, 2⁻¹⁵, 2⁻¹⁴ and 2⁻¹³ kPa.
    pub first_bits_bend_deg: [f64; 4],
    /// At 1000 kPa.
    pub limit_bend_deg: f64,
    /// At 170 degrees.
    pub limit_pressure_kpa: f64,
    /// At 170 degrees with k = 60, c1 = 40, c2 = 2 kPa.
    pub saturating_pressure_kpa: f64,
}

/// All methods, and the reference.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Examination {
    /// The reference.
    pub exact: Exact,
    /// The methods.
    pub methods: Vec<HardCases>,
}

fn saturating() -> Coefficients {
    let [k, c1, c2] = SATURATING_KPA;
    // A corner of the admitted range.
    Coefficients::from_f64_kpa(k, c1, c2).unwrap_or(calibration::DEFAULT)
}

/// The largest difference between a method's rise and the model's over one bit, across the ends of segments.
fn largest_jump(method: &dyn Prepared, representation: Representation, direction: Direction) -> f64 {
    let exact = |input| match direction {
        Direction::BendFromPressure => truth::bend_deg(&calibration::DEFAULT, input),
        Direction::PressureFromBend => truth::pressure_kpa(&calibration::DEFAULT, input),
    };
    let mut largest = 0.0_f64;
    for end in samples::ends(direction) {
        let [below, at] = [end - LSB, end].map(|input| representable(representation, input));
        let [from, to] = [below, at].map(exact);
        if direction == Direction::PressureFromBend && to > 1000.0 {
            break;
        }
        let rise = method.evaluate(direction, at) - method.evaluate(direction, below);
        largest = largest.max((rise - (to - from)).abs());
    }
    largest / LSB
}

fn round_trips(method: &dyn Prepared, representation: Representation) -> [f64; 2] {
    let (to_bend, to_pressure) = (Direction::BendFromPressure, Direction::PressureFromBend);
    let mut worst = [0.0_f64; 2];
    for pressure in samples::all(to_bend).into_iter().filter(|&pressure| pressure <= WORKING_KPA) {
        let pressure = representable(representation, pressure);
        let back = method.evaluate(to_pressure, method.evaluate(to_bend, pressure));
        worst[0] = worst[0].max((back - pressure).abs());
    }
    for bend in samples::all(to_pressure) {
        let bend = representable(representation, bend);
        let pressure = method.evaluate(to_pressure, bend);
        if pressure <= WORKING_KPA {
            worst[1] = worst[1].max((method.evaluate(to_bend, pressure) - bend).abs());
        }
    }
    worst
}

fn of(entry: &Entry) -> HardCases {
    let method = (entry.prepare)(&calibration::DEFAULT);
    let bend = |kpa| method.evaluate(Direction::BendFromPressure, kpa);
    let pressure = |deg| method.evaluate(Direction::PressureFromBend, deg);
    let [round_trip_error_kpa, round_trip_error_deg] = round_trips(method.as_ref(), entry.representation);
    let jump = |direction| largest_jump(method.as_ref(), entry.representation, direction);
    let floats = (entry.representation != Representation::Fixed).then(|| FloatSpecials {
        smallest_subnormal_bend_deg: bend(match entry.representation {
            Representation::F64 => f64::from_bits(1),
            _ => f64::from(f32::from_bits(1)),
        }),
        nan_bend_deg: bend(f64::NAN),
        nan_pressure_kpa: pressure(f64::NAN),
        infinity_bend_deg: bend(f64::INFINITY),
        infinity_pressure_kpa: pressure(f64::INFINITY),
        minus_infinity_bend_deg: bend(f64::NEG_INFINITY),
    });
    HardCases {
        method: entry.name,
        zero_bend_deg: bend(0.0),
        first_bits_bend_deg: FIRST_BITS_KPA.map(bend),
        first_bit_relative_error: bend(LSB) / truth::bend_deg(&calibration::DEFAULT, LSB) - 1.0,
        below_zero_bend_deg: BELOW_ZERO.map(bend),
        below_zero_pressure_kpa: BELOW_ZERO.map(pressure),
        beyond_bend_deg: BEYOND_KPA.map(bend),
        pole_pressure_kpa: POLE_DEG.map(pressure),
        saturating_pressure_kpa: (entry.prepare)(&saturating()).evaluate(Direction::PressureFromBend, 170.0),
        largest_bend_jump_lsb: jump(Direction::BendFromPressure),
        largest_pressure_jump_lsb: jump(Direction::PressureFromBend),
        round_trip_error_kpa,
        round_trip_error_deg,
        floats,
    }
}

/// Asks every method.
#[must_use]
pub fn examine() -> Examination {
    let entries = methods::all();
    let bar = crate::progress::bar(entries.len(), "hard cases of");
    let ask = |entry: &Entry| {
        bar.set_message(entry.name);
        let answer = of(entry);
        bar.inc(1);
        answer
    };
    let methods = entries.iter().map(ask).collect();
    bar.finish_and_clear();
    Examination {
        exact: Exact {
            first_bits_bend_deg: FIRST_BITS_KPA.map(|kpa| truth::bend_deg(&calibration::DEFAULT, kpa)),
            limit_bend_deg: truth::bend_deg(&calibration::DEFAULT, 1000.0),
            limit_pressure_kpa: truth::pressure_kpa(&calibration::DEFAULT, 170.0),
            saturating_pressure_kpa: truth::pressure_kpa(&saturating(), 170.0),
        },
        methods,
    }
}

/// A few digits, in the shorter of two ways to write it.
fn short(value: f64) -> String {
    if value.abs() <= 0.0 {
        "0".to_owned()
    } else if (0.01..1e5).contains(&value.abs()) {
        format!("{value:.4}")
    } else {
        format!("{value:.1e}")
    }
}

fn join<const N: usize>(values: [f64; N]) -> String {
    let first = short(values[0]);
    // Said once when all are the same.
    if values.iter().all(|value| short(*value) == first) {
        return first;
    }
    values.map(short).join(", ")
}

/// The answers as Markdown tables.
#[must_use]
pub fn hard_cases_markdown(examination: &Examination) -> String {
    let exact = &examination.exact;
    let mut out = format!(
        "### At and below zero\n\nBend in degrees; the model says {} at 2⁻¹⁶, 2⁻¹⁵, 2⁻¹⁴, 2⁻¹³ kPa. Below zero: at −2⁻¹⁶, −100 and −32768, \
         bend, then pressure; one number where all are the same.\n\n\
         | Method | P = 0 | First bits | First bit, relative error | Below zero |\n|---|---|---|---|---|\n",
        exact.first_bits_bend_deg.map(|bend| format!("{bend:.5}")).join(", ")
    );
    for cases in &examination.methods {
        out += &format!(
            "| `{}` | {} | {} | {:+.1} % | {}; {} |\n",
            cases.method,
            short(cases.zero_bend_deg),
            cases.first_bits_bend_deg.map(|bend| format!("{bend:.5}")).join(", "),
            100.0 * cases.first_bit_relative_error,
            join(cases.below_zero_bend_deg),
            join(cases.below_zero_pressure_kpa),
        );
    }
    out += &format!(
        "\n### At the upper ends\n\nThe model says {:.4} degrees at 1000 kPa, {:.1} kPa at 170 degrees, and {:.0} kPa there with k = 60, \
         c1 = 40, c2 = 2 kPa. One number where all are the same.\n\n\
         | Method | Bend at 1000, 1001, 32768 kPa | Pressure at 170, 179.99, 180, 360 degrees | Saturating calibration at 170 degrees |\n\
         |---|---|---|---|\n",
        exact.limit_bend_deg, exact.limit_pressure_kpa, exact.saturating_pressure_kpa
    );
    for cases in &examination.methods {
        out += &format!(
            "| `{}` | {} | {} | {:.5} |\n",
            cases.method,
            join(cases.beyond_bend_deg),
            join(cases.pole_pressure_kpa),
            cases.saturating_pressure_kpa
        );
    }
    out += "\n### Ends of segments, and there and back\n\nThe largest jump across an end of a segment beyond the model's own rise, in 2⁻¹⁶ degree and \
            2⁻¹⁶ kPa, over the domain. There and back over 0..150 kPa: the worst |P(α(P)) − P| and |α(P(α)) − α|. The \
            latter is bounded by the pressure's format: without stiffness half a bit of pressure near zero is 0.02 degree.\n\n\
            | Method | Jump of the bend | Jump of the pressure | P → α → P, kPa | in 2⁻¹⁶ | α → P → α, degrees | in 2⁻¹⁶ |\n\
            |---|---|---|---|---|---|---|\n";
    for cases in &examination.methods {
        out += &format!(
            "| `{}` | {:.1} | {:.1} | {:.1e} | {:.1} | {:.1e} | {:.1} |\n",
            cases.method,
            cases.largest_bend_jump_lsb,
            cases.largest_pressure_jump_lsb,
            cases.round_trip_error_kpa,
            cases.round_trip_error_kpa / LSB,
            cases.round_trip_error_deg,
            cases.round_trip_error_deg / LSB
        );
    }
    out += "\n### What is no ordinary number\n\nFor the methods in floats; the fixed-point formats have nothing of the kind.\n\n\
            | Method | Smallest subnormal kPa | NaN: degrees, kPa | +∞: degrees, kPa | −∞: degrees |\n|---|---|---|---|---|\n";
    for (cases, floats) in examination.methods.iter().filter_map(|cases| Some((cases, cases.floats.as_ref()?))) {
        out += &format!(
            "| `{}` | {:.1e} | {}, {} | {}, {} | {} |\n",
            cases.method,
            floats.smallest_subnormal_bend_deg,
            short(floats.nan_bend_deg),
            short(floats.nan_pressure_kpa),
            short(floats.infinity_bend_deg),
            short(floats.infinity_pressure_kpa),
            short(floats.minus_infinity_bend_deg)
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_keeps_the_ends_of_the_domain() {
        let examination = examine();
        assert_eq!(examination.methods.len(), methods::all().len());
        for cases in &examination.methods {
            let name = cases.method;
            assert!(cases.zero_bend_deg.abs() <= 0.0, "{name}");
            for zero in cases.below_zero_bend_deg.into_iter().chain(cases.below_zero_pressure_kpa) {
                assert!(zero.abs() <= 0.0, "{name}: {zero} below zero");
            }
            for beyond in cases.beyond_bend_deg {
                assert!((beyond - examination.exact.limit_bend_deg).abs() < 0.5, "{name}: {beyond}");
            }
            for pressure in cases.pole_pressure_kpa {
                assert!((pressure - cases.pole_pressure_kpa[0]).abs() <= 0.0, "{name}: {pressure}");
            }
            // Fixed point ends at its largest number, floats go on.
            let saturated = cases.saturating_pressure_kpa;
            let most = representable(Representation::Fixed, f64::MAX);
            let exact = examination.exact.saturating_pressure_kpa;
            assert!(
                if cases.floats.is_none() { saturated >= most } else { (saturated / exact - 1.0).abs() < 0.05 },
                "{name}: {saturated}"
            );
            if let Some(floats) = &cases.floats {
                assert!(floats.nan_bend_deg.abs() <= 0.0 && floats.nan_pressure_kpa.abs() <= 0.0, "{name}");
                assert!(floats.minus_infinity_bend_deg.abs() <= 0.0, "{name}");
                assert!((floats.infinity_bend_deg - cases.beyond_bend_deg[0]).abs() <= 0.0, "{name}");
                assert!((0.0..1e-15).contains(&floats.smallest_subnormal_bend_deg), "{name}");
            }
        }
        let own = examination.methods.iter().find(|cases| cases.method == "fixed-newton").expect("there");
        // Rounded to nearest: half a bit either way of the model's own rise.
        assert!(own.largest_bend_jump_lsb <= 1.1 && own.first_bit_relative_error.abs() < 1e-3);
        let markdown = hard_cases_markdown(&examination);
        assert_eq!(markdown.matches("`fixed-newton`").count(), 3);
        assert_eq!(markdown.matches("`f64-newton`").count(), 4);
    }
}
