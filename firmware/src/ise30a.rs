//! The ISE30A pressure sensor on the manifold: analogue output for regulation, switch output as interlock.

use embedded_hal::digital::InputPin;
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

    /// Pressure from the sum of `samples` conversions, rounded to the nearest 2^-16 kPa.
    ///
    /// Every conversion at full scale is [`Reading::AboveRange`]; a mean below the wire-break threshold, or no
    /// conversion at all, is [`Reading::BelowRange`]. A sum that 12-bit conversions cannot have saturates.
    #[must_use]
    pub fn reading(&self, sum: u32, samples: u32) -> Reading<Pressure> {
        let full = i64::from(CODES) * i64::from(samples);
        if samples == 0 {
            return Reading::BelowRange;
        }
        if i64::from(sum) >= full - i64::from(samples) {
            return Reading::AboveRange;
        }
        // Microvolts times `full`: 5e6 by 2^12 by at most 2^32 samples stays within 2^63 up to 2^28 of them; more
        // saturate, which reads as a wrong pressure, never as a wrapped one.
        let output = i64::from(sum).saturating_mul(i64::from(self.full_scale_mv) * 1000);
        if output < full.saturating_mul(i64::from(self.below_range_mv) * 1000) {
            return Reading::BelowRange;
        }
        let over_zero = output.saturating_sub(full.saturating_mul(i64::from(self.zero_mv) * 1000));
        let divisor = full.saturating_mul(i64::from(self.slope_uv_per_kpa)).max(1);
        let scaled = over_zero.saturating_mul(1 << 16);
        let half = if scaled < 0 { -(divisor / 2) } else { divisor / 2 };
        let bits = scaled.saturating_add(half).checked_div(divisor).unwrap_or(i64::MAX);
        Reading::Valid(Pressure::from_bits(bits.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32))
    }
}

/// The switch output, wired so that a broken wire reads as over-pressure.
#[derive(Debug)]
pub struct Switch<P> {
    pin: P,
    /// Level at which pressure is too high.
    high_is_over: bool,
}

impl<P: InputPin> Switch<P> {
    /// On a pin; `high_is_over` tells which level means over-pressure.
    pub const fn new(pin: P, high_is_over: bool) -> Self {
        Self { pin, high_is_over }
    }

    /// Whether pressure is too high. A pin that cannot be read is too high.
    pub fn is_over_pressure(&mut self) -> bool {
        self.pin.is_high().map_or(true, |high| high == self.high_is_over)
    }

    /// The pin back.
    pub fn release(self) -> P {
        self.pin
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::convert::Infallible;
    use embedded_hal::digital::{Error, ErrorKind, ErrorType};

    #[test]
    fn every_sum_of_sixteen_codes_is_within_half_a_bit() {
        let law = AnalogueLaw::NOMINAL;
        for sum in 0..16 * 4096_u32 {
            let volts = f64::from(sum) / 16.0 / 4096.0 * 5.0;
            match law.reading(sum, 16) {
                Reading::AboveRange => assert!(sum >= 16 * 4095),
                Reading::BelowRange => assert!(volts < 0.5),
                Reading::Valid(pressure) => {
                    assert!(volts >= 0.5 && sum < 16 * 4095);
                    let error = f64::from(pressure.to_bits()) - (volts - 1.0) / 0.004 * 65_536.0;
                    assert!(error.abs() <= 0.5 + 1e-6, "{sum}: {error}");
                }
            }
        }
    }

    #[test]
    fn no_samples_and_impossible_sums_are_harmless() {
        let law = AnalogueLaw::NOMINAL;
        assert_eq!(law.reading(0, 0), Reading::BelowRange);
        assert_eq!(law.reading(u32::MAX, 16), Reading::AboveRange);
        for samples in [1, 1 << 16, u32::MAX] {
            let _ = law.reading(u32::MAX, samples);
        }
    }

    struct Pin(Option<bool>);

    #[derive(Debug)]
    struct Broken;
    impl Error for Broken {
        fn kind(&self) -> ErrorKind {
            ErrorKind::Other
        }
    }
    impl From<Infallible> for Broken {
        fn from(never: Infallible) -> Self {
            match never {}
        }
    }
    impl ErrorType for Pin {
        type Error = Broken;
    }
    impl InputPin for Pin {
        fn is_high(&mut self) -> Result<bool, Broken> {
            self.0.ok_or(Broken)
        }
        fn is_low(&mut self) -> Result<bool, Broken> {
            self.0.map(|high| !high).ok_or(Broken)
        }
    }

    #[test]
    fn a_switch_that_cannot_be_read_is_over_pressure() {
        for (level, high_is_over, over) in [
            (Some(true), true, true),
            (Some(false), true, false),
            (Some(false), false, true),
            (Some(true), false, false),
            (None, true, true),
            (None, false, true),
        ] {
            assert_eq!(Switch::new(Pin(level), high_is_over).is_over_pressure(), over);
        }
    }
}
