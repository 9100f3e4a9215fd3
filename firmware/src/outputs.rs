//! The coils, shared by the control task and the interlock, which wins.

use crate::board::Coils;
use core::cell::RefCell;
use core::sync::atomic::{AtomicU8, Ordering};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::Instant;
use model_core::actuation::Actuation;
use model_core::units::Millis;

/// What tripped the interlock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Trip {
    /// The emergency stop.
    EmergencyStop = 1,
    /// The pressure sensor's switch.
    OverPressure = 2,
}

static COILS: Mutex<CriticalSectionRawMutex, RefCell<Option<Coils>>> = Mutex::new(RefCell::new(None));
/// A bit for each trip since the last rearming.
static LATCHED: AtomicU8 = AtomicU8::new(0);
/// A bit for each trip that the core has not been told of: an input may be up for less than a tick.
static NEW: AtomicU8 = AtomicU8::new(0);
/// A bit for each input that is up now.
static UP: AtomicU8 = AtomicU8::new(0);

/// Hands over the coils, at rest.
pub fn adopt(coils: Coils) {
    COILS.lock(|cell| cell.replace(Some(coils)));
}

/// Drives the coils as the core decided; while the interlock is tripped they rest instead. Returns what is driven.
pub fn drive(actuation: &Actuation, now: Millis) -> Actuation {
    COILS.lock(|cell| {
        // Read inside the critical section: a trip comes before it or after it, never within.
        let tripped = LATCHED.load(Ordering::Acquire) != 0;
        let wanted = if tripped { Actuation::SAFE } else { *actuation };
        if let Ok(mut coils) = cell.try_borrow_mut()
            && let Some(coils) = coils.as_mut()
        {
            // A pin of the chip cannot fail (its error type is empty), so there is nothing to report.
            let _ = coils.drive(&wanted, now);
        }
        wanted
    })
}

/// Everything to rest, now, and latched.
pub fn trip(cause: Trip) {
    UP.fetch_or(cause as u8, Ordering::AcqRel);
    NEW.fetch_or(cause as u8, Ordering::AcqRel);
    LATCHED.fetch_or(cause as u8, Ordering::AcqRel);
    drive(&Actuation::SAFE, Millis(Instant::now().as_millis() as u32));
}

/// The input that tripped is down again; the latch stays.
pub fn down(cause: Trip) {
    UP.fetch_and(!(cause as u8), Ordering::AcqRel);
}

/// Whether the input is up, or was since this was asked last. Not whether it is latched: the core has a latch of its own, and
/// a switch that it sees closed long after the pressure has gone would contradict the sensor.
pub fn tripped(cause: Trip) -> bool {
    let cause = cause as u8;
    let new = NEW.fetch_and(!cause, Ordering::AcqRel);
    (new | UP.load(Ordering::Acquire)) & cause != 0
}

/// Takes the latch back where the input is down.
pub fn rearm() {
    let up = UP.load(Ordering::Acquire);
    LATCHED.fetch_and(up, Ordering::AcqRel);
}
