//! The BF350 strain gauge in a quarter bridge with its amplifier: from converter codes to the finger's bend.
//!
//! Bridge: Vout/Vex = (GF e/4) / (1 + GF e/2), solved for the strain e. Strain to bend by a calibration table.

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

    /// Strain in 1e-9 from the sum of `samples` conversions; at most 3e-9 off the bridge law for 16 samples.
    ///
    /// Below and above the limits of the output it is out of range.
    #[must_use]
    pub fn strain(&self, sum: u32, samples: u32) -> Reading<i64> {
        // A tick has 16 conversions; twice as many leave the arithmetic below room.
        let samples = i64::from(samples.clamp(1, 32));
        let sum = i64::from(sum).min(samples * (CODES - 1));
        let full = samples * CODES;
        // Microvolts times `full`.
        let output = sum * i64::from(self.reference_mv) * 1000;
        if output < full * i64::from(self.below_range_mv) * 1000 {
            return Reading::BelowRange;
        }
        if output > full * i64::from(self.above_range_mv) * 1000 {
            return Reading::AboveRange;
        }
        // r = Vout/Vex = bridge / supply; e = 4 r / (GF (1 - 2 r)).
        let bridge = output - full * i64::from(self.offset_mv) * 1000;
        let supply = full * i64::from(self.excitation_mv) * 1000 * i64::from(self.gain);
        let (numerator, denominator) = (bridge, supply - 2 * bridge);
        // Strain in 1e-9 is 4e12/GF[thousandths] times the quotient. Scaled down by 2^8 first, numerator and denominator
        // keep 30 bits and more, and their product stays within 63.
        let scale = 4_000_000_000_000_i64.checked_div(i64::from(self.gauge_factor_milli)).unwrap_or(0);
        let strain = (numerator >> 8).saturating_mul(scale).checked_div((denominator >> 8).max(1));
        Reading::Valid(strain.unwrap_or(0))
    }
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

/// The driver.
#[derive(Clone, Copy, Debug)]
pub struct Bf350 {
    law: BridgeLaw,
    table: &'static [Point],
}

impl Bf350 {
    /// With its table, strains rising.
    ///
    /// # Panics
    /// When the table has fewer than two points or its strains do not rise; in `const` evaluation, at compile time.
    #[must_use]
    pub const fn new(law: BridgeLaw, table: &'static [Point]) -> Self {
        assert!(table.len() >= 2, "a calibration table has at least two points");
        let mut index = 1;
        while index < table.len() {
            assert!(table[index - 1].strain_nano < table[index].strain_nano, "the table's strains rise");
            index += 1;
        }
        Self { law, table }
    }

    /// Bend from the sum of `samples` conversions, by straight lines between the table's points, rounded down to
    /// 2^-16 degree; outside the table it is out of range.
    #[must_use]
    pub fn reading(&self, sum: u32, samples: u32) -> Reading<Bend> {
        let strain = match self.law.strain(sum, samples) {
            Reading::Valid(strain) => strain,
            Reading::BelowRange => return Reading::BelowRange,
            Reading::AboveRange => return Reading::AboveRange,
        };
        for pair in self.table.windows(2) {
            let [from, to] = pair else { continue };
            let (low, high) = (i64::from(from.strain_nano), i64::from(to.strain_nano));
            if strain < low {
                return Reading::BelowRange;
            }
            if strain <= high {
                let rise = i64::from(to.bend.to_bits()) - i64::from(from.bend.to_bits());
                let share = (strain - low).saturating_mul(rise).checked_div(high - low).unwrap_or(0);
                return Reading::Valid(Bend::from_bits((i64::from(from.bend.to_bits()) + share) as i32));
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
        let driver = Bf350::new(BridgeLaw::NOMINAL, &NOMINAL_TABLE);
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
        let driver = Bf350::new(BridgeLaw::NOMINAL, &NOMINAL_TABLE);
        for sum in [0, 1, u32::MAX] {
            for samples in [0, 1, 16, u32::MAX] {
                let _ = driver.reading(sum, samples);
            }
        }
    }
}
