//! Every figure of the plant, in one place, with its source.
//!
//! Sources: "paper" is the paper's own figure (`paper.toml`); "data sheet" the part's or a sister part's; "fitted" was
//! computed from the paper's measurements; "assumed" is a plausible figure that nobody has checked against the
//! machine. Pressures are gauge unless said; NL is a normal litre (20 degrees C, 100 kPa).

use super::integrator::Method;
use serde::Serialize;

/// The whole plant.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlantParameters {
    /// The air and where it is.
    pub gas: GasParameters,
    /// The pump.
    pub pump: PumpParameters,
    /// Each of the three segment valves.
    pub segment_valve: OrificeParameters,
    /// The dump valve.
    pub dump_valve: OrificeParameters,
    /// The finger.
    pub finger: FingerParameters,
    /// The ISE30A.
    pub pressure_sensor: PressureSensorParameters,
    /// The BF350 with its amplifier.
    pub bend_sensor: BendSensorParameters,
    /// Integration.
    pub integration: IntegrationParameters,
}

/// The air and where it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GasParameters {
    /// Absolute pressure of the surroundings, kPa. Default 101.325: the standard atmosphere.
    pub atmosphere_kpa: f64,
    /// Manifold, tubing and fittings up to the valves, mL. Default 5: assumed.
    pub manifold_ml: f64,
}

impl Default for GasParameters {
    fn default() -> Self {
        Self { atmosphere_kpa: 101.325, manifold_ml: 5.0 }
    }
}

/// The pump, its relay and its check valve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PumpParameters {
    /// Flow against no pressure, NL/min. Default 3: assumed, a small diaphragm pump.
    pub free_flow_nl_per_min: f64,
    /// Pressure at which the flow, falling linearly, is zero, kPa. Default 250: assumed, well above the paper's 150.
    pub stall_kpa: f64,
    /// Time constant of the rotor's speed, both ways, ms. Default 15: assumed.
    pub spin_up_ms: f64,
    /// From the command to the relay's contact, both ways, whole ms. Default 10: assumed, usual for a small relay.
    pub dead_time_ms: u32,
}

impl Default for PumpParameters {
    fn default() -> Self {
        Self { free_flow_nl_per_min: 3.0, stall_kpa: 250.0, spin_up_ms: 15.0, dead_time_ms: 10 }
    }
}

/// A valve's passage after ISO 6358, and its coil.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrificeParameters {
    /// Sonic conductance C, NL/(s bar). Default 0.025: assumed, a miniature 2/2 valve of 0.4 to 0.5 mm.
    pub conductance_nl_per_s_bar: f64,
    /// Critical pressure ratio b, 0..1. Default 0.3: assumed, usual for small valves.
    pub critical_ratio: f64,
    /// Above this ratio of absolute pressures the flow is linear in their difference, b..1. Default 0.999: ISO 6358
    /// simulation practice.
    pub laminar_above: f64,
    /// From the command to the passage, both ways, whole ms. Default 10: assumed, usual for the size.
    pub dead_time_ms: u32,
}

impl Default for OrificeParameters {
    fn default() -> Self {
        Self { conductance_nl_per_s_bar: 0.025, critical_ratio: 0.3, laminar_above: 0.999, dead_time_ms: 10 }
    }
}

/// The finger's three chambers; each is the same.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FingerParameters {
    /// The model's k, c1, c2 of each segment, kPa. Default 0, 13.84, 0.336: fitted to the paper's Table 2, chamber
    /// with exoskeleton (worst 0.81 %).
    pub coefficients_kpa: [[f64; 3]; 3],
    /// Volume of one chamber at rest, mL. Default 6.786: paper, Table 1, inner length times width times height
    /// (a - 2b)(d - 2b)(c - 2b) = 36 x 13 x 14.5 mm; the walls between the small cavities are not taken off.
    pub chamber_ml: f64,
    /// Growth of that volume at the reference bend, as a share; linear in the bend. Default 0.3: assumed.
    pub volume_growth: f64,
    /// Bend that the growth is given for, degrees. Default 113: the paper's measured bend at 150 kPa (112.6).
    pub growth_reference_deg: f64,
    /// Time constant with which the bend follows the pressure, ms. Default 80: assumed.
    pub lag_ms: f64,
}

impl Default for FingerParameters {
    fn default() -> Self {
        Self {
            coefficients_kpa: [[0.0, 13.84, 0.336]; 3],
            chamber_ml: 36.0 * 13.0 * 14.5 / 1000.0,
            volume_growth: 0.3,
            growth_reference_deg: 113.0,
            lag_ms: 80.0,
        }
    }
}

