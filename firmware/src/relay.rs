//! Coils: the pump's relay and the valves, with their polarity, shortest times and counts.

use embedded_hal::digital::OutputPin;
use model_core::actuation::Passage;
use model_core::units::Millis;

/// A coil behind a driver stage.
#[derive(Debug)]
pub struct Coil<P> {
    pin: P,
    /// Level at which the coil has current.
    high_is_on: bool,
    on: bool,
    switchings: u32,
}

impl<P: OutputPin> Coil<P> {
    /// On a pin that is already at its resting level.
    pub const fn new(pin: P, high_is_on: bool) -> Self {
        Self { pin, high_is_on, on: false, switchings: 0 }
    }

    /// Drives the coil; counts changes.
    ///
    /// # Errors
    /// The pin's.
    pub fn set(&mut self, on: bool) -> Result<(), P::Error> {
        if on != self.on {
            self.switchings = self.switchings.saturating_add(1);
        }
        self.on = on;
        if on == self.high_is_on { self.pin.set_high() } else { self.pin.set_low() }
    }

    /// Whether it has current.
    pub const fn is_on(&self) -> bool {
        self.on
    }

    /// Changes so far; stops at 2^32 - 1.
    pub const fn switchings(&self) -> u32 {
        self.switchings
    }
}

/// A normally open 2/2 valve.
#[derive(Debug)]
pub struct Valve<P>(pub Coil<P>);

impl<P: OutputPin> Valve<P> {
    /// Opens or closes its passage.
    ///
    /// # Errors
    /// The pin's.
    pub fn drive(&mut self, passage: Passage) -> Result<(), P::Error> {
        self.0.set(passage == Passage::Closed)
    }
}

/// The pump's relay: no pulse and no pause is shorter than its contacts need.
#[derive(Debug)]
pub struct Relay<P> {
    coil: Coil<P>,
    shortest: Millis,
    changed: Option<Millis>,
}

impl<P: OutputPin> Relay<P> {
    /// With its shortest time in either state.
    pub const fn new(coil: Coil<P>, shortest: Millis) -> Self {
        Self { coil, shortest, changed: None }
    }

    /// Drives the relay; a change that comes too early waits for a later call. Returns whether it is on.
    ///
    /// # Errors
    /// The pin's.
    pub fn drive(&mut self, on: bool, now: Millis) -> Result<bool, P::Error> {
        let settled = self.changed.is_none_or(|changed| now.since(changed) >= self.shortest);
        if on != self.coil.is_on() && settled {
            self.coil.set(on)?;
            self.changed = Some(now);
        }
        Ok(self.coil.is_on())
    }

    /// Off at once, whatever its shortest time: for safety.
    ///
    /// # Errors
    /// The pin's.
    pub fn release(&mut self, now: Millis) -> Result<(), P::Error> {
        if self.coil.is_on() {
            self.changed = Some(now);
        }
        self.coil.set(false)
    }

    /// Changes so far.
    pub const fn switchings(&self) -> u32 {
        self.coil.switchings()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::convert::Infallible;
    use embedded_hal::digital::ErrorType;

    #[derive(Default)]
    struct Pin(bool);
    impl ErrorType for Pin {
        type Error = Infallible;
    }
    impl OutputPin for Pin {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0 = false;
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            self.0 = true;
            Ok(())
        }
    }

    #[test]
    fn a_resting_valve_is_open_in_either_polarity() {
        for high_is_on in [true, false] {
            let mut valve = Valve(Coil::new(Pin(!high_is_on), high_is_on));
            valve.drive(Passage::Open).expect("never fails");
            assert_eq!(valve.0.pin.0, !high_is_on);
            valve.drive(Passage::Closed).expect("never fails");
            assert_eq!(valve.0.pin.0, high_is_on);
            assert_eq!(valve.0.switchings(), 1);
        }
    }

    #[test]
    fn a_relay_keeps_its_shortest_times_except_for_safety() {
        let mut relay = Relay::new(Coil::new(Pin::default(), true), Millis(5));
        let states: Vec<bool> =
            (0..20).map(|now| relay.drive(now % 4 == 0, Millis(now)).expect("never fails")).collect();
        // On at 0; off again at 5 at the earliest; on at the next 8 or 12 that is five later.
        assert_eq!(states.iter().filter(|&&on| on).count(), 10, "{states:?}");
        assert_eq!(relay.switchings(), 4);
        relay.drive(true, Millis(100)).expect("never fails");
        relay.release(Millis(101)).expect("never fails");
        assert!(!relay.coil.is_on());
        assert_eq!(relay.drive(true, Millis(102)), Ok(false));
        assert_eq!(relay.drive(true, Millis(106)), Ok(true));
    }
}
