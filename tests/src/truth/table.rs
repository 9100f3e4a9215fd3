//! The checked-in table of true values: which inputs it has, how it is written, how it is read.
//!
//! Inputs are f64, given by their bits in hexadecimal, so that none is rounded on its way; the decimal beside them is
//! the shortest that gives the same f64, for reading.

use super::{CoefficientBits, Definition, Forward};
use anyhow::{Context, Result, bail, ensure};
use astro_float_num::BigFloat;
use model_core::calibration;
use std::path::PathBuf;

/// The ratio of neighbours in the geometric series: four to an octave, with a significand as full as f64 has.
const RATIO: f64 = 1.19;

/// Finger and bare chamber of the paper, its finger by thirds, and the corners of what `Coefficients` admits, with one
/// point beside a corner. In kPa, rounded to 2⁻²⁴.
const CALIBRATIONS_KPA: [[f64; 3]; 12] = [
    [0.0, 13.84, 0.336],
    [0.0, 13.79, 0.323],
    [35.3, 7.24, 0.831],
    [0.01, 5.0, 0.0],
    [0.0, 5.0, 0.0],
    [0.0, 5.0, 2.0],
    [0.0, 40.0, 0.0],
    [0.0, 40.0, 2.0],
    [60.0, 5.0, 0.0],
    [60.0, 5.0, 2.0],
    [60.0, 40.0, 0.0],
    [60.0, 40.0, 2.0],
];

const HEADER: &str = "\
# True values of the finger's model, 50 significant digits; written by `cargo xtask truth`, see docs/truth.md.
# Inputs are exact: an f64 by its bits in hexadecimal, coefficients in units of 2^-24 kPa.
# forward,bend (f64 bits),bend (deg),alpha (rad),A (1),B (1),dA/dalpha (1/rad),dB/dalpha (1/rad)
# inverse,k (2^-24 kPa),c1 (2^-24 kPa),c2 (2^-24 kPa),pressure (f64 bits),pressure (kPa),bend (deg)
";

/// A row of the inverse's part.
#[derive(Clone, Debug)]
pub struct Inverse {
    /// k, c1, c2.
    pub coefficients: CoefficientBits,
    /// kPa, exact.
    pub pressure_kpa: f64,
    /// Degrees.
    pub bend_deg: BigFloat,
}

/// The table as it is read.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// By bend in degrees, rising.
    pub forward: Vec<(f64, Forward)>,
    /// By coefficients, then pressure, rising.
    pub inverse: Vec<Inverse>,
}

/// Where the table is checked in.
#[must_use]
pub fn path() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/data/truth.csv"))
}

/// The calibrations of the inverse's part, sorted.
#[must_use]
pub fn calibrations() -> Vec<CoefficientBits> {
    let default = calibration::DEFAULT;
    let mut all = CALIBRATIONS_KPA.map(|kpa| kpa.map(|c| (c * f64::from(1 << 24)).round() as i32)).to_vec();
    all.push([default.k().to_bits(), default.c1().to_bits(), default.c2().to_bits()]);
    all.sort_unstable();
    all.dedup();
    all
}

/// `first` times [`RATIO`] again and again, below `end`. Only multiplications: the same on every machine.
fn geometric(first: f64, end: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(first), |value| Some(value * RATIO)).take_while(move |&value| value < end)
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values.dedup_by_key(|value| value.to_bits());
    values
}

/// The bends of the forward part, in degrees.
#[must_use]
pub fn bends_deg() -> Vec<f64> {
    let bit = 1.0 / 65_536.0;
    // From 0 up, a grid, and the way to the pole.
    let mut bends: Vec<f64> = geometric(2.0_f64.powi(-60), 1.0).collect();
    bends.extend((1..=1700).map(|tenths| f64::from(tenths) / 10.0));
    bends.extend(geometric(2.0_f64.powi(-40), 10.0).map(|distance| 180.0 - distance));
    // The ends of table segments, every 8 degrees and every eighth of an octave of the distance to 180 degrees.
    let eights = (1..=21).map(|index| 8.0 * f64::from(index)).chain([170.0]);
    let octaves = (3..=7).flat_map(|m| (0..8).map(move |j| 180.0 - 2.0_f64.powi(m) * (1.0 + f64::from(j) / 8.0)));
    let ends = eights.chain(octaves).filter(|&end| end > bit && end <= 170.0);
    bends.extend(ends.flat_map(|end| [end - bit, end, end + bit]));
    sorted(bends)
}

