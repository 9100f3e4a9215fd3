//! Everything that decides anything in the controller of the soft rehabilitation finger.
//!
//! Pure functions of inputs and time: no clock, no I/O, no allocation, no float, no panic. The firmware calls
//! [`controller::Controller::step`] once a millisecond with what the sensors read and writes the returned
//! [`actuation::Actuation`] to its pins; `host-sim` does the same with a simulated plant.
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
