//! Interrupt controller: enable, pend, priorities (four bits, as on the STM32F4) and what is active.

/// Exception number of the first interrupt.
const FIRST: u16 = 16;

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Nvic {
    enabled: [u32; 4],
    pending: [u32; 4],
    active: [u32; 4],
    priority: [u8; 128],
    /// The interrupts being served, the innermost last.
    stack: Vec<u16>,
}

impl Nvic {
    pub const fn new() -> Self {
        Self { enabled: [0; 4], pending: [0; 4], active: [0; 4], priority: [0; 128], stack: Vec::new() }
    }

    pub fn pend(&mut self, irq: u16) {
        self.pending[usize::from(irq / 32)] |= 1 << (irq % 32);
    }

    pub fn is_active(&self, irq: u16) -> bool {
        self.active[usize::from(irq / 32)] >> (irq % 32) & 1 == 1
    }

    /// The interrupt that would be taken now if PRIMASK allows.
    pub fn deliverable(&self) -> Option<u16> {
        if self.pending.iter().zip(&self.enabled).all(|(pending, enabled)| pending & enabled == 0) {
            return None;
        }
        let running = self.stack.last().map_or(u8::MAX, |&irq| self.priority[usize::from(irq)]);
        (0..128_u16)
            .filter(|&irq| {
                (self.pending[usize::from(irq / 32)] & self.enabled[usize::from(irq / 32)]) >> (irq % 32) & 1 == 1
            })
            .min_by_key(|&irq| self.priority[usize::from(irq)])
            .filter(|&irq| self.priority[usize::from(irq)] < running)
    }

    /// Takes it: pending becomes active. Returns the exception number.
    pub fn enter(&mut self, irq: u16) -> u16 {
        self.pending[usize::from(irq / 32)] &= !(1 << (irq % 32));
        self.active[usize::from(irq / 32)] |= 1 << (irq % 32);
        self.stack.push(irq);
        irq + FIRST
    }

    /// Leaves the innermost.
    pub fn leave(&mut self) -> Option<u16> {
        let irq = self.stack.pop()?;
        self.active[usize::from(irq / 32)] &= !(1 << (irq % 32));
        Some(irq)
    }

    /// Reads a register at its offset from 0xE000E100.
    pub fn read(&self, offset: u32) -> Option<u32> {
        let index = (offset as usize & 0x7F) / 4;
        match offset {
            0x000..0x010 | 0x080..0x090 => Some(self.enabled[index]),
            0x100..0x110 | 0x180..0x190 => Some(self.pending[index]),
            0x200..0x210 => Some(self.active[index]),
            0x300..0x380 => {
                let at = (offset - 0x300) as usize & !3;
                Some(u32::from_le_bytes([0, 1, 2, 3].map(|byte| self.priority[at + byte])))
            }
            _ => None,
        }
    }

    /// Writes it.
    pub fn write(&mut self, offset: u32, size: usize, value: u32) -> Option<()> {
        let index = (offset as usize & 0x7F) / 4;
        match offset {
            0x000..0x010 => self.enabled[index] |= value,
            0x080..0x090 => self.enabled[index] &= !value,
            0x100..0x110 => self.pending[index] |= value,
            0x180..0x190 => self.pending[index] &= !value,
            0x300..0x380 => {
                for (byte, priority) in self.priority[(offset - 0x300) as usize..].iter_mut().take(size).enumerate() {
                    // Only the upper four bits exist.
                    *priority = (value >> (8 * byte)) as u8 & 0xF0;
                }
            }
            0xE00 => self.pend((value & 0x7F) as u16),
            _ => return None,
        }
        Some(())
    }
}
