//! General-purpose timer, counting up: update and compare events, and the time of each.

use crate::time::NEVER;

const CEN: u32 = 1;
const URS: u32 = 1 << 2;

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Timer {
    /// Ticks of virtual time in one cycle of the timer's input clock.
    input: u64,
    /// The counter's largest value: 16 or 32 bits.
    width: u64,
    cr1: u32,
    dier: u32,
    sr: u32,
    psc: u32,
    arr: u64,
    ccr: [u32; 4],
    others: [u32; 24],
    /// Count at the time `since`.
    count: u64,
    since: u64,
}

impl Timer {
    pub const fn new(input: u64, wide: bool) -> Self {
        let width = if wide { u32::MAX as u64 } else { 0xFFFF };
        Self {
            input,
            width,
            cr1: 0,
            dier: 0,
            sr: 0,
            psc: 0,
            arr: width,
            ccr: [0; 4],
            others: [0; 24],
            count: 0,
            since: 0,
        }
    }

    fn step(&self) -> u64 {
        self.input * (u64::from(self.psc) + 1)
    }

    /// Whether it counts.
    pub fn runs(&self) -> bool {
        self.cr1 & CEN != 0
    }

    /// Ticks between two updates.
    pub fn period(&self) -> u64 {
        self.step() * (self.arr + 1)
    }

    /// The first update after `time`.
    pub fn next_update(&self, time: u64) -> u64 {
        if !self.runs() {
            return NEVER;
        }
        let first = self.since + (self.arr + 1 - self.count) * self.step();
        if first > time { first } else { first + ((time - first) / self.period() + 1) * self.period() }
    }

    /// Whether updates leave as triggers (CR2.MMS = update).
    pub fn triggers(&self) -> bool {
        self.runs() && self.others[1] >> 4 & 7 == 2
    }

    fn events(&self) -> impl Iterator<Item = (u32, u64)> + '_ {
        // The update comes with count zero, a compare with its own value.
        let compares = self.ccr.iter().enumerate().map(|(index, &ccr)| (2 << index, u64::from(ccr)));
        std::iter::once((1, 0)).chain(compares)
    }

    /// When the counter next is at `value`, after now.
    fn time_of(&self, value: u64) -> u64 {
        if value > self.arr {
            return NEVER;
        }
        let period = self.arr + 1;
        let ahead = (value + period - self.count - 1) % period + 1;
        self.since + ahead * self.step()
    }

    /// The next event that raises an interrupt which is not raised yet.
    pub fn next_event(&self) -> u64 {
        if !self.runs() {
            return NEVER;
        }
        let wanted = self.events().filter(|(flag, _)| self.dier & flag != 0 && self.sr & flag == 0);
        wanted.map(|(_, value)| self.time_of(value)).min().unwrap_or(NEVER)
    }

    pub fn advance(&mut self, time: u64) {
        if !self.runs() {
            self.since = time;
            return;
        }
        let steps = (time - self.since) / self.step();
        let passed = self.events().filter(|&(_, value)| self.time_of(value) <= time);
        self.sr |= passed.fold(0, |all, (flag, _)| all | flag);
        self.count = (self.count + steps) % (self.arr + 1);
        self.since += steps * self.step();
    }

    pub fn raises(&self) -> bool {
        self.sr & self.dier & 0x1F != 0
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.cr1,
            0x0C => self.dier,
            0x10 => self.sr,
            0x14 => 0,
            0x24 => self.count as u32,
            0x28 => self.psc,
            0x2C => self.arr as u32,
            0x34..=0x40 => self.ccr[(offset as usize - 0x34) / 4],
            0x04 | 0x08 | 0x18..=0x20 => self.others[offset as usize / 4],
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => self.cr1 = value,
            0x0C => self.dier = value,
            // Flags are cleared by writing zero.
            0x10 => self.sr &= value,
            0x14 => {
                if value & 1 != 0 {
                    self.count = 0;
                    if self.cr1 & URS == 0 {
                        self.sr |= 1;
                    }
                }
            }
            0x24 => self.count = u64::from(value) & self.width,
            0x28 => self.psc = value & 0xFFFF,
            0x2C => self.arr = u64::from(value) & self.width,
            0x34..=0x40 => self.ccr[(offset as usize - 0x34) / 4] = value,
            0x04 | 0x08 | 0x18..=0x20 => self.others[offset as usize / 4] = value,
            _ => return None,
        }
        Some(())
    }
}
