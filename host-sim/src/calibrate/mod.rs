//! Calibration of the model to measurements of pressure and bend.

pub mod file;
