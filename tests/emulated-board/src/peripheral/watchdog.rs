//! Independent watchdog on its 32 kHz clock.

use crate::time::{NEVER, TICKS_PER_SECOND};

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Watchdog {
    prescaler: u32,
    reload: u32,
    unlocked: bool,
    started: bool,
    fed_at: u64,
}

impl Watchdog {
    pub const fn new() -> Self {
        Self { prescaler: 0, reload: 0xFFF, unlocked: false, started: false, fed_at: 0 }
    }

    /// When it bites.
    pub fn bites_at(&self) -> u64 {
        if !self.started {
            return NEVER;
        }
        let cycles = (u64::from(self.reload) + 1) * (4 << self.prescaler.min(6));
        self.fed_at + cycles * TICKS_PER_SECOND / 32_000
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
                0xAAAA => (self.fed_at, self.unlocked) = (now, false),
                0xCCCC => (self.started, self.fed_at, self.unlocked) = (true, now, false),
                _ => self.unlocked = false,
            },
            0x4 if self.unlocked => self.prescaler = value & 7,
            0x8 if self.unlocked => self.reload = value & 0xFFF,
            0x4 | 0x8 => {}
            _ => return None,
        }
        Some(())
    }
}
