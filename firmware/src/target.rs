//! What runs on the board.

use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::watch::Watch;
use embassy_time::{Duration, Instant, Ticker};
use model_core::calibration;
use model_core::controller::{Controller, Inputs, Mode, Outputs, Reading};
use model_core::units::Millis;
use panic_probe as _;

/// The last tick's outputs, for whoever drives pins or reports.
static OUTPUTS: Watch<CriticalSectionRawMutex, Outputs, 2> = Watch::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let _peripherals = embassy_stm32::init(embassy_stm32::Config::default());
    defmt::info!("vented, waiting for sensors");
    match control() {
        Ok(task) => spawner.spawn(task),
        Err(_) => defmt::error!("no room for the control task"),
    }
    report().await;
}

/// The core, once a millisecond.
#[embassy_executor::task]
async fn control() {
    let mut controller = Controller::new(calibration::DEFAULT);
    let mut ticker = Ticker::every(Duration::from_millis(1));
    let sender = OUTPUTS.sender();
    loop {
        let inputs = Inputs {
            // 32 bits of milliseconds last 49 days, longer than any session.
            now: Millis(Instant::now().as_millis() as u32),
            manifold: Reading::BelowRange,
            bend: Reading::BelowRange,
            over_pressure_switch: false,
            emergency_stop: false,
        };
        sender.send(controller.step(&inputs));
        ticker.next().await;
    }
}

/// Logs each change of the controller's mode, out of the control task's way.
async fn report() -> ! {
    let Some(mut outputs) = OUTPUTS.receiver() else {
        defmt::error!("no room for another receiver");
        core::future::pending().await
    };
    let mut last = None;
    loop {
        let mode = outputs.changed().await.mode;
        if last != Some(mode) {
            last = Some(mode);
            match mode {
                Mode::Vented => defmt::info!("vented"),
                Mode::Running => defmt::info!("running"),
                Mode::Holding => defmt::info!("holding"),
                Mode::Faulted(fault) => defmt::warn!("vented by fault {=u8}", fault as u8),
            }
        }
    }
}
