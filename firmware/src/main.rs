//! The controller's firmware for the NUCLEO-F446RE: steps the core once a millisecond.
//!
//! Its pins are not driven yet. At reset every pin is an input, so every coil is without current, and the normally
//! open valves vent the finger: the safe state. Until the sensors are read, the core is told that they are missing;
//! it latches that fault and stays vented.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod target;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!("error: the firmware runs on the board: build it with `cargo xtask firmware`");
    std::process::ExitCode::FAILURE
}
