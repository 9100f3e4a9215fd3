//! Every method of `model_core::methods` as plain C functions, built for the Cortex-M4 with the firmware's profile.
//!
//! Nothing of this is flashed: `cargo xtask pareto` loads the ELF into the emulator, calls the functions one by one,
//! counts their instructions and compares their results with the host's.
//!
//! ```text
//! cargo xtask pareto              errors, instructions, flash and RAM of all methods
//! cargo xtask pareto --check      the same against the committed baseline
//! ```
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod exports;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("counted is for the Cortex-M4: `cargo xtask pareto` builds and runs it on the emulator");
}
