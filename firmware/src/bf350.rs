//! The BF350 strain gauge in a quarter bridge with its amplifier: from converter codes to the finger's bend.
//!
//! Bridge: Vout/Vex = (GF e/4) / (1 + GF e/2), solved for the strain e. Strain to bend by a calibration table.

use crate::ise30a::mean;
use model_core::controller::Reading;
use model_core::units::Bend;

const CODES: i64 = 4096;

/// Bridge, amplifier and converter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BridgeLaw {
    /// Gauge factor, thousandths.
    pub gauge_factor_milli: u32,
    /// Gain of the amplifier.
    pub gain: u32,
    /// Bridge supply, mV.
    pub excitation_mv: u32,
    /// Amplifier's output at no strain, mV.
    pub offset_mv: u32,
    /// Converter's full scale, mV.
    pub reference_mv: u32,
    /// Below this output the wire is broken, mV.
    pub below_range_mv: u32,
    /// Above this output the amplifier is at its rail, mV.
    pub above_range_mv: u32,
}

impl BridgeLaw {
    /// GF 2.1 (usual for the BF350-3AA), gain 120, 5 V, 0.2 V offset, 3.3 V reference: assumed, to be checked against
    /// the unit.
    pub const NOMINAL: Self = Self {
        gauge_factor_milli: 2100,
        gain: 120,
        excitation_mv: 5000,
        offset_mv: 200,
        reference_mv: 3300,
        below_range_mv: 50,
        above_range_mv: 3250,
    };
}

/// A point of the calibration table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Point {
    /// Strain, 1e-9.
    pub strain_nano: i32,
    /// Bend of the whole finger there.
    pub bend: Bend,
}

/// The gauge's straight line until a unit has been measured: 25e-6 of strain for each degree (assumed). It goes on a
/// little below zero, so that a zero error shows.
pub const NOMINAL_TABLE: [Point; 3] = [
    Point { strain_nano: -500_000, bend: Bend::from_deg(-20) },
    Point { strain_nano: 0, bend: Bend::from_deg(0) },
    Point { strain_nano: 9_000_000, bend: Bend::from_deg(360) },
];

/// The driver. Its constants are worked out once, so that a tick multiplies and shifts.
#[derive(Clone, Copy, Debug)]
pub struct Bf350<const POINTS: usize> {
    /// Vout/Vex for each code, and at code zero, 2^-44.
    ratio_per_code: i64,
    ratio_origin: i64,
    /// Strain in 1e-9 for 4 Vout/Vex.
    strain_scale: i64,
    /// Mean codes at the limits of the output.
    below_range: u32,
    above_range: u32,
    table: [Point; POINTS],
    /// 2^-48 degree for each 1e-9 of strain, from each point to the next.
    slopes: [i64; POINTS],
}

impl<const POINTS: usize> Bf350<POINTS> {
    /// With its table, strains rising.
    ///
    /// # Panics
    /// When the table has fewer than two points or its strains do not rise, or the law divides by zero; in `const`
    /// evaluation, at compile time.
    #[must_use]
    pub const fn new(law: BridgeLaw, table: [Point; POINTS]) -> Self {
        assert!(POINTS >= 2, "a calibration table has at least two points");
        let mut slopes = [0; POINTS];
        let mut index = 1;
        while index < POINTS {
            let span = table[index].strain_nano as i64 - table[index - 1].strain_nano as i64;
            assert!(span > 0, "the table's strains rise");
            let rise = table[index].bend.to_bits() as i128 - table[index - 1].bend.to_bits() as i128;
            slopes[index - 1] = ((rise << 32) / span as i128) as i64;
            index += 1;
        }
        assert!(law.gauge_factor_milli > 0 && law.gain > 0 && law.excitation_mv > 0 && law.reference_mv > 0);
        let supply = law.gain as i128 * law.excitation_mv as i128;
        Self {
            ratio_per_code: (((law.reference_mv as i128) << 44) / (CODES as i128 * supply)) as i64,
            ratio_origin: -(((law.offset_mv as i128) << 44) / supply) as i64,
            strain_scale: 4_000_000_000_000 / law.gauge_factor_milli as i64,
            below_range: law.below_range_mv * CODES as u32 / law.reference_mv,
            above_range: law.above_range_mv * CODES as u32 / law.reference_mv,
            table,
            slopes,
        }
    }

