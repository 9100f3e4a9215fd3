//! The drivers: what is between the chip's pins and the core, without the chip.
//!
//! They compile and are tested on the host; the binary beside them wires them to embassy's peripherals. A driver takes what
//! the chip measures and gives a quantity, or says why it cannot:
//!
//! ```
//! use finger_drivers::ise30a::{AnalogueLaw, Ise30a};
//! use model_core::controller::Reading;
//! use model_core::units::Pressure;
//!
//! const SENSOR: Ise30a = Ise30a::new(AnalogueLaw::NOMINAL);
//! // Sixteen conversions in the middle of the 12-bit range: 2.5 V, 1.5 V above zero at 4 mV/kPa.
//! let Reading::Valid(pressure) = SENSOR.reading(16 * 2048, 16) else { panic!("within the range") };
//! assert!((pressure - Pressure::from_kpa(375)).abs() <= Pressure::LSB);
//! assert_eq!(SENSOR.reading(0, 16), Reading::BelowRange); // a broken wire
//! ```
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod alarm;
pub mod bf350;
pub mod coils;
pub mod ise30a;
pub mod pose;
pub mod relay;
pub mod settings;
