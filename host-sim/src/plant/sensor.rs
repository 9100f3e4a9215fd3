//! The sensors as the controller reads them.

use super::fault::SignalFault;
use super::parameters::{BendSensorParameters, PressureSensorParameters};
use model_core::controller::Reading;
use model_core::units::{Bend, Pressure};

/// Steps of the controller's quantities in a unit.
const BITS_PER_UNIT: f64 = 65536.0;

/// The nearest whole number, of two the even one; for values below 2^51.
///
/// `f64::round_ties_even` is a function call where the target's baseline has no instruction for it, as on x86-64. From 1.5 x 2^52
/// on the numbers of f64 are whole: adding rounds.
#[inline]
fn nearest(value: f64) -> f64 {
    const WHOLE: f64 = 6_755_399_441_055_744.0;
    (value + WHOLE) - WHOLE
}

/// The pressure sensor: lag, zero error, noise, divider, converter, and the nominal law back to kPa.
#[derive(Clone, Debug)]
pub struct PressureSensor {
    parameters: PressureSensorParameters,
    /// Share of the difference that the lag takes away in a tick; 1 without lag.
    share: f64,
    zero_error_kpa: f64,
    quantised: bool,
    /// Codes of the converter.
    codes: f64,
    /// Code at 0 kPa, codes for each kPa, and code below which the wire is broken.
    zero_code: f64,
    codes_per_kpa: f64,
    kpa_per_code: f64,
    below_range_code: f64,
    /// Mean code steps per code, and its inverse: 1 when all conversions of a tick give the same code, more when noise dithers
    /// them.
    steps_per_code: f64,
    codes_per_step: f64,
    lagged_kpa: f64,
    last_true_kpa: f64,
    code: f64,
    /// The last code of an output that still moved.
    moving_code: f64,
}

impl PressureSensor {
    /// Settled at 0 kPa. `lag_ms` may be zero; `dithered` says that noise spreads a tick's conversions over several
    /// codes.
    #[must_use]
    pub fn new(
        parameters: &PressureSensorParameters,
        lag_ms: f64,
        zero_error_kpa: f64,
        quantised: bool,
        dithered: bool,
    ) -> Self {
        let codes = f64::from(parameters.adc_bits).exp2();
        let codes_per_volt = codes / parameters.full_scale_volts;
        let steps_per_code = if dithered { f64::from(parameters.oversampling) } else { 1.0 };
        Self {
            parameters: parameters.clone(),
            codes,
            zero_code: parameters.zero_volts * codes_per_volt,
            codes_per_kpa: parameters.volts_per_kpa * codes_per_volt,
            kpa_per_code: 1.0 / (parameters.volts_per_kpa * codes_per_volt),
            below_range_code: parameters.below_range_volts * codes_per_volt,
            share: if lag_ms > 0.0 { -(-1.0 / lag_ms).exp_m1() } else { 1.0 },
            zero_error_kpa,
            quantised,
            steps_per_code,
            codes_per_step: 1.0 / steps_per_code,
            lagged_kpa: 0.0,
            last_true_kpa: 0.0,
            code: 0.0,
            moving_code: (parameters.zero_volts + zero_error_kpa * parameters.volts_per_kpa) * codes_per_volt,
        }
    }

    /// One tick: follows the true gauge pressure in kPa.
    #[inline]
    pub fn step(&mut self, true_kpa: f64) {
        // Without lag the end of the tick counts; with lag the tick's mean, which makes it second-order accurate.
        let drive = if self.share < 1.0 { 0.5 * (true_kpa + self.last_true_kpa) } else { true_kpa };
        self.last_true_kpa = true_kpa;
        self.lagged_kpa += (drive - self.lagged_kpa) * self.share;
    }

