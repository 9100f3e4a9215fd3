//! Why the chip started, and what happens when the program cannot go on.

use crate::board;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m_rt::{ExceptionFrame, exception};
use embassy_stm32::pac;
use model_core::protocol::ResetCause;

/// The chip's reset flags of this start.
static FLAGS: AtomicU32 = AtomicU32::new(0);

/// Reads the chip's reset flags and clears them for the next time. Call once, first.
pub fn read_cause() {
    FLAGS.store(pac::RCC.csr().read().0, Ordering::Relaxed);
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
}

/// What [`read_cause`] found.
pub fn cause() -> ResetCause {
    let flags = pac::rcc::regs::Csr(FLAGS.load(Ordering::Relaxed));
    // The most telling flag first: every reset pulls the pin, and power-on is a brown-out too.
    if flags.wdgrstf() {
        ResetCause::Watchdog
    } else if flags.sftrstf() {
        ResetCause::Software
    } else if flags.porrstf() {
        ResetCause::PowerOn
    } else if flags.borrstf() {
        ResetCause::Brownout
    } else if flags.padrstf() {
        ResetCause::Pin
    } else {
        ResetCause::Other
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
