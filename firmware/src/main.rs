//! The controller's firmware for the NUCLEO-F446RE.
//!
//! | task | executor | does |
//! |---|---|---|
//! | `interlock::watch` (two) | interrupt UART5 | emergency stop and over-pressure switch: all coils to rest, latched |
//! | `acquisition::acquire` | thread | sixteen scans by timer and DMA, summed to a sample a millisecond |
//! | `control::control` | thread | the core's step, coils, answers |
//! | `link::receive`, `link::transmit` | thread | frames from and to the host, telemetry 100 times a second |
//! | `beats::supervise` | thread | feeds the watchdog when all of the above have beaten |
//!
//! ```text
//! cargo run -p firmware --release     builds, flashes by probe-rs, shows the log
//! cargo xtask firmware                target/firmware/firmware.{elf,bin,hex} and their sizes
//! cargo run --release -- run --on elf the same ELF on the emulated board
//! ```
//!
//! `docs/architecture.md` has the picture, `docs/wiring.md` the pins.
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

/// On a host this starts the build for the board, whose runner flashes it: `cargo run -p firmware --release`.
#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    let target = "thumbv7em-none-eabihf";
    let flashed = std::process::Command::new("cargo")
        .args(["run", "--package", "firmware", "--bin", "firmware", "--release", "--target", target])
        .env("DEFMT_LOG", std::env::var("DEFMT_LOG").unwrap_or_else(|_| "info".into()))
        .status();
    if flashed.is_ok_and(|status| status.success()) {
        return std::process::ExitCode::SUCCESS;
    }
    eprintln!(
        "error: not flashed: it takes `rustup target add {target}`, probe-rs (https://probe.rs) and a NUCLEO-F446RE on USB; \
         `cargo xtask firmware` builds the images for another programmer"
    );
    std::process::ExitCode::FAILURE
}
