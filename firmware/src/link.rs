//! The host's link: bytes to requests, answers and telemetry to bytes.

use crate::beats::{self, Beat};
use crate::control::Snapshot;
use core::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use embassy_futures::select::{Either, select};
use embassy_stm32::mode::Async;
use embassy_stm32::usart::{RingBufferedUartRx, UartTx};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, with_timeout};
use finger_drivers::pose;
use model_core::protocol::{Decoder, MAX_FRAME, Report, Request, Telemetry, encode};

/// Requests that wait for the control task, which takes one a tick. A host that sends faster is not answered.
pub static REQUESTS: Channel<CriticalSectionRawMutex, Request, 4> = Channel::new();
/// Answers that wait for the line.
pub static ANSWERS: Channel<CriticalSectionRawMutex, Report, 4> = Channel::new();
/// The newest tick to report.
pub static SNAPSHOT: Signal<CriticalSectionRawMutex, Snapshot> = Signal::new();

static DROPPED: AtomicU16 = AtomicU16::new(0);
/// A valid frame came since the last [`heard`].
static HEARD: AtomicBool = AtomicBool::new(false);

/// Whether a valid frame came since the last call.
pub fn heard() -> bool {
    HEARD.swap(false, Ordering::Relaxed)
}

/// A silent line still lets the task say that it runs.
const BEAT: Duration = Duration::from_millis(20);

#[embassy_executor::task]
pub async fn receive(mut receiver: RingBufferedUartRx<'static>) -> ! {
    let mut decoder = Decoder::new();
    let mut bytes = [0; 32];
    // Overruns and line errors cost bytes; the frame that lacks them fails its check and is counted there.
    loop {
        beats::beat(Beat::Receiver);
        let Ok(Ok(count)) = with_timeout(BEAT, receiver.read(&mut bytes)).await else { continue };
        for &byte in bytes.iter().take(count) {
            if let Some(Ok(request)) = decoder.push::<Request>(byte) {
                HEARD.store(true, Ordering::Relaxed);
                let _ = REQUESTS.try_send(request);
            }
        }
        DROPPED.store(decoder.dropped(), Ordering::Relaxed);
    }
}

#[embassy_executor::task]
pub async fn transmit(mut transmitter: UartTx<'static, Async>) -> ! {
    let mut frame = [0; MAX_FRAME];
    loop {
        let next = with_timeout(BEAT, select(ANSWERS.receive(), SNAPSHOT.wait())).await;
        beats::beat(Beat::Transmitter);
        let report = match next {
            Ok(Either::First(answer)) => answer,
            Ok(Either::Second(snapshot)) => Report::Telemetry(telemetry(&snapshot)),
            Err(_) => continue,
        };
        if let Some(bytes) = encode(&report, &mut frame).and_then(|length| frame.get(..length)) {
            let _ = transmitter.write(bytes).await;
        }
    }
}

fn telemetry(snapshot: &Snapshot) -> Telemetry {
    let outputs = &snapshot.outputs;
    let tip = pose::fingertip(&snapshot.coefficients, outputs.estimates);
    Telemetry {
        tick: snapshot.at.0,
        fingertip_um: [tip.x_um, tip.y_um],
        fingertip_millideg: tip.direction_millideg,
        force_mn: pose::force_mn(outputs.estimates),
        overruns: snapshot.overruns,
        dropped_frames: DROPPED.load(Ordering::Relaxed),
        tick_cycles: snapshot.tick_cycles,
        worst_tick_cycles: snapshot.worst_tick_cycles,
        ..Telemetry::of(outputs)
    }
}
