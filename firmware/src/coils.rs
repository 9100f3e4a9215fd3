//! All coils together: what the controller decided, on the pins.

use crate::relay::{Relay, Valve};
use embedded_hal::digital::OutputPin;
use model_core::actuation::Actuation;
use model_core::units::Millis;

/// Everything that drives coils.
#[derive(Debug)]
pub struct Coils<P> {
    /// The pump's relay.
    pub pump: Relay<P>,
    /// The dump valve.
    pub dump: Valve<P>,
    /// The segments' valves, proximal first.
    pub segments: [Valve<P>; 3],
}

impl<P: OutputPin> Coils<P> {
    /// Drives all of them. The safe state wins over the relay's shortest time; a pin that fails keeps none of the others
    /// from being driven.
    ///
    /// # Errors
    /// The first pin's that failed.
    pub fn drive(&mut self, actuation: &Actuation, now: Millis) -> Result<(), P::Error> {
        let pump = if *actuation == Actuation::SAFE {
            self.pump.release(now)
        } else {
            self.pump.drive(actuation.pump, now).map(|_| ())
        };
        let dump = self.dump.drive(actuation.dump);
        let [proximal, middle, distal] = &mut self.segments;
        let [to_proximal, to_middle, to_distal] = actuation.segments;
        let proximal = proximal.drive(to_proximal);
        let middle = middle.drive(to_middle);
        let distal = distal.drive(to_distal);
        pump.and(dump).and(proximal).and(middle).and(distal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relay::Coil;
    use core::cell::Cell;
    use core::convert::Infallible;
    use embedded_hal::digital::{Error, ErrorKind, ErrorType};
    use model_core::actuation::Passage;
    use proptest::prelude::*;

    struct Pin<'a>(&'a Cell<bool>);
    impl ErrorType for Pin<'_> {
        type Error = Infallible;
    }
    impl OutputPin for Pin<'_> {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0.set(false);
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            self.0.set(true);
            Ok(())
        }
    }

    fn coils<P: OutputPin>(mut pin: impl FnMut(usize) -> P, high_is_on: bool) -> Coils<P> {
        let mut valve = |index| Valve(Coil::new(pin(index), high_is_on));
        let (dump, segments) = (valve(1), [valve(2), valve(3), valve(4)]);
        Coils { pump: Relay::new(Coil::new(pin(0), high_is_on), Millis(5)), dump, segments }
    }

    fn actuation() -> impl Strategy<Value = Actuation> {
        let passage = |closed| if closed { Passage::Closed } else { Passage::Open };
        any::<[bool; 5]>().prop_map(move |[pump, dump, p, m, d]| Actuation {
            pump,
            dump: passage(dump),
            segments: [p, m, d].map(passage),
        })
    }

    proptest! {
        /// Whatever was driven, however short ago: told to be safe, every pin rests at once, and stays so.
        #[test]
        fn safe_is_every_pin_at_rest_at_once(
            high_is_on: bool,
            history in proptest::collection::vec((actuation(), 0_u32..12), 0..60),
            calls in 1_usize..4,
        ) {
            let pins: [Cell<bool>; 5] = core::array::from_fn(|_| Cell::new(!high_is_on));
            let mut coils = coils(|index| Pin(&pins[index]), high_is_on);
            let mut now = Millis(0);
            for (actuation, pause) in history {
                coils.drive(&actuation, now).expect("never fails");
                let valves = [actuation.dump, actuation.segments[0], actuation.segments[1], actuation.segments[2]];
                for (pin, passage) in pins[1..].iter().zip(valves) {
                    prop_assert_eq!(pin.get() == high_is_on, passage == Passage::Closed);
                }
                now = now + Millis(pause);
            }
            for _ in 0..calls {
                coils.drive(&Actuation::SAFE, now).expect("never fails");
                prop_assert!(pins.iter().all(|pin| pin.get() != high_is_on));
            }
        }
    }

    #[derive(Debug)]
    struct Broken;
    impl Error for Broken {
        fn kind(&self) -> ErrorKind {
            ErrorKind::Other
        }
    }
    struct Fragile<'a>(&'a Cell<bool>, bool);
    impl ErrorType for Fragile<'_> {
        type Error = Broken;
    }
    impl OutputPin for Fragile<'_> {
        fn set_low(&mut self) -> Result<(), Broken> {
            self.0.set(self.1);
            if self.1 { Err(Broken) } else { Ok(()) }
        }
        fn set_high(&mut self) -> Result<(), Broken> {
            self.0.set(true);
            Ok(())
        }
    }

    #[test]
    fn a_pin_that_fails_keeps_no_other_from_its_rest() {
        for broken in 0..5 {
            let pins: [Cell<bool>; 5] = core::array::from_fn(|_| Cell::new(false));
            let mut coils = coils(|index| Fragile(&pins[index], index == broken), true);
            coils.drive(&Actuation { pump: true, ..Actuation::HOLD }, Millis(0)).expect("all go high");
            assert!(pins.iter().all(Cell::get));
            assert!(coils.drive(&Actuation::SAFE, Millis(1)).is_err());
            let at_rest = pins.iter().enumerate().filter(|(_, pin)| !pin.get()).map(|(index, _)| index);
            assert_eq!(at_rest.collect::<Vec<_>>(), (0..5).filter(|&index| index != broken).collect::<Vec<_>>());
        }
    }
}