    /// Converts: `noise` is a draw of the standard normal distribution, or zero.
    ///
    /// The mean of a tick's conversions is not drawn conversion by conversion: each carries noise of several codes
    /// (sqrt(oversampling) times the tick's), which dithers the steps away, so the mean's own step is what is left.
    #[inline]
    pub(super) fn convert(&mut self, noise: f64, fault: Option<SignalFault>) {
        self.code = match fault {
            None => self.seen(noise * self.parameters.noise_kpa),
            Some(SignalFault::Open) => 0.0,
            Some(SignalFault::Short) => self.codes - 1.0,
            Some(SignalFault::Noisy(times)) => self.seen(noise * times * self.parameters.noise_kpa),
            Some(SignalFault::Frozen) => {
                self.stepped(self.moving_code + noise * self.parameters.frozen_noise_kpa * self.codes_per_kpa)
            }
        };
        if fault.is_none() {
            self.moving_code = self.code;
        }
    }

    /// The code of what the output carries, with this noise.
    #[inline]
    fn seen(&self, noise_kpa: f64) -> f64 {
        let seen_kpa = self.lagged_kpa + self.zero_error_kpa + noise_kpa;
        self.stepped(self.zero_code + seen_kpa * self.codes_per_kpa)
    }

    /// A code as the converter gives it.
    #[inline]
    fn stepped(&self, code: f64) -> f64 {
        let stepped = if self.quantised { nearest(code * self.steps_per_code) * self.codes_per_step } else { code };
        stepped.clamp(0.0, self.codes - 1.0)
    }

    /// The mean code of this tick's conversions, 0..=4095 with 12 bits: what the converter's input carries.
    #[must_use]
    pub fn code(&self) -> f64 {
        self.code
    }

    /// What a driver with the nominal calibration makes of it.
    #[inline]
    #[must_use]
    pub fn reading(&self) -> Reading<Pressure> {
        if self.code >= self.codes - 1.0 {
            Reading::AboveRange
        } else if self.code < self.below_range_code {
            Reading::BelowRange
        } else {
            let kpa = (self.code - self.zero_code) * self.kpa_per_code;
            Reading::Valid(Pressure::from_bits(nearest(kpa * BITS_PER_UNIT) as i32))
        }
    }
}

/// The bend sensor over the whole finger.
#[derive(Clone, Debug)]
pub struct BendSensor {
    parameters: BendSensorParameters,
    gain: f64,
    quantised: bool,
    /// What the amplifier last gave while it still moved, degrees.
    moving_deg: f64,
}

impl BendSensor {
    /// With its gain (1 is right).
    #[must_use]
    pub fn new(parameters: &BendSensorParameters, gain: f64, quantised: bool) -> Self {
        Self { parameters: parameters.clone(), gain, quantised, moving_deg: 0.0 }
    }

