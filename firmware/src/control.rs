//! The core, once for each sample.

use crate::acquisition::{SAMPLE, Sample};
use crate::beats::{self, Beat};
use crate::outputs::{self, Trip};
use crate::{board, link};
use cortex_m::peripheral::DWT;
use embassy_stm32::flash::{Blocking, Flash};
use embassy_stm32::gpio::{Input, Output};
use embassy_time::{Duration, with_timeout};
use finger_drivers::settings::{Settings, Store};
use fixed::types::I8F24;
use model_core::actuation::PerSegment;
use model_core::calibration;
use model_core::controller::{Command, Controller, Fault, Inputs, Mode, Outputs, Reading};
use model_core::protocol::{Effect, Identity, LinkCommand, Reason, Report, Request, ResetCause, handle};
use model_core::sequence::library;
use model_core::supervisor::fault::{FaultSet, Priority};
use model_core::units::{Coefficients, Millis};

/// A sample that is this late is missing: the core is told that its sensors fail, and vents after its own time.
const LATE: Duration = Duration::from_millis(3);
/// Ticks between two telemetry messages.
const TELEMETRY_TICKS: u32 = 10;
/// Ticks for which the start button must be down.
const DEBOUNCE_TICKS: u8 = 30;

/// One tick as the transmitter reports it.
#[derive(Clone, Copy)]
pub struct Snapshot {
    pub at: Millis,
    pub outputs: Outputs,
    pub coefficients: PerSegment<Coefficients>,
    pub overruns: u16,
    pub tick_cycles: u32,
    pub worst_tick_cycles: u32,
}

/// The start button and the lights.
pub struct Panel {
    pub start_button: Input<'static>,
    pub running_led: Output<'static>,
    pub fault_led: Output<'static>,
}

/// The settings' place.
pub type SettingsStore = Store<Flash<'static, Blocking>>;

#[embassy_executor::task]
pub async fn control(mut panel: Panel, mut store: SettingsStore) -> ! {
    let mut controller = restore(&mut store);
    report_start(&mut controller);
    let mut told = FaultSet::EMPTY;
    let (mut expected, mut overruns, mut worst) = (None, 0_u16, 0);
    let (mut ticks, mut pressed, mut last_mode) = (0_u32, 0_u8, None);
    loop {
        let sample = with_timeout(LATE, SAMPLE.wait()).await.ok();
        let start = DWT::cycle_count();
        beats::beat(Beat::Control);
        let overrun = match (sample, expected) {
            (Some(sample), Some(number)) => sample.number != number,
            (None, Some(_)) => true,
            _ => false,
        };
        overruns = overruns.saturating_add(overrun.into());
        expected = sample.map_or(expected, |sample| Some(sample.number.wrapping_add(1)));

        let request = link::REQUESTS.try_receive().ok();
        if matches!(&request, Some(Request { command: LinkCommand::ClearFault, .. })) {
            // Before the inputs are read: the core clears only what is no longer there.
            outputs::rearm();
        }
        let inputs = inputs(sample.as_ref(), overrun);
        let mut outputs = controller.step(&inputs);
        outputs.actuation = outputs::drive(&outputs.actuation, inputs.now);
        if let Some(request) = request {
            answer(&mut controller, &mut store, request);
        }

        pressed = if panel.start_button.is_low() { pressed.saturating_add(1) } else { 0 };
        if pressed == DEBOUNCE_TICKS {
            press(&mut controller, outputs.mode);
        }
        if last_mode != Some(outputs.mode) {
            last_mode = Some(outputs.mode);
            show(&mut panel, outputs.mode);
        }
        if told != outputs.faults {
            tell(outputs.faults.without(told));
            told = outputs.faults;
        }
        panel.fault_led.set_level(is_lit(outputs.faults.priority(), ticks).into());
        let tick_cycles = DWT::cycle_count().wrapping_sub(start);
        worst = worst.max(tick_cycles);
        ticks = ticks.wrapping_add(1);
        if ticks % TELEMETRY_TICKS == 0 {
            let coefficients = controller.coefficients();
            link::SNAPSHOT.signal(Snapshot {
                at: inputs.now,
                outputs,
                coefficients,
                overruns,
                tick_cycles,
                worst_tick_cycles: worst,
            });
        }
    }
}

fn inputs(sample: Option<&Sample>, overrun: bool) -> Inputs {
    let missing = Inputs {
        now: Millis(embassy_time::Instant::now().as_millis() as u32),
        manifold: Reading::BelowRange,
        bend: Reading::BelowRange,
        over_pressure_switch: outputs::tripped(Trip::OverPressure),
        emergency_stop: outputs::tripped(Trip::EmergencyStop),
        host_heard: link::heard(),
        overrun,
    };
    let Some(&Sample { at, sums: [pressure, bend], .. }) = sample else { return missing };
    Inputs {
        now: at,
        manifold: board::PRESSURE.reading(pressure, board::SCANS as u32),
        bend: board::BEND.reading(bend, board::SCANS as u32),
        ..missing
    }
}

