//! Linear interpolation on floating segments: narrow where the bend rises like a square root, wide where it is level.
//!
//! Bend from pressure: octaves of the pressure from 2⁻¹⁶ to 1000 kPa, 64 segments each in the uppermost four and half as
//! many in every four below, because the error of a square root falls by four in as many octaves. Pressure from bend:
//! octaves of 180 degrees less the bend, towards the pole. Values are exact at the ends of all segments. State: 2016 +
//! 1940 bytes, 2 KiB at most for each direction.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees (`cargo test -p model-core floating_linear -- --nocapture`):
//!
//! | Calibration | Bend, degrees | Pressure, kPa |
//! |---|---|---|
//! | default | 2.1e-3 | 2.7e-1 |
//! | bare chamber | 2.1e-3 | 2.6e-1 |
//! | worst corner | 8.0e-3 | 2.3e-1 |

use super::floating::Layout;
use super::{F64Newton, Method, TABLE_LIMIT_DEG, fixed};
use crate::inverse::{BEND_LIMIT, PRESSURE_LIMIT};
use crate::units::{Bend, Coefficients, Pressure};

/// 1000 kPa in 2⁻¹⁶ kPa.
const MOST_PRESSURE: u32 = PRESSURE_LIMIT.to_bits() as u32;
/// 180 degrees in 2⁻¹⁶ degree.
const POLE: u32 = 180 << 16;
/// 180 degrees less the largest bend.
const LEAST_REST: u32 = POLE - BEND_LIMIT.to_bits() as u32;

const PRESSURES: Layout<26> =
    Layout::new(0, [0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 6, 6, 6, 6], 1, MOST_PRESSURE);
const RESTS: Layout<5> = Layout::new(19, [6, 6, 6, 8, 7], LEAST_REST, POLE);

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct FloatingLinear {
    /// Bends in Q22.
    bends: [i32; PRESSURES.count() + 1],
    /// Pressures in Q16.
    pressures: [i32; RESTS.count() + 1],
}

/// Between the values at the ends of segment `index`.
fn interpolate<const OCTAVES: usize>(layout: &Layout<OCTAVES>, values: &[i32], input: u32) -> i32 {
    let place = layout.place(input);
    let low = values.get(place.index).copied().unwrap_or(0);
    let high = values.get(place.index + 1).copied().unwrap_or(low);
    let rise = i64::from(high).wrapping_sub(i64::from(low)).wrapping_mul(i64::from(place.offset));
    low.wrapping_add((rise >> place.shift) as i32)
}

/// The values at the ends of all segments.
fn table<const OCTAVES: usize>(layout: &Layout<OCTAVES>, smallest: u32, values: &mut [i32], of: impl Fn(u32) -> i32) {
    layout.for_each(smallest, |index, low, width| {
        for (index, input) in [(index, low), (index + 1, low + width)] {
            if let Some(value) = values.get_mut(index) {
                *value = of(input);
            }
        }
    });
}

impl Method for FloatingLinear {
    const NAME: &'static str = "floating-linear";
    const SUMMARY: &'static str = "fixed point, floating segments, linear interpolation";
    type Pressure = Pressure;
    type Bend = Bend;

    fn prepare(coefficients: &Coefficients) -> Self {
        let exact = F64Newton::prepare(coefficients);
        let mut method = Self { bends: [0; PRESSURES.count() + 1], pressures: [0; RESTS.count() + 1] };
        table(&PRESSURES, 1, &mut method.bends, |bits| {
            fixed(exact.solve(f64::from(bits) / 65_536.0, TABLE_LIMIT_DEG), 22)
        });
        table(&RESTS, LEAST_REST, &mut method.pressures, |bits| {
            fixed(exact.pressure_from_bend(f64::from(POLE.saturating_sub(bits)) / 65_536.0), 16)
        });
        method
    }

    fn bend_from_pressure(&self, pressure: Pressure) -> Bend {
        match u32::try_from(pressure.to_bits()) {
            Ok(bits) if bits > 0 => {
                let bend = interpolate(&PRESSURES, &self.bends, bits.min(MOST_PRESSURE));
                Bend::from_bits((bend + (1 << 5)) >> 6).min(BEND_LIMIT)
            }
            _ => Bend::ZERO,
        }
    }

    fn pressure_from_bend(&self, bend: Bend) -> Pressure {
        let bits = bend.clamp(Bend::ZERO, BEND_LIMIT).to_bits() as u32;
        Pressure::from_bits(interpolate(&RESTS, &self.pressures, POLE - bits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check};

    #[test]
    fn errors_against_f64() {
        check::<FloatingLinear>(&[
            Limits { bend_deg: 3.2e-3, pressure_kpa: 4.1e-1 },
            Limits { bend_deg: 3.1e-3, pressure_kpa: 4.0e-1 },
            Limits { bend_deg: 1.2e-2, pressure_kpa: 3.4e-1 },
        ]);
    }
}
