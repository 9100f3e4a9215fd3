//! What runs on the board: starts the tasks.

use crate::acquisition::acquire;
use crate::beats::{self, Beat};
use crate::board::{self, INTERLOCK_INTERRUPT, TICK_CODES};
use crate::control::{Panel, control};
use crate::outputs::{self, Trip};
use crate::{interlock, link, reset};
use cortex_m::singleton;
use defmt_rtt as _;
use embassy_executor::{InterruptExecutor, Spawner};
use embassy_stm32::interrupt;

static INTERLOCK: InterruptExecutor = InterruptExecutor::new();

#[interrupt]
unsafe fn UART5() {
    // SAFETY: this is the interrupt that the executor was started with.
    unsafe { INTERLOCK.on_interrupt() }
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    reset::read_cause();
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
    let started = singleton!(: [u16; 2 * TICK_CODES] = [0; 2 * TICK_CODES])
        .zip(singleton!(: [u8; 256] = [0; 256]))
        .and_then(|(adc, uart)| board::start(adc, uart));
    let Some(board) = started else {
        // Coils rest; the watchdog is not running yet, so this stays, vented.
        defmt::error!("the board does not start");
        return;
    };
    reset::report();
    outputs::adopt(board.coils);
    let interlock = INTERLOCK.start(INTERLOCK_INTERRUPT);
    let panel = Panel { start_button: board.start_button, running_led: board.running_led, fault_led: board.fault_led };
    // A task that does not start does not beat, and the watchdog never lets the board run without it.
    if let Ok(task) = interlock::watch(board.emergency_stop, Trip::EmergencyStop, Beat::EmergencyStop) {
        interlock.spawn(task);
    }
    if let Ok(task) = interlock::watch(board.over_pressure, Trip::OverPressure, Beat::OverPressure) {
        interlock.spawn(task);
    }
    if let Ok(task) = beats::supervise(board.watchdog) {
        spawner.spawn(task);
    }
    if let Ok(task) = acquire(board.adc, board.sampling) {
        spawner.spawn(task);
    }
    if let Ok(task) = control(panel, board.store) {
        spawner.spawn(task);
    }
    if let Ok(task) = link::receive(board.receiver) {
        spawner.spawn(task);
    }
    if let Ok(task) = link::transmit(board.transmitter) {
        spawner.spawn(task);
    }
}
