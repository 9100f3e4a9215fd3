//! Who still runs: the watchdog is fed when every task has beaten since the last feeding.

use core::sync::atomic::{AtomicU8, Ordering};
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::{Duration, Ticker};

/// A task that must run.
#[derive(Clone, Copy, Debug)]
#[repr(u8)]
pub enum Beat {
    Acquisition = 1,
    Control = 1 << 1,
    Receiver = 1 << 2,
    Transmitter = 1 << 3,
    EmergencyStop = 1 << 4,
    OverPressure = 1 << 5,
}

const ALL: u8 = 0b11_1111;

static BEATS: AtomicU8 = AtomicU8::new(0);

/// Says that a task runs.
pub fn beat(task: Beat) {
    BEATS.fetch_or(task as u8, Ordering::AcqRel);
}

/// Feeds the watchdog; never returns.
#[embassy_executor::task]
pub async fn supervise(mut watchdog: IndependentWatchdog<'static, IWDG>) -> ! {
    watchdog.unleash();
    let mut ticker = Ticker::every(Duration::from_millis(5));
    loop {
        if BEATS.load(Ordering::Acquire) == ALL {
            BEATS.store(0, Ordering::Release);
            watchdog.pet();
        }
        ticker.next().await;
    }
}
