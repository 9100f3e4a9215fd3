//! Calls on the emulated core: instructions, and whether the results are the host's to the last bit.

use super::samples::{domain_end, even, hard, joints, working_end};
use super::{Direction, calibrations};
use crate::counted::{Arguments, Counted, Function, Outcome};
use anyhow::{Context, Result, ensure};
use core::f64::consts::PI;
use model_core::methods::{Method, Quantity, Representation};
use model_core::units::Coefficients;

/// Inputs in the working range of the default calibration; the whole domain gets half, other calibrations a quarter.
const SAMPLES: u32 = 2000;

/// Numbers of the calibrations that methods are called with: the default one, the bare chamber, three corners. Building
/// a table takes the emulator up to a second.
const CALLED: [usize; 5] = [0, 1, 3, 9, 10];

/// One direction's instructions.
#[derive(Clone, Debug, Default)]
pub struct Cost {
    /// Mean over the working range, evenly, with the default calibration.
    pub mean: f64,
    /// Worst in the working range, five calibrations.
    pub worst_working: u64,
    /// Worst over the whole domain and beyond it, five calibrations.
    pub worst: u64,
    /// Worst preparation over the same.
    pub prepare_worst: u64,
    /// Calls that all of this comes from.
    pub calls: u64,
    /// How many of them gave another result than the host.
    pub differ: u64,
    /// The first of those, for people.
    pub first_difference: Option<String>,
}

/// One direction of a method in the ELF.
struct Callee {
    direction: Direction,
    address: Function,
    state: u32,
}

/// State and value in the registers that they travel in.
pub fn passed<Q: Quantity>(state: u32, value: Q) -> Arguments {
    let value = value.to_f64();
    let (bits, float) = match Q::REPRESENTATION {
        Representation::Fixed => (((value * 65_536.0) as i32).cast_unsigned(), 0),
        Representation::F32 => (0, u64::from((value as f32).to_bits())),
        Representation::F64 => (0, value.to_bits()),
    };
    Arguments { core: [state, bits, 0, 0], float }
}

/// The value that a function has left.
fn returned<Q: Quantity>(outcome: &Outcome) -> f64 {
    match Q::REPRESENTATION {
        Representation::Fixed => f64::from(outcome.core[0].cast_signed()) / 65_536.0,
        Representation::F32 => f64::from(f32::from_bits(outcome.float as u32)),
        Representation::F64 => f64::from_bits(outcome.float),
    }
}

impl Callee {
    /// Result on the emulated core, result on the host, instructions.
    fn both<M: Method>(&self, counted: &mut Counted, method: &M, input: f64) -> Result<(f64, f64, u64)> {
        let (arguments, host) = match self.direction {
            Direction::Bend => {
                let input = M::Pressure::from_f64(input);
                (passed(self.state, input), method.bend_from_pressure(input).to_f64())
            }
            Direction::Pressure => {
                let input = M::Bend::from_f64(input);
                (passed(self.state, input), method.pressure_from_bend(input).to_f64())
            }
        };
        let outcome = counted.call(self.address, &arguments)?;
        let emulated = match self.direction {
            Direction::Bend => returned::<M::Bend>(&outcome),
            Direction::Pressure => returned::<M::Pressure>(&outcome),
        };
        Ok((emulated, host, outcome.instructions))
    }
}

/// Room for a method's state: address and bytes.
///
/// # Errors
/// When `counted` does not have the method, or the RAM has no room for it.
pub fn room(id: &str, counted: &mut Counted) -> Result<(u32, u32)> {
    let layout = counted.function(&format!("layout_{id}"))?;
    let [bytes, alignment] = counted.call(layout, &Arguments::default())?.core;
    Ok((counted.room(bytes, alignment)?, bytes))
}

/// Prepares a method on the emulated core; returns the instructions that it takes.
///
/// # Errors
/// When `counted` does not have the method, or it fails there.
pub fn prepare(id: &str, counted: &mut Counted, state: u32, coefficients: &Coefficients) -> Result<u64> {
    let prepare = counted.function(&format!("prepare_{id}"))?;
    let [k, c1, c2] = [coefficients.k(), coefficients.c1(), coefficients.c2()].map(|c| c.to_bits().cast_unsigned());
    let call = counted.call(prepare, &Arguments { core: [state, k, c1, c2], float: 0 });
    let outcome = call.with_context(|| format!("prepare_{id} with {coefficients:?}"))?;
    ensure!(outcome.core[0] == 1, "prepare_{id} refuses {coefficients:?}");
    Ok(outcome.instructions)
}

