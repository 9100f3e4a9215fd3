//! The seven combinations of segments (figures 25 to 31): bends and fingertip by the controller's own functions.

use model_core::calibration;
use model_core::force::finger_force;
use model_core::inverse::bend_from_pressure;
use model_core::kinematics::{Chain, fingertip};
use model_core::units::{Bend, Pressure};
use serde::Serialize;

/// Proximal, middle, distal: which are pressed.
pub const ALL: [([bool; 3], &str); 7] = [
    ([true, false, false], "P"),
    ([false, true, false], "M"),
    ([false, false, true], "D"),
    ([true, true, false], "PM"),
    ([false, true, true], "MD"),
    ([true, false, true], "PD"),
    ([true, true, true], "PMD"),
];

/// One combination at one pressure.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Letters of the pressed segments.
    pub segments: &'static str,
    /// Gauge pressure in each pressed chamber.
    pub pressure_kpa: f64,
    /// Bend of each segment.
    pub bends_deg: [f64; 3],
    /// Fingertip, with the lengths of Table 1.
    pub fingertip_mm: [f64; 2],
    /// The sum of the bends.
    pub direction_deg: f64,
    /// Driving force: Table 3 in the mean pressure, which the paper has measured for all three alone.
    pub force_n: f64,
    /// The paper's values: none is among the data at hand.
    pub paper: &'static str,
}

/// All combinations at the pressures of Table 2.
#[must_use]
pub fn rows() -> Vec<Row> {
    let pressures = model_core::paper::PRESSURE_KPA;
    ALL.iter().flat_map(|(pressed, name)| pressures.iter().map(|&kpa| row(*pressed, name, kpa))).collect()
}

fn row(pressed: [bool; 3], segments: &'static str, pressure_kpa: f64) -> Row {
    let pressures = pressed.map(|pressed| if pressed { Pressure::from_f64_kpa(pressure_kpa) } else { Pressure::ZERO });
    let bends = pressures.map(|pressure| bend_from_pressure(&calibration::DEFAULT, pressure));
    let tip = fingertip(&Chain::PAPER, &bends);
    Row {
        segments,
        pressure_kpa,
        bends_deg: bends.map(Bend::to_f64),
        fingertip_mm: [tip.point.x.to_f64(), tip.point.y.to_f64()],
        direction_deg: tip.direction.to_f64(),
        force_n: finger_force(&pressures).to_f64(),
        paper: "not given",
    }
}
