//! The drivers: what is between the chip's pins and the core, without the chip.
//!
//! They compile and are tested on the host; the binary beside them wires them to embassy's peripherals.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod alarm;
pub mod bf350;
pub mod coils;
pub mod ise30a;
pub mod pose;
pub mod relay;
pub mod settings;