/// What the start itself says of the last run.
fn report_start(controller: &mut Controller) {
    let fault = match crate::reset::cause() {
        ResetCause::Watchdog | ResetCause::Software => Fault::TaskHang,
        ResetCause::Brownout => Fault::PowerDip,
        ResetCause::PowerOn | ResetCause::Pin | ResetCause::Other => return,
    };
    controller.report(fault);
}

/// The fault light as IEC 60601-1-8 has alarms flash: high priority twice a second, medium every other second, low steady.
const fn is_lit(priority: Option<Priority>, tick: u32) -> bool {
    match priority {
        None => false,
        Some(Priority::Low) => true,
        Some(Priority::Medium) => tick % 2000 < 1000,
        Some(Priority::High) => tick % 500 < 250,
    }
}

/// Logs faults that are new, by their priority.
fn tell(faults: FaultSet) {
    for fault in faults.iter() {
        match fault.priority() {
            Priority::High => defmt::error!("fault {=u8}, high priority", fault.code()),
            Priority::Medium => defmt::warn!("fault {=u8}, medium priority", fault.code()),
            Priority::Low => defmt::info!("fault {=u8}, low priority", fault.code()),
        }
    }
}

/// The start button: starts the default sequence when vented, vents otherwise.
fn press(controller: &mut Controller, mode: Mode) {
    let command = match (mode, library::find("reconfigure")) {
        (Mode::Vented, Some(sequence)) => Command::Run(sequence),
        _ => Command::Vent,
    };
    if controller.command(command).is_err() {
        defmt::warn!("the start button was not taken");
    }
}

fn show(panel: &mut Panel, mode: Mode) {
    let busy = matches!(mode, Mode::Running | Mode::Holding | Mode::Paused);
    panel.running_led.set_level(busy.into());
    match mode {
        Mode::SelfTest => defmt::info!("self test"),
        Mode::Vented => defmt::info!("vented"),
        Mode::Running => defmt::info!("running"),
        Mode::Holding => defmt::info!("holding"),
        Mode::Paused => defmt::info!("paused"),
        Mode::Faulted(fault) => defmt::warn!("vented by fault {=u8}", fault.code()),
    }
}

fn answer(controller: &mut Controller, store: &mut SettingsStore, request: Request) {
    let id = request.id;
    let report = match handle(controller, &request.command) {
        Ok(Effect::IdentityAsked) => Report::Identity(identity(controller, id)),
        Ok(Effect::IdentificationAsked) => {
            Report::Identification { id, segments: controller.identified().map(Into::into) }
        }
        Ok(Effect::Nothing) => Report::Ack { id },
        Ok(Effect::SettingsChanged) => match save(controller, store) {
            Ok(()) => Report::Ack { id },
            Err(reason) => Report::Nack { id, reason },
        },
        Err(reason) => Report::Nack { id, reason },
    };
    // A full queue means that the host does not read: it asks again.
    let _ = link::ANSWERS.try_send(report);
}

/// With what was stored, or from the defaults.
fn restore(store: &mut SettingsStore) -> Controller {
    let Some(settings) = store.load() else {
        defmt::info!("no settings stored: defaults");
        let mut controller = Controller::with_self_test([calibration::DEFAULT; 3]);
        if store.is_damaged() {
            controller.report(Fault::SettingsCorrupt);
        }
        return controller;
    };
    let mut controller = Controller::with_self_test(settings.coefficients);
    controller.restore_zeros(settings.pressure_zero, settings.bend_zero);
    defmt::info!("settings restored");
    controller
}

/// Stores what is in use. The core takes changes only while the finger is vented, so that the chip may stall.
fn save(controller: &Controller, store: &mut SettingsStore) -> Result<(), Reason> {
    let settings = Settings {
        coefficients: controller.coefficients(),
        pressure_zero: controller.pressure_zero(),
        bend_zero: controller.bend_zero(),
    };
    let mut erased = false;
    let outcome = store.save(settings, || {
        erased = true;
        board::watchdog_waits_for_erasing(true);
    });
    if erased {
        board::watchdog_waits_for_erasing(false);
    }
    outcome.map_err(|_| Reason::StorageFailed)
}

fn identity(controller: &Controller, id: u16) -> Identity {
    let coefficients = controller.coefficients();
    let uid = embassy_stm32::uid::uid();
    let word = |at: usize| uid.get(at..at + 4).and_then(|bytes| bytes.try_into().ok()).map_or(0, u32::from_le_bytes);
    Identity {
        id,
        protocol: model_core::protocol::VERSION,
        firmware: heapless::String::try_from(env!("CARGO_PKG_VERSION")).unwrap_or_default(),
        serial: [word(0), word(4), word(8)],
        reset_cause: crate::reset::cause(),
        coefficients: coefficients.map(|own| [own.k(), own.c1(), own.c2()].map(I8F24::to_bits)),
        pressure_zero: controller.pressure_zero().to_bits(),
        bend_zero: controller.bend_zero().to_bits(),
        sequences: library::ALL.len() as u8,
    }
}
