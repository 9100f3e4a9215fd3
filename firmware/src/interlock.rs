//! Emergency stop and over-pressure switch, in an executor of their own above every other task.

use crate::beats::{self, Beat};
use crate::board::Alarm;
use crate::outputs::{self, Trip};
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Timer};

/// How often an interlock that waits says that it still runs.
const BEAT: Duration = Duration::from_millis(20);

#[embassy_executor::task(pool_size = 2)]
pub async fn watch(mut input: Alarm, cause: Trip, beat: Beat) -> ! {
    loop {
        beats::beat(beat);
        if let Either::First(()) = select(input.raised(), Timer::after(BEAT)).await {
            outputs::trip(cause);
            while let Either::Second(()) = select(input.cleared(), Timer::after(BEAT)).await {
                beats::beat(beat);
            }
            outputs::down(cause);
        }
    }
}
