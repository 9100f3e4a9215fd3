//! Emergency stop and over-pressure switch, in an executor of their own above every other task.

use crate::beats::{self, Beat};
use crate::outputs::{self, Trip};
use embassy_futures::select::{Either, select};
use embassy_stm32::exti::ExtiInput;
use embassy_stm32::mode::Async;
use embassy_time::{Duration, Timer};

/// How often an interlock that waits says that it still runs.
const BEAT: Duration = Duration::from_millis(20);

#[embassy_executor::task(pool_size = 2)]
pub async fn watch(mut input: ExtiInput<'static, Async>, cause: Trip, beat: Beat) -> ! {
    loop {
        beats::beat(beat);
        // High is the alarm: the loop is closed to ground while all is well.
        if let Either::First(()) = select(input.wait_for_high(), Timer::after(BEAT)).await {
            outputs::trip(cause);
            while let Either::Second(()) = select(input.wait_for_low(), Timer::after(BEAT)).await {
                beats::beat(beat);
            }
            outputs::down(cause);
        }
    }
}
