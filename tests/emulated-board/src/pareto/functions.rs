//! Functions of model-core that are no method of the model: what they cost on the Cortex-M4.

use crate::counted::{Arguments, Counted};
use crate::footprint::{Bytes, Footprint};
use anyhow::{Context, Result};
use model_core::force::finger_force;
use model_core::kinematics::{self, Chain, Point, micromath};
use model_core::units::{Bend, Length, Pressure};
use serde_json::{Value, json};

/// From what posture the inverse starts, degrees.
const FROM: Bend = Bend::from_deg(30);

/// What one costs.
#[derive(Clone, Debug)]
pub struct FunctionCost {
    /// Its path in model-core, and with which inputs where that matters.
    pub function: &'static str,
    /// How many calls the figures are of.
    pub calls: usize,
    /// Mean over the calls.
    pub instructions_mean: f64,
    /// Worst of the calls.
    pub instructions_worst: u64,
    /// How many calls gave another result than the host.
    pub differ: usize,
    /// Flash of the function with all that it reaches.
    pub flash: Bytes,
}

impl FunctionCost {
    /// Name and value of every figure.
    #[must_use]
    pub fn to_json(&self) -> Value {
        json!({
            "function": self.function,
            "calls": self.calls,
            "instructions_cortex_m4_mean": (self.instructions_mean * 10.0).round() / 10.0,
            "instructions_cortex_m4_worst": self.instructions_worst,
            "calls_that_differ_from_host": self.differ,
            "flash_code_bytes": self.flash.code,
            "flash_table_bytes": self.flash.tables,
        })
    }
}

/// A function's symbol in `counted`, what it is called with, and what the host makes of that.
struct Callee {
    function: &'static str,
    symbol: &'static str,
    inputs: Vec<[i32; 3]>,
    host: fn([i32; 3]) -> [i32; 2],
}

/// Every combination of three values from 0 to `end` by `step`, 2⁻¹⁶.
fn grid(end: i32, step: usize) -> Vec<[i32; 3]> {
    let values = || (0..=end).step_by(step).map(|value| value << 16);
    values().flat_map(|one| values().flat_map(move |two| values().map(move |three| [one, two, three]))).collect()
}

fn fingertip(bends: [i32; 3]) -> [i32; 2] {
    let Point { x, y } = kinematics::fingertip(&Chain::PAPER, &bends.map(Bend::from_bits)).point;
    [x.to_bits(), y.to_bits()]
}

fn fingertip_micromath(bends: [i32; 3]) -> [i32; 2] {
    let tip = micromath::fingertip(&Chain::PAPER, &bends.map(Bend::from_bits));
    [tip.x_mm, tip.y_mm].map(|mm| mm.to_bits().cast_signed())
}

fn bends([x, y, from]: [i32; 3]) -> [i32; 2] {
    let [x, y] = [x, y].map(Length::from_bits);
    let found = kinematics::bends(&Chain::PAPER, Point { x, y }, &[Bend::from_bits(from); 3]);
    let [proximal, middle, distal] = found.unwrap_or_else(|unreachable| unreachable.nearest).map(Bend::to_bits);
    [proximal, middle.wrapping_add(distal.wrapping_mul(3))]
}

fn force(pressures: [i32; 3]) -> [i32; 2] {
    [finger_force(&pressures.map(Pressure::from_bits)).to_bits(), 0]
}

/// All of them.
fn callees() -> Vec<Callee> {
    let places = |beyond_percent: i64| -> Vec<[i32; 3]> {
        let place = |bends: [i32; 3]| fingertip(bends).map(|bits| (i64::from(bits) * beyond_percent / 100) as i32);
        grid(110, 22).into_iter().map(place).map(|[x, y]| [x, y, FROM.to_bits()]).collect()
    };
    let out_of_reach = |&[x, y, _]: &[i32; 3]| {
        kinematics::bends(&Chain::PAPER, Point { x: Length::from_bits(x), y: Length::from_bits(y) }, &[FROM; 3])
            .is_err()
    };
    let beyond = places(150).into_iter().filter(out_of_reach).step_by(8).collect();
    let callee = |function, symbol, inputs, host| Callee { function, symbol, inputs, host };
    vec![
        callee("kinematics::fingertip", "fingertip", grid(110, 10), fingertip),
        callee("kinematics::micromath::fingertip", "fingertip_micromath", grid(110, 10), fingertip_micromath),
        callee("kinematics::bends, within reach", "bends", places(100), bends),
        callee("kinematics::bends, out of reach", "bends", beyond, bends),
        callee("force::finger_force", "force", grid(150, 10), force),
    ]
}

/// Counts all of them, and compares their results with the host's.
///
/// # Errors
/// When `counted` lacks one, or one fails on the emulated core.
pub fn functions(counted: &mut Counted, footprint: &Footprint) -> Result<Vec<FunctionCost>> {
    callees().into_iter().map(|callee| cost(&callee, counted, footprint)).collect()
}

fn cost(callee: &Callee, counted: &mut Counted, footprint: &Footprint) -> Result<FunctionCost> {
    let address = counted.function(callee.symbol)?;
    let (mut sum, mut worst, mut differ) = (0, 0, 0);
    for &input in &callee.inputs {
        let [a, b, c] = input.map(i32::cast_unsigned);
        let outcome = counted
            .call(address, &Arguments { core: [a, b, c, 0], float: 0 })
            .with_context(|| format!("{} of {input:?}", callee.function))?;
        sum += outcome.instructions;
        worst = outcome.instructions.max(worst);
        differ += usize::from(outcome.core.map(u32::cast_signed) != (callee.host)(input));
    }
    let calls = callee.inputs.len();
    Ok(FunctionCost {
        function: callee.function,
        calls,
        instructions_mean: sum as f64 / calls as f64,
        instructions_worst: worst,
        differ,
        flash: footprint.of(callee.symbol)?,
    })
}
