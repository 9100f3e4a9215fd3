//! Whether what must come regularly does: the host's frames, and the ticks themselves.

use super::SILENCE_TICKS;

/// A late tick weighs so many good ones: ten at once are too many, and so is more than one in a hundred for long; a flash
/// page that is erased now and then is not.
const LATE: u16 = 100;
const TOO_LATE: u16 = 900;

/// See the module's page.
#[derive(Clone, Debug, Default)]
pub(super) struct Link {
    silent: u16,
    late: u16,
}

impl Link {
    pub(super) const fn new() -> Self {
        Self { silent: 0, late: 0 }
    }

    /// One tick. True when the host drives and is lost.
    pub(super) const fn host_is_lost(&mut self, heard: bool, drives: bool) -> bool {
        // While it does not drive it may be silent; the clock starts when it begins to.
        self.silent = if heard || !drives { 0 } else { self.silent.saturating_add(1) };
        self.silent > SILENCE_TICKS
    }

    /// One tick. True when too many have been late.
    pub(super) const fn ticks_are_late(&mut self, late: bool) -> bool {
        self.late = if late { self.late.saturating_add(LATE) } else { self.late.saturating_sub(1) };
        self.late > TOO_LATE
    }

    /// No tick was late for a while.
    pub(super) const fn is_calm(&self) -> bool {
        self.late < LATE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_of_silence_is_a_lost_host_while_it_drives() {
        let mut link = Link::new();
        assert!((0..5000).all(|_| !link.host_is_lost(false, false)));
        assert!((0..SILENCE_TICKS).all(|_| !link.host_is_lost(false, true)));
        assert!(link.host_is_lost(false, true));
        assert!(!link.host_is_lost(true, true));
    }

    #[test]
    fn many_late_ticks_are_found_and_few_are_none() {
        let mut link = Link::new();
        assert!((0..100_000).all(|tick| !link.ticks_are_late(tick % 150 == 0)));
        let mut link = Link::new();
        let found = (0..1000).position(|tick| link.ticks_are_late(tick % 40 == 0));
        assert!(found.is_some_and(|tick| tick <= 1000), "{found:?}");
        assert!(!link.is_calm());
        (0..900).for_each(|_| assert!(!link.ticks_are_late(false) || !link.is_calm()));
        assert!(link.is_calm());
    }
}
