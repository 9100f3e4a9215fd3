//! DMA controller: eight streams, direct mode, halves and ends flagged.

const EN: u32 = 1;
const HTIE: u32 = 1 << 3;
const TCIE: u32 = 1 << 4;
const CIRC: u32 = 1 << 8;
const MINC: u32 = 1 << 10;

const HALF: u32 = 1 << 4;
const END: u32 = 1 << 5;

/// Where a stream's flags lie within its status register.
const SHIFTS: [u32; 4] = [0, 6, 16, 22];

/// One stream.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stream {
    cr: u32,
    ndtr: u32,
    length: u32,
    par: u32,
    m0ar: u32,
    m1ar: u32,
    fcr: u32,
    flags: u32,
}

impl Stream {
    pub const fn runs(&self) -> bool {
        self.cr & EN != 0
    }

    /// Items until the end.
    pub const fn left(&self) -> u32 {
        self.ndtr
    }

    /// Items until the next flag that raises an interrupt.
    pub fn until_interrupt(&self) -> Option<u32> {
        if !self.runs() {
            return None;
        }
        let half = self.length / 2;
        let to_half = if self.ndtr > half { self.ndtr - half } else { self.ndtr + self.length - half };
        let half = (self.cr & HTIE != 0).then_some(to_half);
        let end = (self.cr & TCIE != 0).then_some(self.ndtr);
        half.into_iter().chain(end).min()
    }

    const fn item_bytes(&self) -> u32 {
        1 << (self.cr >> 13 & 3)
    }

    /// Moves one item: returns its address in memory, and goes on.
    pub fn next(&mut self) -> Option<u32> {
        if !self.runs() {
            return None;
        }
        let index = if self.cr & MINC != 0 { self.length - self.ndtr } else { 0 };
        let address = self.m0ar + index * self.item_bytes();
        self.ndtr -= 1;
        if self.ndtr == self.length / 2 {
            self.flags |= HALF;
        }
        if self.ndtr == 0 {
            self.flags |= END;
            if self.cr & CIRC == 0 {
                self.cr &= !EN;
            } else {
                self.ndtr = self.length;
            }
        }
        Some(address)
    }

    pub const fn raises(&self) -> bool {
        self.flags & HALF != 0 && self.cr & HTIE != 0 || self.flags & END != 0 && self.cr & TCIE != 0
    }
}

/// A controller.
#[derive(Clone, Debug, Default)]
pub struct Dma {
    pub streams: [Stream; 8],
}

impl Dma {
    pub fn read(&self, offset: u32) -> Option<u32> {
        let flags =
            |streams: &[Stream]| streams.iter().zip(SHIFTS).fold(0, |all, (stream, shift)| all | stream.flags << shift);
        if offset < 0x10 {
            return Some(match offset {
                0x0 => flags(&self.streams[..4]),
                0x4 => flags(&self.streams[4..]),
                _ => 0,
            });
        }
        let stream = self.streams.get((offset as usize - 0x10) / 0x18)?;
        Some(match (offset - 0x10) % 0x18 {
            0x00 => stream.cr,
            0x04 => stream.ndtr,
            0x08 => stream.par,
            0x0C => stream.m0ar,
            0x10 => stream.m1ar,
            _ => stream.fcr,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        if offset < 0x10 {
            let first = match offset {
                0x8 => 0,
                0xC => 4,
                _ => return None,
            };
            for (stream, shift) in self.streams[first..].iter_mut().zip(SHIFTS) {
                stream.flags &= !(value >> shift & 0x3D);
            }
            return Some(());
        }
        let stream = self.streams.get_mut((offset as usize - 0x10) / 0x18)?;
        match (offset - 0x10) % 0x18 {
            0x00 => {
                // The count it was given is what a circular stream starts over with. Switched off in mid-transfer it
                // flags its end.
                if value & EN != 0 && stream.cr & EN == 0 {
                    stream.length = stream.ndtr;
                } else if value & EN == 0 && stream.cr & EN != 0 {
                    stream.flags |= END;
                }
                stream.cr = value;
            }
            0x04 => stream.ndtr = value & 0xFFFF,
            0x08 => stream.par = value,
            0x0C => stream.m0ar = value,
            0x10 => stream.m1ar = value,
            _ => stream.fcr = value,
        }
        Some(())
    }
}
