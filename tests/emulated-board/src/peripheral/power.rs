//! Reset, clocks and supply: what is switched on is ready at once.

use model_core::protocol::ResetCause;

/// The flags in `RCC_CSR` that go with a cause; every reset that has a cause pulls the pin too.
const fn flags(cause: ResetCause) -> u32 {
    let pin = 1 << 26;
    match cause {
        ResetCause::PowerOn => pin | 1 << 27 | 1 << 25,
        ResetCause::Brownout => pin | 1 << 25,
        ResetCause::Pin => pin,
        ResetCause::Software => pin | 1 << 28,
        ResetCause::Watchdog => pin | 1 << 29,
        ResetCause::Other => 0,
    }
}

/// Reset and clock control.
#[derive(Clone, Debug)]
pub struct Rcc {
    registers: [u32; 0x98 / 4],
    flags: u32,
}

impl Rcc {
    pub const fn new(cause: ResetCause) -> Self {
        let mut registers = [0; 0x98 / 4];
        registers[0] = 0x83;
        registers[1] = 0x2400_3010;
        Self { registers, flags: flags(cause) }
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        let value = *self.registers.get(offset as usize / 4)?;
        let ready = |bits: u32| value & bits | (value & bits) << 1;
        Some(match offset {
            // HSI, HSE and the three PLLs are ready as soon as they are on.
            0x00 => value | ready(1 | 1 << 16 | 1 << 24 | 1 << 26 | 1 << 28),
            // The clock that is chosen is the one that runs.
            0x08 => value & !0xC | (value & 3) << 2,
            0x70 => value | ready(1),
            0x74 => value & 0x00FF_FFFF | ready(1) | self.flags,
            _ => value,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        *self.registers.get_mut(offset as usize / 4)? = value;
        if offset == 0x74 && value & 1 << 24 != 0 {
            self.flags = 0;
        }
        Some(())
    }
}

/// Power control.
#[derive(Clone, Debug, Default)]
pub struct Pwr {
    cr: u32,
    csr: u32,
}

impl Pwr {
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x0 => Some(self.cr),
            // Regulator scaling and over-drive are ready as soon as they are asked for.
            0x4 => Some(self.csr | 1 << 14 | self.cr & (3 << 16)),
            _ => None,
        }
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x0 => self.cr = value,
            0x4 => self.csr = value,
            _ => return None,
        }
        Some(())
    }
}