    /// Strain in 1e-9 from Vout/Vex in 2^-44, within the output's limits: e = 4/GF r/(1 - 2 r).
    fn strain(&self, ratio: i64) -> i64 {
        // 1/(1 - y) = 1 + y + y^2 + y^3 with y = 2 r: at the range's end y is 0.01, and what is left out 1e-8 of it.
        let y = ratio >> 13;
        let y2 = (y * y) >> 30;
        let series = (1 << 30) + y + y2 + ((y2 * y) >> 30);
        // The ratio has 33 bits in 2^-40, the series 31.
        let bridge = ((ratio >> 4) * series) >> 34;
        (bridge * self.strain_scale) >> 36
    }

    /// Bend from the sum of `samples` conversions, by straight lines between the table's points; at most 1e-4 degree off
    /// the bridge law and the table. Outside the table or the output's limits it is out of range.
    #[must_use]
    pub fn reading(&self, sum: u32, samples: u32) -> Reading<Bend> {
        // A sum that 12-bit conversions cannot have reads as their highest.
        let samples = samples.clamp(1, 1 << 12);
        let sum = sum.min(samples * (CODES as u32 - 1));
        if sum < samples * self.below_range {
            return Reading::BelowRange;
        }
        if sum > samples * self.above_range {
            return Reading::AboveRange;
        }
        let ratio = mean(i64::from(sum) * self.ratio_per_code, samples) + self.ratio_origin;
        let strain = self.strain(ratio);
        let next = self.table.iter().skip(1);
        for ((from, to), slope) in self.table.iter().zip(next).zip(self.slopes) {
            if strain < i64::from(from.strain_nano) {
                return Reading::BelowRange;
            }
            if strain <= i64::from(to.strain_nano) {
                let way = ((strain - i64::from(from.strain_nano)) * slope) >> 32;
                return Reading::Valid(Bend::from_bits((i64::from(from.bend.to_bits()) + way) as i32));
            }
        }
        Reading::AboveRange
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The amplifier's output in volts at a bend, from the bridge law.
    fn volts(degrees: f64) -> f64 {
        let x = 2.1 * degrees * 25e-6 / 4.0;
        0.2 + 120.0 * 5.0 * x / (1.0 + 2.0 * x)
    }

    /// The bend whose output it is, by bisection.
    fn bend(output: f64) -> f64 {
        let (mut low, mut high) = (-30.0, 400.0);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if volts(middle) < output { low = middle } else { high = middle }
        }
        low
    }

    #[test]
    fn every_sum_of_sixteen_codes_is_the_bridge_laws() {
        let driver = Bf350::new(BridgeLaw::NOMINAL, NOMINAL_TABLE);
        let mut worst = 0.0_f64;
        for sum in 0..16 * 4096_u32 {
            let output = f64::from(sum) / 16.0 / 4096.0 * 3.3;
            let expected = bend(output);
            match driver.reading(sum, 16) {
                Reading::Valid(reading) => {
                    worst = worst.max((f64::from(reading.to_bits()) / 65_536.0 - expected).abs());
                }
                Reading::BelowRange => assert!(output < 0.0501 || expected < -19.9, "{sum}"),
                Reading::AboveRange => assert!(expected > 359.9, "{sum}"),
            }
        }
        assert!(worst < 1e-4, "{worst}");
    }

    #[test]
    fn any_input_is_harmless() {
        let driver = Bf350::new(BridgeLaw::NOMINAL, NOMINAL_TABLE);
        for sum in [0, 1, u32::MAX] {
            for samples in [0, 1, 16, u32::MAX] {
                let _ = driver.reading(sum, samples);
            }
        }
    }
}
