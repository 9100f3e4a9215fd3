//! A chamber that is filled and emptied in turn although its setpoint rests.
//!
//! The model's dead time is one figure for pump, dump and valves. On a machine whose parts differ each service can end where
//! the opposite one is due, for ever: valves that wear, and a finger that trembles. Who has been turned often is therefore
//! served with a wider band, until its setpoint moves or nothing has been asked of it for a while.

use super::{Direction, milli_kpa};
use crate::units::Pressure;

/// Turns that are free: an overshoot that is taken back, and one more.
const FREE: u8 = 2;
/// Width that each further turn adds, and the most turns that count.
const WIDENS: Pressure = milli_kpa(250);
const MOST: u8 = 6;
/// Ticks without a turn after which they are forgotten.
const FORGOTTEN: u32 = 20_000;

/// One chamber's turns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hunting {
    last: Option<Direction>,
    turns: u8,
    ticks: u32,
}

impl Hunting {
    pub(super) const NONE: Self = Self { last: None, turns: 0, ticks: 0 };

    /// One more tick; forgets all when the setpoint has `moved`.
    pub(super) fn tick(&mut self, moved: bool) {
        self.ticks = self.ticks.saturating_add(1);
        if moved || self.ticks > FORGOTTEN {
            *self = Self::NONE;
        }
    }

    /// A service of this chamber begins.
    pub(super) fn served(&mut self, direction: Direction) {
        if self.last.is_some_and(|last| last != direction) {
            self.turns = self.turns.saturating_add(1).min(MOST);
            self.ticks = 0;
        }
        self.last = Some(direction);
    }

    /// By how much its band is wider.
    pub(super) fn widens(self) -> Pressure {
        (0..self.turns.saturating_sub(FREE)).fold(Pressure::ZERO, |sum, _| sum + WIDENS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(turns: usize) -> Hunting {
        let mut hunting = Hunting::NONE;
        for turn in 0..=turns {
            hunting.served(if turn % 2 == 0 { Direction::Rise } else { Direction::Fall });
        }
        hunting
    }

    #[test]
    fn turns_beyond_the_second_widen_the_band_to_a_kilopascal_more_at_most() {
        let widths = [0, 1, 2, 3, 4, 6, 100].map(|turns| after(turns).widens());
        assert_eq!(widths, [0, 0, 0, 250, 500, 1000, 1000].map(milli_kpa));
    }

    #[test]
    fn the_same_way_again_is_no_turn() {
        let mut hunting = after(1);
        (0..100).for_each(|_| hunting.served(Direction::Fall));
        assert_eq!(hunting.widens(), Pressure::ZERO);
    }

    #[test]
    fn a_moved_setpoint_or_rest_forgets() {
        let mut hunting = after(6);
        hunting.tick(true);
        assert_eq!(hunting.widens(), Pressure::ZERO);
        let mut hunting = after(6);
        (0..FORGOTTEN).for_each(|_| hunting.tick(false));
        assert_eq!(hunting.widens(), milli_kpa(1000));
        hunting.tick(false);
        assert_eq!(hunting.widens(), Pressure::ZERO);
    }
}
