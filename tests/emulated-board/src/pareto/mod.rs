//! What every method of `model_core::methods` costs on the Cortex-M4 and how far it is from the model: the figures
//! behind `cargo xtask pareto`.

mod calls;
mod functions;
mod samples;

pub use functions::{FunctionCost, functions};

pub use calls::{Cossin, Cost, cossin, costs, passed, prepare, room};

use crate::counted::Counted;
use crate::footprint::{Bytes, Footprint};
use anyhow::{Context as _, Result};
use host_sim::pareto::inverse::{Report, Row};
use model_core::calibration;
use model_core::methods::{Method, Quantity as _};
use model_core::units::Coefficients;
use serde_json::{Map, Value, json};

/// Which of the two functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// α = f(P), kPa to degrees.
    Bend,
    /// P = f⁻¹(α), degrees to kPa.
    Pressure,
}

impl Direction {
    /// Both.
    pub const BOTH: [Self; 2] = [Self::Bend, Self::Pressure];

    /// As in the symbols of `counted` and in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bend => "bend",
            Self::Pressure => "pressure",
        }
    }

    /// host-sim's name for it.
    const fn of_host(self) -> host_sim::methods::Direction {
        match self {
            Self::Bend => host_sim::methods::Direction::BendFromPressure,
            Self::Pressure => host_sim::methods::Direction::PressureFromBend,
        }
    }

    /// The result's unit, as in JSON keys.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        self.of_host().unit()
    }

    /// What host-sim found of a method in this direction.
    fn row(self, report: &Report, method: &str) -> Result<Row> {
        let row = report.of(self.of_host()).find(|row| row.method == method).cloned();
        row.with_context(|| format!("host-sim does not know {method}"))
    }
}

/// The calibrations that everything is measured with; the first is the default one.
///
/// # Panics
/// Never: all of them are admitted.
#[must_use]
pub fn calibrations() -> Vec<Coefficients> {
    // Bare chamber and a third of the finger (fits to the paper's Table 2), then the corners of what is admitted.
    let mut others = vec![[35.3, 7.24, 0.831], [0.0, 13.79, 0.323]];
    for k in [0.0, 60.0] {
        for c1 in [5.0, 40.0] {
            others.extend([0.0, 2.0].map(|c2| [k, c1, c2]));
        }
    }
    let admitted = |[k, c1, c2]: [f64; 3]| Coefficients::from_f64_kpa(k, c1, c2).expect("within its range");
    std::iter::once(calibration::DEFAULT).chain(others.into_iter().map(admitted)).collect()
}

/// All about one direction of one method.
#[derive(Clone, Debug)]
pub struct Figures {
    /// Its identifier in `for_each_method!`.
    pub id: &'static str,
    /// Its name.
    pub method: &'static str,
    /// One line about it.
    pub summary: &'static str,
    /// Which function.
    pub direction: Direction,
    /// How its numbers travel: fixed, f32 or f64.
    pub representation: &'static str,
    /// Errors against the model in f64, and time on the host.
    pub host: Row,
    /// Instructions, and whether the host computes the same.
    pub cost: Cost,
    /// Flash of the function with all that it reaches.
    pub flash: Bytes,
    /// Flash of the preparation with all that it reaches; both directions share it.
    pub prepare_flash: Bytes,
    /// The prepared state.
    pub ram_bytes: u32,
}

/// Measures both directions of a method.
///
/// # Errors
/// When `counted` lacks one of its functions, or one of them fails on the emulated core.
pub fn measure<M: Method>(
    id: &'static str,
    counted: &mut Counted,
    footprint: &Footprint,
    host: &Report,
) -> Result<[Figures; 2]> {
    let representation = match M::Pressure::REPRESENTATION {
        model_core::methods::Representation::Fixed => "fixed",
        model_core::methods::Representation::F32 => "f32",
        model_core::methods::Representation::F64 => "f64",
    };
    let ([bend, pressure], ram_bytes) = costs::<M>(id, counted)?;
    let figures = |direction: Direction, cost: Cost| -> Result<Figures> {
        Ok(Figures {
            id,
            method: M::NAME,
            summary: M::SUMMARY,
            direction,
            representation,
            host: direction.row(host, M::NAME)?,
            cost,
            flash: footprint.of(&format!("{}_{id}", direction.name()))?,
            prepare_flash: footprint.of(&format!("prepare_{id}"))?,
            ram_bytes,
        })
    };
    Ok([figures(Direction::Bend, bend)?, figures(Direction::Pressure, pressure)?])
}

impl Figures {
    /// Name and value of every figure, names with their units.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let unit = self.direction.unit();
        let (row, cost) = (&self.host, &self.cost);
        let text = [
            ("method", self.method),
            ("summary", self.summary),
            ("direction", self.direction.name()),
            ("representation", self.representation),
        ];
        let errors = [
            ("max_error", row.errors.max),
            ("rms_error", row.errors.rms),
            ("max_error_working", row.errors.max_working),
            ("rms_error_working", row.errors.rms_working),
            ("max_error_any_calibration", row.worst_errors.max),
            ("max_error_working_any_calibration", row.worst_errors.max_working),
        ];
        let counts = [
            ("instructions_cortex_m4_worst_working", cost.worst_working),
            ("instructions_cortex_m4_worst", cost.worst),
            ("prepare_instructions_cortex_m4", cost.prepare_worst),
            ("flash_code_bytes", self.flash.code),
            ("flash_table_bytes", self.flash.tables),
            ("prepare_flash_code_bytes", self.prepare_flash.code),
            ("prepare_flash_table_bytes", self.prepare_flash.tables),
            ("ram_bytes", u64::from(self.ram_bytes)),
            ("calls", cost.calls),
            ("calls_that_differ_from_host", cost.differ),
        ];
        let mut object = Map::new();
        object.extend(text.map(|(name, value)| (name.to_owned(), json!(value))));
        object.extend(errors.map(|(name, value)| (format!("{name}_{unit}"), json!(four_digits(value)))));
        // Of one run on one host; the gate passes over it.
        object.insert("host_time_ratio".to_owned(), json!((row.host_time_ratio * 100.0).round() / 100.0));
        let mean = (cost.mean * 10.0).round() / 10.0;
        object.insert("instructions_cortex_m4_mean".to_owned(), json!(mean));
        object.extend(counts.map(|(name, value)| (name.to_owned(), json!(value))));
        Value::Object(object)
    }
}

/// Rounded to four significant digits: more would only be noise in a committed file.
#[must_use]
pub fn four_digits(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}
