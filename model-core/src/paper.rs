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
/// Table 3, gauge pressure in kPa.
pub const FORCE_PRESSURE_KPA: [f64; 6] = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0];
/// Table 3, driving force of one chamber without exoskeleton, in newtons.
pub const CHAMBER_BARE_N: [f64; 6] = [0.0, 0.47, 0.94, 1.42, 1.88, 2.36];
/// Table 3, driving force of one chamber with exoskeleton, in newtons.
pub const CHAMBER_EXO_N: [f64; 6] = [0.0, 1.36, 2.70, 4.07, 5.45, 6.71];
/// Table 3, driving force of the finger of three chambers with exoskeleton, in newtons.
pub const FINGER_N: [f64; 6] = [0.0, 2.51, 4.50, 6.75, 9.05, 11.50];
/// Small cavities of one chamber (Table 1).
pub const SMALL_CAVITIES: f64 = 5.0;
/// Finite elements at 150 kPa, bend of one small cavity with exoskeleton, in degrees.
pub const FEM_SMALL_CAVITY_DEG: f64 = 21.13;
/// Finite elements at 150 kPa, bend of the bare chamber, in degrees.
pub const FEM_CHAMBER_BARE_DEG: f64 = 93.34;
/// Finite elements at 150 kPa, bend of the chamber with exoskeleton, in degrees.
pub const FEM_CHAMBER_EXO_DEG: f64 = 105.08;
/// Finite elements at 150 kPa, bend of the finger, in degrees.
pub const FEM_FINGER_DEG: f64 = 319.41;
/// Finite elements at 150 kPa, force of one small cavity with exoskeleton, in newtons.
pub const FEM_SMALL_CAVITY_N: f64 = 1.2;
/// Finite elements at 150 kPa, force of the bare chamber, in newtons.
pub const FEM_CHAMBER_BARE_N: f64 = 2.25;
/// Finite elements at 150 kPa, force of the chamber with exoskeleton, in newtons.
pub const FEM_CHAMBER_EXO_N: f64 = 6.46;
/// Finite elements at 150 kPa, force of the finger, in newtons.
pub const FEM_FINGER_N: f64 = 11.24;
/// Pressures of the reconfiguration, proximal, middle and distal, in kPa.
pub const RECONFIGURATION_KPA: [f64; 3] = [60.0, 30.0, 60.0];
/// Points A, B, C of the reconfiguration by the paper's model, in mm: origin at the top left corner of the proximal
/// segment's section, x right, y down.
pub const POINTS_MODEL_MM: [[f64; 2]; 3] = [[30.51, 42.36], [23.72, 75.92], [-9.84, 96.11]];
/// The same by finite elements.
pub const POINTS_FEM_MM: [[f64; 2]; 3] = [[30.25, 42.44], [23.89, 75.69], [-9.86, 95.96]];
/// The same, measured.
pub const POINTS_MEASURED_MM: [[f64; 2]; 3] = [[31.96, 43.65], [22.60, 77.40], [-10.35, 94.80]];
/// Length of a chamber (Table 1), in mm.
pub const CHAMBER_LENGTH_MM: f64 = 38.0;
/// Height of the exoskeleton (Table 1), in mm.
pub const EXOSKELETON_HEIGHT_MM: f64 = 22.5;
/// Height of a chamber (Table 1), in mm.
pub const CHAMBER_HEIGHT_MM: f64 = 16.5;
/// Length of the whole actuator (Table 1), in mm.
pub const ACTUATOR_LENGTH_MM: f64 = 130.0;