/// The pressures of the inverse's part, in kPa.
#[must_use]
pub fn pressures_kpa() -> Vec<f64> {
    let bit = 1.0 / 65_536.0;
    let mut pressures: Vec<f64> = (1..=16).map(|bits| f64::from(bits) * bit).collect();
    pressures
        .extend((-16..=10).flat_map(|e| (0..4).map(move |quarter| 2.0_f64.powi(e) * (1.0 + f64::from(quarter) / 4.0))));
    pressures.extend(geometric(bit, 1000.0));
    pressures.extend([30.0, 60.0, 90.0, 120.0, 150.0, 1000.0]);
    sorted(pressures)
}

/// The forward row of a bend in degrees.
#[must_use]
pub fn forward_row(definition: &mut Definition, bend_deg: f64) -> String {
    let Forward { alpha, a, b, a_slope, b_slope } = definition.forward(bend_deg);
    let values = [alpha, a, b, a_slope, b_slope].map(|value| definition.decimal(&value)).join(",");
    format!("forward,{:016x},{bend_deg:?},{values}", bend_deg.to_bits())
}

/// The inverse's row of a calibration and a pressure in kPa.
#[must_use]
pub fn inverse_row(definition: &mut Definition, coefficients: CoefficientBits, pressure_kpa: f64) -> String {
    let [k, c1, c2] = coefficients;
    let bend = definition.inverse(coefficients, pressure_kpa);
    let bits = pressure_kpa.to_bits();
    format!("inverse,{k},{c1},{c2},{bits:016x},{pressure_kpa:?},{}", definition.decimal(&bend))
}

/// The whole file; `done` is called after every row.
#[must_use]
pub fn write(mut done: impl FnMut()) -> String {
    let mut definition = Definition::new();
    let mut text = HEADER.to_owned();
    let mut push = |row: String| {
        text += &row;
        text.push('\n');
        done();
    };
    for bend in bends_deg() {
        push(forward_row(&mut definition, bend));
    }
    for coefficients in calibrations() {
        for pressure in pressures_kpa() {
            push(inverse_row(&mut definition, coefficients, pressure));
        }
    }
    text
}

/// How many rows [`write()`] makes.
#[must_use]
pub fn rows() -> usize {
    bends_deg().len() + calibrations().len() * pressures_kpa().len()
}

/// Reads the checked-in table.
///
/// # Errors
/// Names the line that cannot be read.
pub fn read() -> Result<Table> {
    let path = path();
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("cannot read {}: make it with `cargo xtask truth`", path.display()))?;
    parse(&text)
}

fn parse(text: &str) -> Result<Table> {
    let mut definition = Definition::new();
    let mut table = Table::default();
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.starts_with('#')) {
        parse_row(&mut definition, line, &mut table).with_context(|| format!("truth.csv, line {}", index + 1))?;
    }
    Ok(table)
}

fn parse_row(definition: &mut Definition, line: &str, table: &mut Table) -> Result<()> {
    let float = |bits: &str, decimal: &str| -> Result<f64> {
        let value = f64::from_bits(u64::from_str_radix(bits, 16).with_context(|| format!("{bits}: not f64 bits"))?);
        ensure!(decimal.parse() == Ok(value), "{bits} is {value}, not {decimal}");
        Ok(value)
    };
    let mut number = |decimal: &str| -> Result<BigFloat> {
        let value = definition.parse(decimal);
        ensure!(!value.is_nan(), "{decimal}: not a number");
        Ok(value)
    };
    match line.split(',').collect::<Vec<_>>()[..] {
        ["forward", bits, decimal, alpha, a, b, a_slope, b_slope] => {
            let forward = Forward {
                alpha: number(alpha)?,
                a: number(a)?,
                b: number(b)?,
                a_slope: number(a_slope)?,
                b_slope: number(b_slope)?,
            };
            table.forward.push((float(bits, decimal)?, forward));
        }
        ["inverse", k, c1, c2, bits, decimal, bend] => table.inverse.push(Inverse {
            coefficients: [k.parse()?, c1.parse()?, c2.parse()?],
            pressure_kpa: float(bits, decimal)?,
            bend_deg: number(bend)?,
        }),
        _ => bail!("neither a forward nor an inverse row"),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broken_line_is_named() {
        let error = |line: &str| format!("{:#}", parse(&format!("# header\n{line}\n")).unwrap_err());
        assert!(error("sideways,1").contains("line 2"));
        assert!(error("inverse,0,1,2,3ff0000000000000,1.5,1.0e0").contains("not 1.5"));
        assert!(error("inverse,0,1,2,3ff0000000000000,1.0,x").contains("not a number"));
    }
}
