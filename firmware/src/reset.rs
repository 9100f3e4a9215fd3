//! Why the chip started, and what happens when the program cannot go on.

use crate::board;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU8, Ordering};
use cortex_m_rt::{ExceptionFrame, exception};
use embassy_stm32::pac;
use model_core::protocol::ResetCause;

static CAUSE: AtomicU8 = AtomicU8::new(0);

/// Reads the chip's reset flags and clears them for the next time. Call once, first.
pub fn read_cause() {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    // The most telling flag first: every reset pulls the pin, and power-on is a brown-out too.
    let code = if flags.wdgrstf() {
        1
    } else if flags.sftrstf() {
        2
    } else if flags.porrstf() {
        3
    } else if flags.borrstf() {
        4
    } else if flags.padrstf() {
        5
    } else {
        0
    };
    CAUSE.store(code, Ordering::Relaxed);
}

/// What [`read_cause`] found.
pub fn cause() -> ResetCause {
    match CAUSE.load(Ordering::Relaxed) {
        1 => ResetCause::Watchdog,
        2 => ResetCause::Software,
        3 => ResetCause::PowerOn,
        4 => ResetCause::Brownout,
        5 => ResetCause::Pin,
        _ => ResetCause::Other,
    }
}

/// Logs it.
pub fn report() {
    match cause() {
        ResetCause::PowerOn => defmt::info!("started by power"),
        ResetCause::Brownout => defmt::warn!("started after a brown-out"),
        ResetCause::Pin => defmt::info!("started by the reset pin"),
        ResetCause::Software => defmt::error!("started by the firmware itself"),
        ResetCause::Watchdog => defmt::error!("started by the watchdog"),
        ResetCause::Other => defmt::warn!("started for no known reason"),
    }
}

/// Coils to rest first, then a restart, which stays vented.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    board::release_coils();
    defmt::error!("{}", defmt::Display2Format(info));
    cortex_m::peripheral::SCB::sys_reset()
}

#[exception]
unsafe fn HardFault(_frame: &ExceptionFrame) -> ! {
    board::release_coils();
    cortex_m::peripheral::SCB::sys_reset()
}
