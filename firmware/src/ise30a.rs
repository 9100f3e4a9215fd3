//! The ISE30A pressure sensor's analogue output; its switch output is an [`crate::alarm::AlarmInput`].

use model_core::controller::Reading;
use model_core::units::Pressure;

/// Codes of the 12-bit converter.
const CODES: u32 = 4096;

/// The analogue output's law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AnalogueLaw {
    /// Output at 0 kPa, mV.
    pub zero_mv: u32,
    /// Slope, uV per kPa.
    pub slope_uv_per_kpa: u32,
    /// Below this output the wire is broken, mV.
    pub below_range_mv: u32,
    /// Output at which the converter is at full scale, mV: the divider in front of it is part of the law.
    pub full_scale_mv: u32,
}

impl AnalogueLaw {
    /// 1 V at 0 kPa and 5 V at 1000 kPa, as the data sheet of the sister PSE530 has it; 0.6 V at -100 kPa, so less than
    /// 0.5 V is no reading; a divider from 5 V to 3.3 V. To be checked against the unit.
    pub const NOMINAL: Self = Self { zero_mv: 1000, slope_uv_per_kpa: 4000, below_range_mv: 500, full_scale_mv: 5000 };
}

/// The analogue output's driver. Its constants are worked out once, so that a tick multiplies and shifts: a 64-bit
/// division costs a Cortex-M4 some 300 instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ise30a {
    /// 2^-36 kPa for each code.
    scale: i64,
    /// 2^-16 kPa at code zero.
    origin: i64,
    /// Mean codes below this one are a broken wire, in 1/65536 of a code.
    below_range: i64,
}

impl Ise30a {
    /// With its law.
    ///
    /// # Panics
    /// When the slope or the full scale is zero; in `const` evaluation, at compile time.
    #[must_use]
    pub const fn new(law: AnalogueLaw) -> Self {
        assert!(law.slope_uv_per_kpa > 0 && law.full_scale_mv > 0, "a law has a slope and a full scale");
        let slope = law.slope_uv_per_kpa as i64;
        let full_scale_uv = law.full_scale_mv as i64 * 1000;
        // 2^36 / 2^12 codes = 2^24; 65535 mV times 2^24 has 50 bits.
        let scale = ((full_scale_uv << 24) + slope / 2) / slope;
        let origin = -(((law.zero_mv as i64 * 1000) << 16) + slope / 2) / slope;
        Self { scale, origin, below_range: ((law.below_range_mv as i64) << 28) / law.full_scale_mv as i64 }
    }

    /// Pressure from the sum of `samples` conversions, rounded to 2^-16 kPa; at most 0.51 of that off the law.
    ///
    /// Every conversion at full scale is [`Reading::AboveRange`]; a mean below the wire-break threshold, or no
    /// conversion at all, is [`Reading::BelowRange`]. More samples than 65536 in one sum are no reading either.
    #[must_use]
    pub fn reading(&self, sum: u32, samples: u32) -> Reading<Pressure> {
        if samples == 0 || samples > 1 << 16 {
            return Reading::BelowRange;
        }
        if u64::from(sum) >= u64::from(samples) * u64::from(CODES - 1) {
            return Reading::AboveRange;
        }
        // The sum has 28 bits at the most here.
        let sum = i64::from(sum);
        if sum << 16 < self.below_range.saturating_mul(i64::from(samples)) {
            return Reading::BelowRange;
        }
        let scaled = mean(sum.saturating_mul(self.scale), samples);
        let bits = ((scaled + (1 << 19)) >> 20).saturating_add(self.origin);
        Reading::Valid(Pressure::from_bits(bits.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32))
    }
}

/// A sum over `samples`, rounded down; a shift where it can be one.
pub(crate) fn mean(sum: i64, samples: u32) -> i64 {
    if samples.is_power_of_two() {
        sum >> samples.trailing_zeros()
    } else {
        sum.checked_div_euclid(i64::from(samples)).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sum_of_sixteen_codes_is_within_half_a_bit() {
        let driver = Ise30a::new(AnalogueLaw::NOMINAL);
        for sum in 0..16 * 4096_u32 {
            let volts = f64::from(sum) / 16.0 / 4096.0 * 5.0;
            match driver.reading(sum, 16) {
                Reading::AboveRange => assert!(sum >= 16 * 4095),
                Reading::BelowRange => assert!(volts < 0.5),
                Reading::Valid(pressure) => {
                    assert!(volts >= 0.5 && sum < 16 * 4095);
                    let error = f64::from(pressure.to_bits()) - (volts - 1.0) / 0.004 * 65_536.0;
                    assert!(error.abs() <= 0.51, "{sum}: {error}");
                }
            }
        }
    }

    #[test]
    fn no_samples_and_impossible_sums_are_harmless() {
        let driver = Ise30a::new(AnalogueLaw::NOMINAL);
        assert_eq!(driver.reading(0, 0), Reading::BelowRange);
        assert_eq!(driver.reading(u32::MAX, 16), Reading::AboveRange);
        for samples in [1, 1 << 16, u32::MAX] {
            let _ = driver.reading(u32::MAX, samples);
        }
    }
}
