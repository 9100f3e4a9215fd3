//! Independent watchdog on its 32 kHz clock.

use crate::time::{NEVER, TICKS_PER_SECOND};

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Watchdog {
    prescaler: u32,
    reload: u32,
    unlocked: bool,
    started: bool,
    /// What the counter was at the time `since`; a new reload value waits for the next feeding.
    count: u64,
    since: u64,
}

impl Watchdog {
    pub const fn new() -> Self {
        Self { prescaler: 0, reload: 0xFFF, unlocked: false, started: false, count: 0xFFF, since: 0 }
    }

    /// Ticks of one count.
    fn step(&self) -> u64 {
        (4 << self.prescaler.min(6)) * TICKS_PER_SECOND / 32_000
    }

    /// When it bites.
    pub fn bites_at(&self) -> u64 {
        if self.started { self.since + (self.count + 1) * self.step() } else { NEVER }
    }

    fn feed(&mut self, now: u64) {
        (self.count, self.since, self.unlocked) = (u64::from(self.reload), now, false);
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x4 => Some(self.prescaler),
            0x8 => Some(self.reload),
            0x0 | 0xC => Some(0),
            _ => None,
        }
    }

    pub fn write(&mut self, now: u64, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x0 => match value {
                0x5555 => self.unlocked = true,
                0xAAAA => self.feed(now),
                0xCCCC => {
                    self.started = true;
                    self.feed(now);
                }
                _ => self.unlocked = false,
            },
            0x4 if self.unlocked => {
                // The counter goes on from where it is, at the new pace.
                let passed = (now - self.since) / self.step();
                (self.count, self.since) = (self.count.saturating_sub(passed), now);
                self.prescaler = value & 7;
            }
            0x8 if self.unlocked => self.reload = value & 0xFFF,
            0x4 | 0x8 => {}
            _ => return None,
        }
        Some(())
    }
}
