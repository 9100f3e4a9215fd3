//! The manifold's response: whether its pressure moves as far as pump, dump and valves must move it.
//!
//! A valve that does not close leaves its chamber at the manifold, which then moves by less than half of what it should alone; a
//! pump that is weak, a dump that is stuck, air that goes elsewhere show in the same way. A valve that does not open leaves the
//! manifold alone, which then moves further than it should. In blocks of 128 ms, longer than any dead time, the motion that the
//! model expects is compared with what the readings corrected: r = -sum(c e) / sum(e e), faded over the last 32 blocks, is the
//! share that did not come. The first motions of a sound machine with late valves can
//! leave 0.53, and more than 0.36 for three seconds, and that fades; the worst of 70,000 runs of host-sim's campaign is its
//! `--seed 2026 --replay 89346`. With a valve stuck open it comes to 0.36 to 0.9 and stays, with one stuck closed whose
//! chamber the bend does not tell to -0.35 and less. So a large share is believed soon, a smaller one late.

use super::held::lasts;
use crate::observer::Air;
use crate::units::Pressure;

/// A block's ticks.
const BLOCK: u8 = 128;
/// The sums fade to 1/e in so many blocks, as a power of two.
const FADES: u32 = 5;
/// Share that may be missing, in percent, and for how many blocks it must: the first motions of a machine with late valves look
/// like it.
const MISSING_PERCENT: i64 = 50;
const MISSING_BLOCKS: u8 = 12;
/// A smaller share that may not stay missing: those first motions fade.
const STILL_MISSING_PERCENT: i64 = 36;
const STILL_MISSING_BLOCKS: u8 = 44;
/// The same of the share that may come beyond what is expected.
const BEYOND_PERCENT: i64 = 33;
const BEYOND_BLOCKS: u8 = 4;
/// Motion (kPa squared, in the sum) below which the share is damped: errors of the estimates where little moves.
const LITTLE: i64 = 128 << (2 * FRACTION);
/// Bits of a kilopascal that are kept, so that 32 blocks of the largest squares fit.
const FRACTION: u32 = 6;

/// See the module's page.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    ticks: u8,
    /// Of this block.
    expected: Pressure,
    surprise: Pressure,
    /// Sums over the blocks, in kPa squared with twice [`FRACTION`] bits.
    against: i64,
    power: i64,
    missing: u8,
    still_missing: u8,
    beyond: u8,
}

impl Response {
    pub(super) const fn new() -> Self {
        Self {
            ticks: 0,
            expected: Pressure::ZERO,
            surprise: Pressure::ZERO,
            against: 0,
            power: 0,
            missing: 0,
            still_missing: 0,
            beyond: 0,
        }
    }

    /// One tick; true when the motion is not what it must be.
    pub(super) fn contradicts(&mut self, air: Air) -> bool {
        self.expected = self.expected + air.expected;
        self.surprise = self.surprise + air.surprise;
        self.ticks += 1;
        if self.ticks == BLOCK {
            self.end_block();
        }
        self.missing >= MISSING_BLOCKS || self.still_missing >= STILL_MISSING_BLOCKS || self.beyond >= BEYOND_BLOCKS
    }

    fn end_block(&mut self) {
        let bits = |pressure: &mut Pressure| i64::from(core::mem::take(pressure).to_bits() >> (16 - FRACTION));
        let (expected, surprise) = (bits(&mut self.expected), bits(&mut self.surprise));
        self.ticks = 0;
        self.against = self.against - (self.against >> FADES) - surprise * expected;
        self.power = self.power - (self.power >> FADES) + expected * expected;
        let (percent, all) = (self.against * 100, self.power + LITTLE);
        lasts(&mut self.missing, percent > all * MISSING_PERCENT, MISSING_BLOCKS);
        lasts(&mut self.still_missing, percent > all * STILL_MISSING_PERCENT, STILL_MISSING_BLOCKS);
        lasts(&mut self.beyond, percent < -all * BEYOND_PERCENT, BEYOND_BLOCKS);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tick of the first alarm within 30 s of a manifold that is to go up and down by 20 kPa each second, late by so many ms, and
    /// moves this share of it.
    fn first(share: f64, late: usize) -> Option<usize> {
        let mut response = Response::new();
        // 40 ms up at 0.5 kPa/ms, 40 ms down half a second later.
        let motion = |tick: usize| match tick % 1000 {
            0..40 => 0.5,
            500..540 => -0.5,
            _ => 0.0,
        };
        (0..30_000).find(|&tick| {
            let expected = motion(tick + 1000);
            let came = share * motion(tick + 1000 - late);
            response.contradicts(Air {
                expected: Pressure::from_f64_kpa(expected),
                surprise: Pressure::from_f64_kpa(came - expected),
                ..Air::STILL
            })
        })
    }

    #[test]
    fn what_moves_as_it_must_agrees_even_late() {
        assert_eq!(first(1.0, 0), None);
        assert_eq!(first(0.8, 0), None);
        assert_eq!(first(1.2, 10), None);
        assert_eq!(first(1.0, 30), None);
    }

    #[test]
    fn what_moves_by_half_or_not_at_all_or_twice_is_found() {
        for share in [0.45, 0.0, -1.0, 2.0] {
            let tick = first(share, 10).expect("found");
            assert!((400..9000).contains(&tick), "{share}: {tick}");
        }
    }

    #[test]
    fn the_largest_motion_wraps_nothing() {
        let mut response = Response::new();
        let air = Air { expected: Pressure::MAX, surprise: Pressure::MIN, ..Air::STILL };
        assert!((0..20_000).any(|_| response.contradicts(air)));
    }
}
