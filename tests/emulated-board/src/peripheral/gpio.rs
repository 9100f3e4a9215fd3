//! Ports and the external interrupt controller.

/// One port. A pin that is no output carries what is wired to it.
#[derive(Clone, Debug)]
pub struct Port {
    moder: u32,
    odr: u32,
    others: [u32; 10],
    wired: u32,
}

impl Port {
    pub const fn new(moder: u32) -> Self {
        Self { moder, odr: 0, others: [0; 10], wired: 0 }
    }

    /// Level that is wired to a pin; returns whether it changed.
    pub fn wire(&mut self, pin: u8, high: bool) -> bool {
        let before = self.wired;
        self.wired = self.wired & !(1 << pin) | u32::from(high) << pin;
        before != self.wired
    }

    /// What the pin drives; `None` when it is no output.
    pub const fn driven(&self, pin: u8) -> Option<bool> {
        if self.moder >> (2 * pin) & 3 == 1 { Some(self.odr >> pin & 1 == 1) } else { None }
    }

    fn levels(&self) -> u32 {
        (0..16).fold(0, |all, pin| all | u32::from(self.driven(pin).unwrap_or(self.wired >> pin & 1 == 1)) << pin)
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.moder,
            0x10 => self.levels(),
            0x14 => self.odr,
            0x18 => 0,
            0x04..=0x0C | 0x1C..=0x24 => self.others[offset as usize / 4],
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => self.moder = value,
            0x14 => self.odr = value & 0xFFFF,
            // Set wins over reset.
            0x18 => self.odr = self.odr & !(value >> 16) | value & 0xFFFF,
            0x04..=0x0C | 0x1C..=0x24 => self.others[offset as usize / 4] = value,
            _ => return None,
        }
        Some(())
    }
}

/// EXTI with SYSCFG's line multiplexer.
#[derive(Clone, Debug, Default)]
pub struct Exti {
    imr: u32,
    emr: u32,
    rtsr: u32,
    ftsr: u32,
    pr: u32,
    syscfg: [u32; 9],
}

impl Exti {
    /// A pin's level changed.
    pub fn edge(&mut self, port: u8, pin: u8, rising: bool) {
        let chosen = self.syscfg[2 + usize::from(pin / 4)] >> (4 * (pin % 4)) & 0xF;
        let selected = if rising { self.rtsr } else { self.ftsr };
        if chosen == u32::from(port) && selected >> pin & 1 == 1 {
            self.pr |= 1 << pin;
        }
    }

    /// The interrupts that are raised.
    pub fn raised(&self) -> impl Iterator<Item = u16> + use<> {
        let lines = self.pr & self.imr;
        (0..16_u16).filter(move |line| lines >> line & 1 == 1).map(|line| match line {
            0..=4 => 6 + line,
            5..=9 => 23,
            _ => 40,
        })
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.imr,
            0x04 => self.emr,
            0x08 => self.rtsr,
            0x0C => self.ftsr,
            0x10 => 0,
            0x14 => self.pr,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => self.imr = value,
            0x04 => self.emr = value,
            0x08 => self.rtsr = value,
            0x0C => self.ftsr = value,
            0x10 => self.pr |= value & self.imr,
            0x14 => self.pr &= !value,
            _ => return None,
        }
        Some(())
    }

    pub fn read_syscfg(&self, offset: u32) -> Option<u32> {
        self.syscfg.get(offset as usize / 4).copied()
    }

    pub fn write_syscfg(&mut self, offset: u32, value: u32) -> Option<()> {
        *self.syscfg.get_mut(offset as usize / 4)? = value;
        Some(())
    }
}
