//! Converter: scans its sequence at each trigger; the results leave by DMA.

const OVERRUN: u32 = 1 << 5;

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Adc {
    sr: u32,
    cr1: u32,
    cr2: u32,
    sequence: [u32; 3],
    dr: u32,
    others: [u32; 0x60 / 4],
    common: u32,
    /// Conversions done of each channel: where its dither is.
    done: [u32; 19],
    /// Input of each channel, as a mean code.
    inputs: [f64; 19],
    /// Scans that a software start asked for.
    pub started: u32,
    /// Broken: it converts no more.
    pub stopped: bool,
}

/// Conversions over which the mean of a channel's codes comes out at its input.
const DITHER: u32 = 16;

impl Adc {
    pub const fn new() -> Self {
        Self {
            sr: 0,
            cr1: 0,
            cr2: 0,
            sequence: [0; 3],
            dr: 0,
            others: [0; 0x60 / 4],
            common: 0,
            done: [0; 19],
            inputs: [0.0; 19],
            started: 0,
            stopped: false,
        }
    }

    /// What a channel's input carries from now on, as a mean code 0..=4095. The noise that the code was made with
    /// spreads a tick's conversions over several codes; here they are spread evenly, so that any sixteen in a row
    /// have that mean, rounded to a sixteenth.
    pub fn set_input(&mut self, channel: u8, code: f64) {
        self.inputs[usize::from(channel)] = code;
    }

    pub const fn runs(&self) -> bool {
        self.cr2 & 1 != 0 && self.sr & OVERRUN == 0 && !self.stopped
    }

    /// Whether a timer's trigger with this number starts a scan.
    pub const fn triggered_by(&self, external: u32) -> bool {
        self.runs() && self.cr2 >> 28 & 3 != 0 && self.cr2 >> 24 & 0xF == external
    }

    pub fn uses_dma(&self) -> bool {
        self.cr2 & 1 << 8 != 0
    }

    /// Channels of the sequence in their order.
    pub fn channels(&self) -> impl Iterator<Item = u8> + use<> {
        let sequence = self.sequence;
        let length = (sequence[0] >> 20 & 0xF) + 1;
        (0..length).map(move |rank| {
            let word = sequence[2 - (rank / 6) as usize];
            (word >> (5 * (rank % 6)) & 0x1F) as u8
        })
    }

    pub fn convert(&mut self, channel: u8) -> u16 {
        let index = usize::from(channel);
        let step = f64::from(self.done[index] % DITHER * 2 + 1) / f64::from(2 * DITHER);
        self.done[index] = self.done[index].wrapping_add(1);
        let code = (self.inputs[index] + step).floor().clamp(0.0, 4095.0) as u16;
        self.dr = u32::from(code);
        self.sr |= 1 << 4 | 1 << 1;
        code
    }

    /// A result that nobody fetched: conversions stop until the flag is cleared.
    pub fn overrun(&mut self) {
        self.sr |= OVERRUN;
    }

    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.sr,
            0x04 => self.cr1,
            0x08 => self.cr2,
            0x2C..=0x34 => self.sequence[(offset as usize - 0x2C) / 4],
            0x4C => {
                self.sr &= !(1 << 1);
                self.dr
            }
            0x0C..=0x28 => self.others[offset as usize / 4],
            0x304 => self.common,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => self.sr &= value,
            0x04 => self.cr1 = value,
            0x08 => {
                // A software start clears itself.
                self.cr2 = value & !(1 << 30);
                if value & 1 << 30 != 0 && value & 1 != 0 {
                    self.started += 1;
                }
            }
            0x2C..=0x34 => self.sequence[(offset as usize - 0x2C) / 4] = value,
            0x0C..=0x28 => self.others[offset as usize / 4] = value,
            0x304 => self.common = value,
            _ => return None,
        }
        Some(())
    }
}