/// The ISE30A on the manifold: analogue output through a divider into a 12 bit converter, and the switch output.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PressureSensorParameters {
    /// Output at 0 kPa, V. Default 1: data sheet of the sister PSE530, to be checked against the unit.
    pub zero_volts: f64,
    /// Slope, V per kPa. Default 0.004 (5 V at 1000 kPa, 0.6 V at -100 kPa): as above.
    pub volts_per_kpa: f64,
    /// Below this output the wire is broken, V. Default 0.5: assumed, below the 0.6 V of the fullest vacuum.
    pub below_range_volts: f64,
    /// Sensor output at which the converter is at full scale, V. Default 5: a divider 5 V to 3.3 V, assumed. A full
    /// scale code reads as above range.
    pub full_scale_volts: f64,
    /// Converter resolution, bits. Default 12: data sheet STM32F446.
    pub adc_bits: u32,
    /// Conversions averaged into one tick's reading. Default 16: assumed.
    pub oversampling: u32,
    /// Noise of one tick's reading, after that averaging, kPa rms. Default 0.3: assumed.
    pub noise_kpa: f64,
    /// Noise of one tick's reading while the output stands still, kPa rms: the converter's and its supply's. Default 0.05:
    /// assumed, half a code in each of 16 conversions.
    pub frozen_noise_kpa: f64,
    /// Time constant of the output, ms. Default 2.5: assumed, from the usual response time.
    pub lag_ms: f64,
    /// Standard deviation of the zero error, which the seed draws once, kPa. Default 0.3: assumed.
    pub zero_error_kpa: f64,
    /// The switch output closes at this true manifold pressure, kPa. Default 163: assumed setting, above the
    /// controller's 150, below the 165 that no chamber may pass (docs/wiring.md).
    pub switch_kpa: f64,
}

impl Default for PressureSensorParameters {
    fn default() -> Self {
        Self {
            zero_volts: 1.0,
            volts_per_kpa: 0.004,
            below_range_volts: 0.5,
            full_scale_volts: 5.0,
            adc_bits: 12,
            oversampling: 16,
            noise_kpa: 0.3,
            frozen_noise_kpa: 0.05,
            lag_ms: 2.5,
            zero_error_kpa: 0.3,
            switch_kpa: 163.0,
        }
    }
}

/// The BF350 with its amplifier and its calibration table: the bend of the whole finger.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BendSensorParameters {
    /// Upper end of the range, degrees; the lower is 0. Default 360: paper.
    pub range_deg: f64,
    /// Resolution, degrees. Default 0.1: paper.
    pub resolution_deg: f64,
    /// Bound of the gain error, as a share; the seed draws it once, uniformly within ± this. Default 0.01: paper.
    pub gain_error: f64,
    /// Noise of one tick's reading, degrees rms. Default 0.3: assumed.
    pub noise_deg: f64,
    /// Noise of one tick's reading while the amplifier stands still, degrees rms. Default 0.05: assumed.
    pub frozen_noise_deg: f64,
    /// Gauge factor. Default 2.1: usual for the BF350-3AA.
    pub gauge_factor: f64,
    /// Strain for each degree of bend. Default 25e-6: assumed.
    pub strain_per_deg: f64,
    /// Bridge supply, V. Default 5: assumed.
    pub excitation_volts: f64,
    /// Gain of the amplifier. Default 120: assumed.
    pub gain: f64,
    /// Amplifier's output without strain, V. Default 0.2: assumed.
    pub offset_volts: f64,
    /// Full scale of the 12-bit converter, V. Default 3.3: the board's supply.
    pub full_scale_volts: f64,
}

impl BendSensorParameters {
    /// The mean converter code, 0..=4095, at a bend in degrees: a quarter bridge, Vout/Vex = (GF e/4)/(1 + GF e/2).
    #[must_use]
    pub fn code(&self, bend_deg: f64) -> f64 {
        let elongation = self.gauge_factor * bend_deg * self.strain_per_deg;
        let bridge = self.excitation_volts * 0.25 * elongation / (1.0 + 0.5 * elongation);
        ((self.offset_volts + self.gain * bridge) / self.full_scale_volts * 4096.0).clamp(0.0, 4095.0)
    }
}

impl Default for BendSensorParameters {
    fn default() -> Self {
        Self {
            range_deg: 360.0,
            resolution_deg: 0.1,
            gain_error: 0.01,
            noise_deg: 0.3,
            frozen_noise_deg: 0.05,
            gauge_factor: 2.1,
            strain_per_deg: 25e-6,
            excitation_volts: 5.0,
            gain: 120.0,
            offset_volts: 0.2,
            full_scale_volts: 3.3,
        }
    }
}

/// Integration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IntegrationParameters {
    /// How the gas is integrated. Default linearly implicit midpoint rule: of the choices that stay within 0.1 kPa of the
    /// reference in the default scene and 0.2 kPa in every stiff case the fastest, see docs/simulator.md.
    pub method: Method,
    /// Steps of gas and finger in a tick of 1 ms, at least 1; the adaptive method chooses its own. Default 1.
    pub sub_steps: u32,
}

impl Default for IntegrationParameters {
    fn default() -> Self {
        Self { method: Method::LinearlyImplicitMidpoint, sub_steps: 1 }
    }
}