/// Measures both directions of a method; returns the state's size in bytes as well.
///
/// # Errors
/// When `counted` lacks one of its functions, or one of them fails on the emulated core.
pub fn costs<M: Method>(id: &str, counted: &mut Counted) -> Result<([Cost; 2], u32)> {
    let (state, bytes) = room(id, counted)?;
    let mut costs = [Cost::default(), Cost::default()];
    for (index, coefficients) in calibrations().iter().enumerate().filter(|(index, _)| CALLED.contains(index)) {
        // Tables take their time, so that one preparation serves both directions.
        let prepare = prepare(id, counted, state, coefficients)?;
        let method = M::prepare(coefficients);
        for (direction, cost) in Direction::BOTH.into_iter().zip(&mut costs) {
            cost.prepare_worst = cost.prepare_worst.max(prepare);
            let address = counted.function(&format!("{}_{id}", direction.name()))?;
            let callee = Callee { direction, address, state };
            call_all(&callee, counted, &method, coefficients, index == 0, cost)
                .with_context(|| format!("{} {} with {coefficients:?}", M::NAME, direction.name()))?;
        }
    }
    Ok((costs, bytes))
}

fn call_all<M: Method>(
    callee: &Callee,
    counted: &mut Counted,
    method: &M,
    coefficients: &Coefficients,
    default: bool,
    cost: &mut Cost,
) -> Result<()> {
    let direction = callee.direction;
    let count = if default { SAMPLES } else { SAMPLES / 4 };
    let real = coefficients.to_f64_kpa();
    let working_end = working_end(direction, &real);
    let working = even(count, working_end);
    let domain = domain_end(direction);
    // Below zero and beyond the domain there are answers too.
    let edges = [-1.0 / 65_536.0, -50.0, domain + 1.0];
    let rest = even(count / 2, domain).chain(hard(count / 5, domain)).chain(joints(direction, &real)).chain(edges);
    let inputs = working.map(|input| (input, default)).chain(rest.map(|input| (input, false)));
    for (input, in_mean) in inputs {
        let (emulated, host, instructions) =
            callee.both(counted, method, input).with_context(|| format!("for an input of {input}"))?;
        cost.calls += 1;
        cost.worst = cost.worst.max(instructions);
        if input <= working_end {
            cost.worst_working = cost.worst_working.max(instructions);
        }
        if in_mean {
            cost.mean += instructions as f64 / f64::from(SAMPLES);
        }
        let same = emulated.to_bits() == host.to_bits() || emulated.is_nan() && host.is_nan();
        if !same {
            cost.differ += 1;
            cost.first_difference.get_or_insert_with(|| {
                format!("{emulated} on the emulated core, {host} on the host for {input} with {coefficients:?}")
            });
        }
    }
    Ok(())
}

/// The reference function: idsp's sine and cosine, an angle to both of them.
#[derive(Clone, Debug)]
pub struct Cossin {
    /// Worst over the calls.
    pub instructions_worst: u64,
    /// Mean over the calls.
    pub instructions_mean: f64,
    /// Worst error of either output, in parts of 2³¹.
    pub max_error_full_scale: f64,
    /// The same in parts of the amplitude that idsp's own tests take as full scale, 2³¹ − 0.85·2¹⁵.
    pub max_error_own_scale: f64,
    /// Whether the host computed the same for all.
    pub differ: u64,
}

/// Counts [`idsp::cossin`] over the circle, and measures its error on the host.
///
/// # Errors
/// When the function fails on the emulated core.
pub fn cossin(counted: &mut Counted) -> Result<Cossin> {
    /// Phases on the emulated core, and how many between two of them on the host.
    const CALLS: u32 = 1 << 12;
    const DENSITY: u32 = 1 << 8;
    let function = counted.function("cossin")?;
    let mut figures = Cossin {
        instructions_worst: 0,
        instructions_mean: 0.0,
        max_error_full_scale: 0.0,
        max_error_own_scale: 0.0,
        differ: 0,
    };
    for index in 0..CALLS * DENSITY {
        // Odd steps through the circle, so that the low bits of the phase vary.
        let phase = index.wrapping_mul(u32::MAX / (CALLS * DENSITY)).cast_signed();
        let host = idsp::cossin(phase);
        let (sin, cos) = (f64::from(phase) / 2_f64.powi(31) * PI).sin_cos();
        let error = |scale: f64| {
            let errors = [f64::from(host.0) / scale - cos, f64::from(host.1) / scale - sin];
            errors.into_iter().map(f64::abs).fold(0.0, f64::max)
        };
        figures.max_error_full_scale = figures.max_error_full_scale.max(error(2_f64.powi(31)));
        figures.max_error_own_scale = figures.max_error_own_scale.max(error(2_f64.powi(31) - 0.85 * 32_768.0));
        if index % DENSITY == 0 {
            let core = [phase.cast_unsigned(), 0, 0, 0];
            let outcome = counted.call(function, &Arguments { core, float: 0 })?;
            figures.instructions_worst = figures.instructions_worst.max(outcome.instructions);
            figures.instructions_mean += outcome.instructions as f64 / f64::from(CALLS);
            figures.differ += u64::from(outcome.core.map(u32::cast_signed) != [host.0, host.1]);
        }
    }
    Ok(figures)
}
