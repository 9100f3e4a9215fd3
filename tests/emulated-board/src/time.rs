//! Virtual time.

/// Ticks a second. Every clock of the board divides it: 180, 90, 45, 16 and 8 MHz and the watchdog's 32 kHz.
pub const TICKS_PER_SECOND: u64 = 720_000_000;
/// Ticks of one microsecond.
pub const MICROSECOND: u64 = TICKS_PER_SECOND / 1_000_000;
/// Ticks of one millisecond.
pub const MILLISECOND: u64 = 1000 * MICROSECOND;
/// Ticks of one instruction: a cycle of the 180 MHz core clock, flash wait states and the slow clock at start left out.
pub const INSTRUCTION: u64 = TICKS_PER_SECOND / 180_000_000;
/// No event to come.
pub const NEVER: u64 = u64::MAX;
