//! The firmware's own ELF, byte for byte, on an emulated NUCLEO-F446RE.
//!
//! The core is Unicorn's Cortex-M4; the bus beside it carries the peripherals that the firmware uses. An access that
//! is not modelled stops the run with an error that names address and PC. Nothing depends on the host's clock: the same
//! inputs give the same run.
//!
//! ```no_run
//! use emulated_board::{Bench, firmware_elf};
//! use model_core::protocol::LinkMode;
//!
//! // `cargo xtask firmware` has built the ELF; nothing but the emulator runs it.
//! let mut bench = Bench::with_seed(&firmware_elf()?, 1)?;
//! bench.ready()?; // the self test is over
//! bench.start("reconfigure")?;
//! bench.run_ms(3000)?;
//! assert_eq!(bench.telemetry.last().map(|last| last.mode), Some(LinkMode::Running));
//! # Ok::<(), anyhow::Error>(())
//! ```
//!
//! Virtual time counts one cycle of 180 MHz for each instruction ([`time::INSTRUCTION`]), those that an IT block skips
//! among them, and jumps over sleep.

pub mod bench;
pub mod board;
pub mod campaign;
pub mod counted;
pub mod footprint;
pub mod line;
#[allow(missing_docs)]
mod machine;
pub mod pareto;
#[allow(missing_docs)]
mod peripheral;
mod rtt;
pub mod simulate;
pub mod time;

pub use bench::Bench;
pub use board::{Board, Pin};
pub use counted::{Counted, counted_elf};
pub use footprint::Footprint;
pub use line::OnLine;
pub use machine::Halt;
pub use model_core::protocol::ResetCause;

/// The firmware as `cargo xtask firmware` leaves it.
///
/// # Errors
/// When it has not been built.
pub fn firmware_elf() -> anyhow::Result<Vec<u8>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/firmware/firmware.elf");
    std::fs::read(path).map_err(|error| {
        anyhow::anyhow!("no firmware in target/firmware ({error}): build it with `cargo xtask firmware`")
    })
}
