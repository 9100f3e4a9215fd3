//! For how long something has been commanded so.

/// A command and the ticks since it changed last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    on: bool,
    ticks: u16,
}

impl Held {
    /// From now on: what was before is not known.
    pub(super) const fn new(on: bool) -> Self {
        Self { on, ticks: 0 }
    }

    /// One more tick of it.
    pub(super) const fn push(&mut self, on: bool) {
        self.ticks = if on == self.on { self.ticks.saturating_add(1) } else { 0 };
        self.on = on;
    }

    /// On, for at least so long.
    pub(super) const fn on_for(self, ticks: u16) -> bool {
        self.on && self.ticks >= ticks
    }

    /// Off, for at least so long.
    pub(super) const fn off_for(self, ticks: u16) -> bool {
        !self.on && self.ticks >= ticks
    }

    /// Either, for at least so long.
    pub(super) const fn unchanged_for(self, ticks: u16) -> bool {
        self.ticks >= ticks
    }
}

/// Counts the ticks for which a condition holds without a break; true from `ticks` on.
pub(super) const fn lasts(count: &mut u8, condition: bool, ticks: u8) -> bool {
    *count = if condition { count.saturating_add(1) } else { 0 };
    *count >= ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_starts_the_clock() {
        let mut held = Held::new(false);
        assert!(held.off_for(0) && !held.off_for(1) && !held.on_for(0));
        held.push(true);
        assert!(held.on_for(0) && !held.on_for(1) && !held.off_for(0));
        held.push(true);
        assert!(held.on_for(1) && held.unchanged_for(1) && !held.unchanged_for(2));
    }

    #[test]
    fn a_break_starts_the_count() {
        let mut count = 0;
        assert!(![true, true, false, true, true].map(|holds| lasts(&mut count, holds, 3))[4]);
        assert!(lasts(&mut count, true, 3));
    }
}
