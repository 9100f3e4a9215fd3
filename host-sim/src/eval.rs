//! The core's fixed-point model, or another way to compute it, as a filter: a number a line in, a result a line out.

use crate::methods::{Direction, Entry, Prepared};
use model_core::inverse::{bend_from_pressure, pressure_from_bend};
use model_core::methods::Representation;
use model_core::units::{Bend, Coefficients, Pressure};
use std::io::{BufRead, BufReader, Read, Write};

/// Which direction of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Function {
    /// Gauge pressure in kPa to the bend of one segment in degrees.
    AngleFromPressure,
    /// Bend of one segment in degrees to gauge pressure in kPa.
    PressureFromAngle,
}

impl Function {
    const fn direction(self) -> Direction {
        match self {
            Self::AngleFromPressure => Direction::BendFromPressure,
            Self::PressureFromAngle => Direction::PressureFromBend,
        }
    }

    /// Names of the input and the result with their units, as in the JSON.
    const fn keys(self) -> [&'static str; 2] {
        match self {
            Self::AngleFromPressure => ["pressure_kpa", "bend_deg"],
            Self::PressureFromAngle => ["bend_deg", "pressure_kpa"],
        }
    }
}

/// What evaluates: the core's own functions, or a method with its representation.
pub struct Evaluator {
    coefficients: Coefficients,
    method: Option<(Box<dyn Prepared>, Representation)>,
}

impl Evaluator {
    /// The core's own functions where no method is asked for.
    #[must_use]
    pub fn new(method: Option<Entry>, coefficients: &Coefficients) -> Self {
        Self {
            coefficients: *coefficients,
            method: method.map(|entry| ((entry.prepare)(coefficients), entry.representation)),
        }
    }

    /// The result, written so that it reads back as the same number.
    fn apply(&self, function: Function, input: f64) -> String {
        match &self.method {
            None => exact(match function {
                Function::AngleFromPressure => {
                    bend_from_pressure(&self.coefficients, Pressure::from_f64_kpa(input)).to_f64()
                }
                Function::PressureFromAngle => {
                    pressure_from_bend(&self.coefficients, Bend::from_f64_deg(input)).to_f64()
                }
            }),
            Some((method, representation)) => {
                let result = method.evaluate(function.direction(), input);
                match representation {
                    Representation::Fixed => exact(result),
                    // The shortest digits that read back as this float.
                    Representation::F32 => format!("{:?}", result as f32),
                    Representation::F64 => format!("{result:?}"),
                }
            }
        }
    }
}

/// Why a filter stopped.
#[derive(Debug)]
pub enum EvalError {
    /// A line is no number the core can take; the text names line and content.
    Line(String),
    /// Reading or writing failed.
    Io(std::io::Error),
}

impl From<std::io::Error> for EvalError {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

/// The exact decimal value of a multiple of 2^-16, with at least six decimals.
///
/// ```
/// assert_eq!(host_sim::eval::exact(45.0), "45.000000");
/// assert_eq!(host_sim::eval::exact(-1.0 / 65536.0), "-0.0000152587890625");
/// ```
#[must_use]
pub fn exact(value: f64) -> String {
    let text = format!("{value:.16}");
    let six = text.len() - 10;
    let end = text.trim_end_matches('0').len().max(six);
    text[..end].to_owned()
}

fn number(line: usize, bytes: &[u8]) -> Result<f64, EvalError> {
    // What is shown is cut short: a line may be a whole binary file.
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim();
    let shown: String = text.chars().take(40).collect();
    let value = text
        .parse::<f64>()
        .ok()
        .filter(|value| value.is_finite())
        .ok_or_else(|| EvalError::Line(format!("line {line}: {shown:?} is not a number")))?;
    // The ends of I16F16, after rounding to 2^-16.
    let bits = (value * 65_536.0).round();
    if bits < f64::from(i32::MIN) || bits > f64::from(i32::MAX) {
        return Err(EvalError::Line(format!(
            "line {line}: {shown:?} is outside -32768..=32767.99998, the range of the fixed-point format"
        )));
    }
    Ok(value)
}

/// Evaluates every line of `input`; results of the lines before a bad one are written first.
///
/// # Errors
/// The first line that is not a finite number within the range of I16F16, or a failed read or write.
pub fn filter(
    function: Function,
    evaluator: &Evaluator,
    json: bool,
    input: impl Read,
    output: &mut impl Write,
) -> Result<(), EvalError> {
    let mut input = BufReader::new(input);
    let mut bytes = Vec::new();
    let mut line = 0;
    let [from, to] = function.keys();
    loop {
        bytes.clear();
        if input.read_until(b'\n', &mut bytes)? == 0 {
            output.flush()?;
            return Ok(());
        }
        line += 1;
        let value = match number(line, &bytes) {
            Ok(value) => value,
            Err(error) => {
                output.flush()?;
                return Err(error);
            }
        };
        let result = evaluator.apply(function, value);
        if json {
            writeln!(output, "{{\"{from}\":{value:?},\"{to}\":{result}}}")?;
        } else {
            writeln!(output, "{result}")?;
        }
        // A partner that waits for each answer gets it at once; a file goes through in blocks.
        if input.buffer().is_empty() {
            output.flush()?;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_shows_the_last_bit() {
        for bits in [0, 1, -1, 3, 65_536, i32::MAX, i32::MIN, 123_456_789] {
            let value = f64::from(bits) / 65_536.0;
            let text = exact(value);
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), value.to_bits(), "{text}");
            assert!(text.split_once('.').unwrap().1.len() >= 6, "{text}");
        }
    }
}
