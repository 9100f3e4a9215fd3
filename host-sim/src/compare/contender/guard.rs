//! The outputs' shortest times and the manifold's ceiling, which all peers keep.

use model_core::actuation::{Actuation, Passage};

/// Shortest time of the pump's relay in a state, ticks: as in the core's regulator.
const RELAY_TICKS: u32 = 15;
/// The same of a valve, ticks.
const VALVE_TICKS: u32 = 3;

/// Keeps an output as it is until its shortest time is over.
#[derive(Clone, Debug)]
pub struct Guard {
    last: Actuation,
    relay_ticks: u32,
    dump_ticks: u32,
    segment_ticks: [u32; 3],
}

impl Guard {
    /// In the safe state, since long.
    #[must_use]
    pub fn new() -> Self {
        let long = RELAY_TICKS.max(VALVE_TICKS);
        Self { last: Actuation::SAFE, relay_ticks: long, dump_ticks: long, segment_ticks: [long; 3] }
    }

    /// What it let through last.
    #[must_use]
    pub fn last(&self) -> Actuation {
        self.last
    }

    /// What of the wanted can be done this tick. A full manifold stops the pump at once; the safe state comes at once; pump and dump
    /// valve never work against each other.
    pub fn keep(&mut self, wanted: Actuation, full: bool) -> Actuation {
        let mut now = wanted;
        if wanted != Actuation::SAFE {
            now.pump = held(self.last.pump, wanted.pump, self.relay_ticks, RELAY_TICKS) && !full;
            now.dump = held(self.last.dump, wanted.dump, self.dump_ticks, VALVE_TICKS);
            for i in 0..3 {
                now.segments[i] = held(self.last.segments[i], wanted.segments[i], self.segment_ticks[i], VALVE_TICKS);
            }
            if now.pump && now.dump == Passage::Open {
                now.dump = Passage::Closed;
            }
        }
        let count = |same: bool, ticks: u32| if same { ticks.saturating_add(1) } else { 1 };
        self.relay_ticks = count(now.pump == self.last.pump, self.relay_ticks);
        self.dump_ticks = count(now.dump == self.last.dump, self.dump_ticks);
        for i in 0..3 {
            self.segment_ticks[i] = count(now.segments[i] == self.last.segments[i], self.segment_ticks[i]);
        }
        self.last = now;
        now
    }
}

impl Default for Guard {
    fn default() -> Self {
        Self::new()
    }
}

fn held<T: PartialEq>(last: T, wanted: T, ticks: u32, shortest: u32) -> T {
    if last != wanted && ticks < shortest { last } else { wanted }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_keep_their_shortest_times() {
        let mut guard = Guard::new();
        let fill =
            Actuation { pump: true, segments: [Passage::Open, Passage::Closed, Passage::Closed], ..Actuation::HOLD };
        let mut on = Vec::new();
        for tick in 0..40 {
            // Wants the opposite every tick.
            let wanted = if tick % 2 == 0 { fill } else { Actuation::HOLD };
            on.push(guard.keep(wanted, false).pump);
        }
        let lengths: Vec<usize> = on.chunk_by(|a, b| a == b).map(<[bool]>::len).collect();
        assert!(lengths[..lengths.len() - 1].iter().all(|&length| length >= 15), "{lengths:?}");
    }

    #[test]
    fn a_full_manifold_and_the_safe_state_do_not_wait() {
        let mut guard = Guard::new();
        let pump = Actuation { pump: true, ..Actuation::HOLD };
        assert!(guard.keep(pump, false).pump);
        assert!(!guard.keep(pump, true).pump);
        assert_eq!(guard.keep(Actuation::SAFE, false), Actuation::SAFE);
    }
}
