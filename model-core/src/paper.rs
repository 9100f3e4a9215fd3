//! Figures of the paper "Design and Research of Multi Segment Exoskeleton Reconfigurable Soft Finger Actuator".
//!
//! `tests/tests/golden_paper.rs` compares them with `tests/data/paper.toml`.

/// Table 2, gauge pressure in kPa.
pub const PRESSURE_KPA: [f64; 5] = [30.0, 60.0, 90.0, 120.0, 150.0];
/// Table 2, bend of one chamber without exoskeleton, in degrees.
pub const CHAMBER_BARE_DEG: [f64; 5] = [33.7, 58.2, 76.7, 90.7, 100.1];
/// Table 2, bend of one chamber with exoskeleton, in degrees.
pub const CHAMBER_EXO_DEG: [f64; 5] = [46.3, 71.0, 89.6, 103.7, 112.6];
/// Table 2, bend of the whole finger of three chambers with exoskeleton, in degrees.
pub const FINGER_DEG: [f64; 5] = [139.1, 212.8, 271.1, 312.0, 338.7];
/// Chambers of the finger (Table 1).
pub const CHAMBERS: f64 = 3.0;
/// Yeoh coefficient `C10` in `MPa`, from tensile tests.
pub const C10_MPA: f64 = 0.11;
/// Yeoh coefficient `C20` in `MPa`, from tensile tests.
pub const C20_MPA: f64 = 0.02;
