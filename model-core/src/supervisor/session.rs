//! How long and how often a finger has been bent since the session began.

use super::fault::Fault;
use crate::actuation::PerSegment;
use crate::units::Pressure;

/// Longest time of treatment in a session, ticks: 60 min. Assumed; a clinician's to set.
const LONGEST_TICKS: u32 = 3_600_000;
/// Largest number of bends in a session. Assumed; a clinician's to set.
const MOST_BENDS: u16 = 2000;
/// Vented for so long a session has ended, and the next one starts anew: 5 min, ticks. Assumed.
const REST_TICKS: u32 = 300_000;
/// A bend begins when a setpoint passes this upwards ...
const BENT: Pressure = Pressure::from_kpa(20);
/// ... and another one can when all are below this.
const STRAIGHT: Pressure = Pressure::from_kpa(10);

/// See the module's page.
#[derive(Clone, Debug, Default)]
pub(super) struct Session {
    ticks: u32,
    rested: u32,
    bends: u16,
    bent: bool,
}

impl Session {
    pub(super) const fn new() -> Self {
        Self { ticks: 0, rested: 0, bends: 0, bent: false }
    }

    /// One tick, under treatment or not, towards these setpoints.
    pub(super) fn watch(&mut self, treats: bool, setpoints: &PerSegment<Pressure>) -> Option<Fault> {
        if !treats {
            self.rested = self.rested.saturating_add(1);
            if self.rested > REST_TICKS {
                *self = Self { rested: self.rested, ..Self::new() };
            }
            return None;
        }
        self.rested = 0;
        self.ticks = self.ticks.saturating_add(1);
        if self.bent {
            self.bent = setpoints.iter().any(|&setpoint| setpoint > STRAIGHT);
        } else if setpoints.iter().any(|&setpoint| setpoint > BENT) {
            self.bent = true;
            self.bends = self.bends.saturating_add(1);
        }
        if self.ticks > LONGEST_TICKS {
            Some(Fault::SessionTime)
        } else if self.bends > MOST_BENDS {
            Some(Fault::SessionCycles)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRETCHED: PerSegment<Pressure> = [Pressure::ZERO; 3];
    const FLEXED: PerSegment<Pressure> = [Pressure::ZERO, Pressure::from_kpa(60), Pressure::ZERO];

    #[test]
    fn an_hour_ends_a_session_and_a_rest_begins_the_next() {
        let mut session = Session::new();
        assert!((0..LONGEST_TICKS).all(|_| session.watch(true, &STRETCHED).is_none()));
        assert_eq!(session.watch(true, &STRETCHED), Some(Fault::SessionTime));
        (0..=REST_TICKS).for_each(|_| assert_eq!(session.watch(false, &STRETCHED), None));
        assert_eq!(session.watch(true, &STRETCHED), None);
    }

    #[test]
    fn bends_are_counted_once_each() {
        let mut session = Session::new();
        for _ in 0..MOST_BENDS {
            assert!((0..10).all(|_| session.watch(true, &FLEXED).is_none()));
            assert!((0..10).all(|_| session.watch(true, &STRETCHED).is_none()));
        }
        assert_eq!(session.watch(true, &FLEXED), Some(Fault::SessionCycles));
    }
}
