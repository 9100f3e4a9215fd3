//! Best polynomials on uniform segments: the error levelled by Remez' exchange (see `remez`), Horner in fixed point.
//!
//! Bend from pressure: 63 segments of 16 kPa, degree 5. Pressure from bend: 85 segments of 2 degrees, degree 4, each with as
//! many fractional bits as its coefficients leave room for. The segments' ends do not join exactly. No polynomial follows the
//! square root at P = 0: the first segment's error is 3 % of its rise, whatever the exchange does, and P = 0 itself is told
//! apart. State: 1512 + 1785 bytes, 2 KiB at most for each direction.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core minimax -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 8.8e-1 | 4.7e-5 |
//! | bare chamber | 2.3e-4 | 2.5e-5 |
//! | worst corner | 1.5e0 | 6.9e-4 |

use super::remez::{GRID, grid, minimax};
use super::{F64Newton, Method, TABLE_LIMIT_DEG, fixed};
use crate::inverse::{BEND_LIMIT, PRESSURE_LIMIT};
use crate::units::{Bend, Coefficients, Pressure};

/// A segment of the pressure is 2 to this power of 2⁻¹⁶ kPa.
const PRESSURE_SHIFT: u32 = 20;
/// A segment of the bend is 2 to this power of 2⁻¹⁶ degree.
const BEND_SHIFT: u32 = 17;
/// 1000 kPa in segments, rounded up.
const PRESSURES: usize = (PRESSURE_LIMIT.to_bits() >> PRESSURE_SHIFT) as usize + 1;
/// 170 degrees in segments.
const BENDS: usize = (BEND_LIMIT.to_bits() >> BEND_SHIFT) as usize;

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Minimax {
    /// Q22.
    bends: [[i32; 6]; PRESSURES],
    pressures: PressureTable,
}

/// Pressure from bend; `minimax-root` has the same.
#[derive(Clone, Copy, Debug)]
pub struct PressureTable {
    segments: [[i32; 5]; BENDS],
    fraction_bits: [u8; BENDS],
}

/// Horner at the offset of `input` from its segment's middle in half widths.
pub fn horner<const N: usize>(coefficients: &[i32; N], input: u32, shift: u32) -> i32 {
    let u = ((input << (32 - shift)) ^ 0x8000_0000) as i32;
    coefficients
        .iter()
        .rev()
        .fold(0, |sum: i32, &c| c.wrapping_add(((i64::from(sum) * i64::from(u) + (1 << 30)) >> 31) as i32))
}

/// The best polynomial on the segment `index`.
pub fn segment<const N: usize>(points: &[f64; GRID], index: usize, width: f64, of: impl Fn(f64) -> f64) -> [f64; N] {
    minimax(points, &points.map(|x| of((index as f64 + f64::midpoint(x, 1.0)) * width)))
}

impl PressureTable {
    /// For a calibration.
    pub fn new(exact: &F64Newton, points: &[f64; GRID]) -> Self {
        let mut table = Self { segments: [[0; 5]; BENDS], fraction_bits: [0; BENDS] };
        let width = f64::from(1 << BEND_SHIFT) / 65_536.0;
        for (index, (segment, bits)) in table.segments.iter_mut().zip(&mut table.fraction_bits).enumerate() {
            let best: [f64; 5] = self::segment(points, index, width, |bend| exact.pressure_from_bend(bend));
            // Every partial sum stays below the sum of sizes, and that below 2³⁰.
            let most = best.iter().map(|c| c.abs()).sum::<f64>();
            let mut fraction_bits = 24;
            while fraction_bits > 0 && most * f64::from(1_u32 << fraction_bits) >= f64::from(1 << 30) {
                fraction_bits -= 1;
            }
            *bits = fraction_bits;
            *segment = best.map(|c| fixed(c, u32::from(fraction_bits)));
        }
        table
    }

    /// The pressure at a bend; level beyond the domain.
    pub fn pressure(&self, bend: Bend) -> Pressure {
        // The end itself belongs to the last segment.
        let most = Bend::from_bits(BEND_LIMIT.to_bits() - 1);
        let bits = bend.clamp(Bend::ZERO, most).to_bits() as u32;
        if bits == 0 {
            return Pressure::ZERO;
        }
        let index = (bits >> BEND_SHIFT) as usize;
        let (Some(segment), Some(&fraction_bits)) = (self.segments.get(index), self.fraction_bits.get(index)) else {
            return Pressure::MAX;
        };
        let pressure = i64::from(horner(segment, bits, BEND_SHIFT).max(0)) << 16;
        let rounded = (pressure + ((1_i64 << fraction_bits) >> 1)) >> fraction_bits;
        Pressure::from_bits(i32::try_from(rounded).unwrap_or(i32::MAX))
    }
}

impl Method for Minimax {
    const NAME: &'static str = "minimax";
    const SUMMARY: &'static str = "fixed point, uniform segments, best polynomials by Remez' exchange";
    type Pressure = Pressure;
    type Bend = Bend;

    fn prepare(coefficients: &Coefficients) -> Self {
        let exact = F64Newton::prepare(coefficients);
        let points = grid();
        let mut bends = [[0; 6]; PRESSURES];
        let width = f64::from(1 << PRESSURE_SHIFT) / 65_536.0;
        for (index, bend) in bends.iter_mut().enumerate() {
            let best = segment(&points, index, width, |pressure| exact.solve(pressure, TABLE_LIMIT_DEG));
            *bend = best.map(|c: f64| fixed(c, 22));
        }
        Self { bends, pressures: PressureTable::new(&exact, &points) }
    }

    fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        let bits = pressure.clamp(Pressure::ZERO, PRESSURE_LIMIT).to_bits() as u32;
        if bits == 0 {
            return Bend::ZERO;
        }
        let Some(segment) = self.bends.get((bits >> PRESSURE_SHIFT) as usize) else { return BEND_LIMIT };
        let bend = horner(segment, bits, PRESSURE_SHIFT).saturating_add(1 << 5) >> 6;
        Bend::from_bits(bend).clamp(Bend::ZERO, BEND_LIMIT)
    }

    fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        self.pressures.pressure(bend)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check};

    #[test]
    fn errors_against_f64() {
        check::<Minimax>(&[
            Limits { bend_deg: 1.3e0, pressure_kpa: 7.0e-5 },
            Limits { bend_deg: 3.4e-4, pressure_kpa: 3.7e-5 },
            Limits { bend_deg: 2.2e0, pressure_kpa: 1.0e-3 },
        ]);
    }
}