    /// The reading at a true bend in degrees; `noise` is a draw of the standard normal distribution, or zero.
    ///
    /// Below 0 it reads 0 (the calibration table's end), above the range `AboveRange`; a broken wire `BelowRange`.
    #[inline]
    #[must_use]
    pub(super) fn reading(&mut self, true_deg: f64, noise: f64, fault: Option<SignalFault>) -> Reading<Bend> {
        let p = &self.parameters;
        let seen = match fault {
            None => true_deg * self.gain + noise * p.noise_deg,
            Some(SignalFault::Open) => return Reading::BelowRange,
            Some(SignalFault::Short) => return Reading::AboveRange,
            Some(SignalFault::Noisy(times)) => true_deg * self.gain + noise * times * p.noise_deg,
            Some(SignalFault::Frozen) => self.moving_deg + noise * p.frozen_noise_deg,
        };
        if fault.is_none() {
            self.moving_deg = seen;
        }
        if seen > p.range_deg {
            return Reading::AboveRange;
        }
        let seen = seen.max(0.0);
        let stepped = if self.quantised { nearest(seen / p.resolution_deg) * p.resolution_deg } else { seen };
        Reading::Valid(Bend::from_bits(nearest(stepped * BITS_PER_UNIT) as i32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pressure_sensor(quantised: bool, dithered: bool) -> PressureSensor {
        PressureSensor::new(&PressureSensorParameters::default(), 0.0, 0.0, quantised, dithered)
    }

    fn value(reading: Reading<Pressure>) -> f64 {
        match reading {
            Reading::Valid(pressure) => pressure.to_f64(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn nearest_is_the_standards_rounding() {
        for step in -40_000..40_000 {
            let value = f64::from(step) * 0.125 + if step % 3 == 0 { 1e-9 } else { 0.0 };
            assert!((nearest(value) - value.round_ties_even()).abs() <= 0.0, "{value}");
        }
        // And the readings are what the quantities' own conversions make of the value.
        for step in -1000..9999 {
            let kpa = f64::from(step) * 0.0917;
            assert_eq!(Pressure::from_bits(nearest(kpa * BITS_PER_UNIT) as i32), Pressure::from_f64_kpa(kpa));
            assert_eq!(Bend::from_bits(nearest(kpa * BITS_PER_UNIT) as i32), Bend::from_f64_deg(kpa));
        }
    }

    #[test]
    fn reads_within_half_a_step() {
        // One code is 5 V / 4096 / (4 mV/kPa) = 0.305 kPa; sixteen dithered conversions give a sixteenth.
        for (dithered, step) in [(false, 0.305_18), (true, 0.305_18 / 16.0)] {
            let mut sensor = pressure_sensor(true, dithered);
            for tenths in -1000..9900 {
                let kpa = f64::from(tenths) / 10.0;
                sensor.step(kpa);
                sensor.convert(0.0, None);
                assert!((value(sensor.reading()) - kpa).abs() <= 0.5 * step + 1e-4, "{kpa}");
            }
        }
    }

    #[test]
    fn ends_of_its_range() {
        let mut sensor = pressure_sensor(true, true);
        sensor.convert(0.0, Some(SignalFault::Open));
        assert_eq!(sensor.reading(), Reading::BelowRange);
        sensor.convert(0.0, Some(SignalFault::Short));
        assert_eq!(sensor.reading(), Reading::AboveRange);
        sensor.step(1200.0);
        sensor.convert(0.0, None);
        assert_eq!(sensor.reading(), Reading::AboveRange);
        sensor.step(-130.0);
        sensor.convert(0.0, None);
        assert_eq!(sensor.reading(), Reading::BelowRange);
    }

    #[test]
    fn a_frozen_sensor_keeps_its_reading() {
        let mut sensor = pressure_sensor(false, false);
        sensor.step(50.0);
        sensor.convert(0.0, None);
        sensor.step(80.0);
        for noise in [0.0, 1.0, -2.0, 0.0] {
            sensor.convert(noise, Some(SignalFault::Frozen));
            // The converter's 0.05 kPa rms, and no walk.
            assert!((value(sensor.reading()) - 50.0 - 0.05 * noise).abs() < 1e-4);
        }
        sensor.convert(1.0, Some(SignalFault::Noisy(10.0)));
        assert!((value(sensor.reading()) - 83.0).abs() < 1e-4);
    }

    #[test]
    fn lags_by_its_time_constant() {
        let mut sensor = PressureSensor::new(&PressureSensorParameters::default(), 2.5, 0.0, false, false);
        // A ramp of 1 kPa/ms is followed with a delay of the time constant.
        for tick in 1..=100 {
            sensor.step(f64::from(tick));
        }
        sensor.convert(0.0, None);
        assert!((value(sensor.reading()) - 97.5).abs() < 0.05);
    }

    #[test]
    fn bend_steps_and_range() {
        let mut sensor = BendSensor::new(&BendSensorParameters::default(), 1.01, true);
        assert_eq!(sensor.reading(0.0, -2.0, None), Reading::Valid(Bend::ZERO));
        assert_eq!(sensor.reading(358.0, 0.0, None), Reading::AboveRange);
        assert_eq!(sensor.reading(100.0, 0.0, Some(SignalFault::Open)), Reading::BelowRange);
        assert_eq!(sensor.reading(100.0, 0.0, Some(SignalFault::Short)), Reading::AboveRange);
        assert_eq!(sensor.reading(100.0, 0.0, None), Reading::Valid(Bend::from_deg(101)));
        assert_eq!(sensor.reading(20.0, 2.0, Some(SignalFault::Frozen)), Reading::Valid(Bend::from_milli_deg(101_100)));
    }
}
