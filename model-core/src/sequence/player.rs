//! Plays a sequence: from ticks to targets.
//!
//! ```text
//!            ramp over         hold over, another step or repeat
//!   Ramping ───────────▶ Holding ─────────────────────────────────▶ Ramping
//!                           │ hold of the last step of the last repeat over
//!                           ▼
//!                        Finished
//! ```

use super::{Sequence, Step, Target};
use crate::units::{Bend, Millis, Pressure};

/// One tick's target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reference {
    /// Where the segments should be now, in pressures or in bends as the step has it.
    pub target: Target,
    /// Index of the step within the table.
    pub step: u16,
    /// Which repeat, from zero.
    pub repeat: u16,
    /// The ramp is over.
    pub holding: bool,
    /// Everything is over; the target is zero.
    pub finished: bool,
}

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Player {
    sequence: &'static Sequence,
    step: u16,
    repeat: u16,
    /// Time in the step.
    elapsed: Millis,
    /// The last step's target.
    from: Target,
}

impl Player {
    /// At the start of the first step, from rest.
    #[must_use]
    pub const fn start(sequence: &'static Sequence) -> Self {
        Self { sequence, step: 0, repeat: 0, elapsed: Millis::ZERO, from: Target::REST }
    }

    /// The sequence that is played.
    #[must_use]
    pub const fn sequence(&self) -> &'static Sequence {
        self.sequence
    }

    /// This tick's target; then time goes on by a millisecond. Not calling it for a while is a pause.
    pub fn advance(&mut self) -> Reference {
        self.skip_what_is_over();
        let Some(step) = self.current() else {
            let (step, repeat) = (0, self.repeat);
            return Reference { target: Target::REST, step, repeat, holding: false, finished: true };
        };
        let reference = Reference {
            target: self.target(&step),
            step: self.step,
            repeat: self.repeat,
            holding: self.elapsed >= step.ramp,
            finished: false,
        };
        self.elapsed = self.elapsed + Millis(1);
        reference
    }

    fn current(&self) -> Option<Step> {
        if self.repeat >= self.sequence.repeats() {
            return None;
        }
        self.sequence.steps().get(usize::from(self.step)).copied()
    }

    /// A step without ramp and hold takes no time: it only sets where the next one starts.
    fn skip_what_is_over(&mut self) {
        while let Some(step) = self.current() {
            if self.elapsed < step.ramp + step.hold {
                return;
            }
            (self.from, self.elapsed) = (step.target, Millis::ZERO);
            self.step = self.step.saturating_add(1);
            if usize::from(self.step) >= self.sequence.steps().len() {
                (self.step, self.repeat) = (0, self.repeat.saturating_add(1));
            }
        }
    }

    fn target(&self, step: &Step) -> Target {
        let between = |from: i32, to: i32| interpolate(from, to, self.elapsed, step.ramp);
        match (self.from, step.target) {
            (Target::Bend([p, m, d]), Target::Bend([to_p, to_m, to_d])) => Target::Bend(
                [(p, to_p), (m, to_m), (d, to_d)]
                    .map(|(from, to)| Bend::from_bits(between(from.to_bits(), to.to_bits()))),
            ),
            // Units change at zero only, which is zero in both.
            (Target::Pressure(_), Target::Bend(to)) => {
                Target::Bend(to.map(|to| Bend::from_bits(between(0, to.to_bits()))))
            }
            (Target::Bend(from), Target::Pressure(_)) => {
                Target::Bend(from.map(|from| Bend::from_bits(between(from.to_bits(), 0))))
            }
            (Target::Pressure([p, m, d]), Target::Pressure([to_p, to_m, to_d])) => Target::Pressure(
                [(p, to_p), (m, to_m), (d, to_d)]
                    .map(|(from, to)| Pressure::from_bits(between(from.to_bits(), to.to_bits()))),
            ),
        }
    }
}

/// `from` + (`to` - `from`) * `elapsed` / `ramp`, towards `from`; `to` from the ramp's end on. Exact at both ends.
fn interpolate(from: i32, to: i32, elapsed: Millis, ramp: Millis) -> i32 {
    if elapsed >= ramp {
        return to;
    }
    // 33 bits by 32 bits: with the sign 65 at the most, but a checked table's change has 24 and its time 21.
    let way = (i64::from(to) - i64::from(from)).saturating_mul(i64::from(elapsed.0));
    let done = way.checked_div(i64::from(ramp.0)).unwrap_or(0);
    i64::from(from).saturating_add(done).clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

#[cfg(test)]
mod tests {
    use super::super::library;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_sequence_lasts_its_duration_and_ends_at_rest() {
        for sequence in library::ALL {
            let mut player = Player::start(sequence);
            let mut ticks = 0;
            let mut last = Target::REST;
            loop {
                let reference = player.advance();
                if reference.finished {
                    break;
                }
                (ticks, last) = (ticks + 1, reference.target);
            }
            assert_eq!(Millis(ticks), sequence.duration(), "{}", sequence.name);
            assert!(last.at_rest(), "{}", sequence.name);
            assert!(player.advance().finished, "it stays finished");
        }
    }

    #[test]
    fn ramps_are_exact_at_their_ends_and_half_way() {
        let mut player = Player::start(library::find("all").expect("built in"));
        let references: Vec<_> = (0..11_000).map(|_| player.advance()).collect();
        for (ms, kpa) in [(0, 0), (1500, 75), (3000, 150), (7000, 150), (8500, 75), (10_000, 0)] {
            assert_eq!(references[ms].target, Target::Pressure([Pressure::from_kpa(kpa); 3]), "{ms} ms");
        }
        assert!(!references[2999].holding && references[3000].holding);
    }

    #[test]
    fn bends_are_interpolated_in_degrees() {
        let mut player = Player::start(library::find("isolated-pip").expect("built in"));
        let half = (0..=1500).map(|_| player.advance()).last().expect("some");
        assert_eq!(half.target, Target::Bend([Bend::ZERO, Bend::from_deg(30), Bend::ZERO]));
    }

    proptest! {
        #[test]
        fn interpolation_stays_between_its_ends(from: i32, to: i32, elapsed: u32, ramp: u32) {
            let value = interpolate(from, to, Millis(elapsed), Millis(ramp));
            prop_assert!((from.min(to)..=from.max(to)).contains(&value));
        }

        #[test]
        fn interpolation_is_monotone(from in -10_000_000..10_000_000, to in -10_000_000..10_000_000, ramp in 2_u32..1_000_000, share in 0.0..1.0) {
            let elapsed = (f64::from(ramp - 1) * share) as u32;
            let one = interpolate(from, to, Millis(elapsed), Millis(ramp));
            let next = interpolate(from, to, Millis(elapsed + 1), Millis(ramp));
            let towards = if to >= from { next >= one } else { next <= one };
            prop_assert!(towards, "{one} then {next}");
        }
    }
}
