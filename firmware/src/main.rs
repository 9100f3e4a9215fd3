//! The controller's firmware for the NUCLEO-F446RE.
//!
//! | task | executor | does |
//! |---|---|---|
//! | `interlock::watch` (two) | interrupt UART5 | emergency stop and over-pressure switch: all coils to rest, latched |
//! | `acquisition::acquire` | thread | sixteen scans by timer and DMA, summed to a sample a millisecond |
//! | `control::control` | thread | the core's step, coils, answers |
//! | `link::receive`, `link::transmit` | thread | frames from and to the host, telemetry 100 times a second |
//! | `beats::supervise` | thread | feeds the watchdog when all of the above have beaten |
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod acquisition;
#[cfg(target_os = "none")]
mod beats;
#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod control;
#[cfg(target_os = "none")]
mod interlock;
#[cfg(target_os = "none")]
mod link;
#[cfg(target_os = "none")]
mod outputs;
#[cfg(target_os = "none")]
mod reset;
#[cfg(target_os = "none")]
mod target;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!("error: the firmware runs on the board: build it with `cargo xtask firmware`");
    std::process::ExitCode::FAILURE
}
