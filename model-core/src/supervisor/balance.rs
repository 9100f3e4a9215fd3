//! The balance of the air: what pump and dump are modelled to move must be in manifold and chambers.
//!
//! A leak, a dump valve that does not close, a pump that gives less: whatever valves and setpoints do meanwhile, the readings
//! correct the observer's model downwards again and again. All that they take away in about two seconds is air that is missing.

use crate::observer::Air;
use fixed::types::I16F16;

/// Sums fade with a time constant of so many ticks, as a power of two: 2.0 s.
const FADES: u32 = 11;
/// A model that the self test has fitted to the machine may be off by this share of what it moves ...
const OFF_SHARE: I16F16 = I16F16::lit("0.4");
/// ... and by this, kPa of the manifold alone: chambers in which there is less than the model has put there.
const OFF: I16F16 = I16F16::lit("40");

/// See the module's page.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balance {
    /// Both in kPa of the manifold alone.
    missing: I16F16,
    moved: I16F16,
}

impl Balance {
    pub(super) const fn new() -> Self {
        Self { missing: I16F16::ZERO, moved: I16F16::ZERO }
    }

    /// One tick; true when more is missing than a model can be wrong by.
    pub(super) fn misses_air(&mut self, air: Air) -> bool {
        let sum = |sum: I16F16, tick: I16F16| sum.saturating_add(tick).saturating_sub(sum >> FADES);
        self.missing = sum(self.missing, air.corrected.saturating_neg());
        self.moved = sum(self.moved, air.moved);
        self.missing > self.moved.saturating_mul(OFF_SHARE).saturating_add(OFF)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tick of the first alarm within 20 s of this much corrected and moved in each tick, kPa.
    fn first(corrected: f64, moved: f64) -> Option<u32> {
        let mut balance = Balance::new();
        let air = Air { corrected: I16F16::from_num(corrected), moved: I16F16::from_num(moved), ..Air::STILL };
        (0..20_000).find(|_| balance.misses_air(air))
    }

    #[test]
    fn air_that_is_missing_is_found_and_a_model_that_is_off_is_not() {
        // A hole of 0.01 NL/(s bar) at 60 kPa takes 0.32 kPa a tick from 5 mL; a pump that makes good for it moves as much.
        let tick = first(-0.32, 0.32).expect("found");
        assert!((150..400).contains(&tick), "{tick}");
        // A pump that gives a third less than the model has it for.
        assert_eq!(first(-0.25, 0.75), None);
        // Air that is too much, and a tight finger.
        assert_eq!(first(0.5, 0.0), None);
        assert_eq!(first(-0.01, 0.0), None);
    }
}
