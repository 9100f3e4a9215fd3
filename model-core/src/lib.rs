//! Everything that decides anything in the controller of the soft rehabilitation finger.
//!
//! Pure functions of inputs and time: no clock, no I/O, no allocation, no float, no panic. The firmware calls
//! [`controller::Controller::step`] once a millisecond with what the sensors read and writes the returned
//! [`actuation::Actuation`] to its pins; `host-sim` does the same with a simulated plant.
//!
//! ```
//! use model_core::actuation::Actuation;
//! use model_core::calibration;
//! use model_core::controller::{Command, Controller, Fault, Inputs, Mode, Reading};
//! use model_core::sequence::library;
//! use model_core::units::{Bend, Millis, Pressure};
//!
//! let mut controller = Controller::new([calibration::DEFAULT; 3]);
//! let mut inputs = Inputs {
//!     now: Millis::ZERO,
//!     manifold: Reading::Valid(Pressure::ZERO),
//!     bend: Reading::Valid(Bend::ZERO),
//!     over_pressure_switch: false,
//!     emergency_stop: false,
//!     host_heard: true,
//!     overrun: false,
//! };
//! controller.step(&inputs);
//! let grasp = library::find("grasp").expect("built in");
//! controller.command(Command::Run(grasp)).expect("vented, and no fault");
//! inputs.now = Millis(1);
//! assert_eq!(controller.step(&inputs).mode, Mode::Running);
//!
//! (inputs.now, inputs.emergency_stop) = (Millis(2), true);
//! let outputs = controller.step(&inputs);
//! assert_eq!(outputs.mode, Mode::Faulted(Fault::EmergencyStop));
//! assert_eq!(outputs.actuation, Actuation::SAFE);
//! ```
//!
//! `docs/architecture.md` shows how the modules work together.
#![cfg_attr(not(any(test, feature = "host")), no_std)]
#![forbid(unsafe_code)]

pub mod actuation;
pub mod bend_loop;
pub mod calibration;
pub mod controller;
pub mod division;
#[cfg(any(test, feature = "host"))]
pub mod equations;
pub mod force;
pub mod identification;
pub mod inverse;
pub mod kinematics;
#[cfg(feature = "methods")]
pub mod methods;
pub mod observer;
#[cfg(any(test, feature = "host"))]
pub mod paper;
pub mod protocol;
pub mod regulator;
pub mod self_test;
pub mod sequence;
pub mod supervisor;
pub mod units;
