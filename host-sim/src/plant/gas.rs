//! Air in a volume, isothermal.
//!
//! The valves move the air over seconds through thin-walled silicone and tubing, so its temperature is taken as
//! constant, at the 20 degrees C of the normal litre. A real fill starts out warmer (up to adiabatic, exponent 1.4)
//! and settles within some hundred milliseconds; a law with a fixed exponent other than 1 would never settle, so none
//! is offered.

/// Absolute pressure of the reference atmosphere (ANR) that defines a normal litre, in kPa. Source: ISO 8778, 20
/// degrees C.
pub const REFERENCE_KPA: f64 = 100.0;

/// A volume and the air in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasVolume {
    content_nl: f64,
    volume_l: f64,
}

impl GasVolume {
    /// A volume in litres (above zero), filled to an absolute pressure in kPa.
    #[must_use]
    pub fn at_pressure(volume_l: f64, absolute_kpa: f64) -> Self {
        Self { content_nl: absolute_kpa * volume_l / REFERENCE_KPA, volume_l }
    }

    /// Absolute pressure in kPa.
    #[must_use]
    pub fn absolute_kpa(&self) -> f64 {
        self.content_nl * REFERENCE_KPA / self.volume_l
    }

    /// Pressure lost for each litre gained, kPa/L.
    #[must_use]
    pub fn kpa_per_l(&self) -> f64 {
        self.absolute_kpa() / self.volume_l
    }

    /// The air in it, in normal litres.
    #[must_use]
    pub fn content_nl(&self) -> f64 {
        self.content_nl
    }

    /// Its volume in litres.
    #[must_use]
    pub fn volume_l(&self) -> f64 {
        self.volume_l
    }

    /// Takes the air in it, in normal litres, for what a step made of it.
    pub fn set_content_nl(&mut self, content_nl: f64) {
        self.content_nl = content_nl;
    }

    /// Adds air, in normal litres; negative takes it away.
    pub fn add(&mut self, nl: f64) {
        self.content_nl += nl;
    }

    /// Changes the volume (litres, above zero) and keeps the air.
    pub fn set_volume_l(&mut self, volume_l: f64) {
        self.volume_l = volume_l;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boyles_law() {
        let mut gas = GasVolume::at_pressure(0.01, 150.0);
        assert!((gas.content_nl() - 0.015).abs() < 1e-15);
        gas.set_volume_l(0.03);
        assert!((gas.absolute_kpa() - 50.0).abs() < 1e-12);
        gas.add(0.03);
        assert!((gas.absolute_kpa() - 150.0).abs() < 1e-12);
        assert!((gas.content_nl() - 0.045).abs() < 1e-15);
        gas.set_content_nl(0.03);
        assert!((gas.absolute_kpa() - 100.0).abs() < 1e-12);
    }
}
