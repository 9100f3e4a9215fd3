//! Flash controller: the two sectors at the end hold the settings and can be erased and programmed; the program cannot.

use crate::time::{MICROSECOND, MILLISECOND};

/// First address of the two sectors that hold the settings.
pub const SETTINGS: u32 = 0x0804_0000;
/// Bytes of one of them.
pub const SECTOR: usize = 128 * 1024;

/// A word takes 16 us, a 128 KiB sector one second (data sheet DS10693, table "Flash memory programming", typical).
const PROGRAM: u64 = 16 * MICROSECOND;
const ERASE: u64 = 1000 * MILLISECOND;

const PG: u32 = 1;
const SER: u32 = 1 << 1;
const STRT: u32 = 1 << 16;
const LOCK: u32 = 1 << 31;
const PROGRAM_SEQUENCE_ERROR: u32 = 1 << 7;

/// What one access costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Nothing.
    Free,
    /// The core stalls for these ticks: it runs from the memory that is busy.
    Stall(u64),
    /// The power went in the middle of it.
    PowerCut,
}

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Flash {
    /// Contents of the two sectors.
    pub settings: Vec<u8>,
    acr: u32,
    sr: u32,
    cr: u32,
    key: u32,
    /// Operations done since power came.
    pub operations: u32,
    /// The operation in whose middle the power goes.
    pub cut_at: Option<u32>,
}

impl Flash {
    pub fn new() -> Self {
        Self { settings: vec![0xFF; 2 * SECTOR], acr: 0, sr: 0, cr: LOCK, key: 0, operations: 0, cut_at: None }
    }

    /// As after a reset; the contents stay.
    pub fn reset(&mut self) {
        (self.acr, self.sr, self.cr, self.key, self.operations, self.cut_at) = (0, 0, LOCK, 0, 0, None);
    }

    fn operation(&mut self) -> bool {
        self.operations += 1;
        self.cut_at == Some(self.operations)
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.acr,
            0x0C => self.sr,
            0x10 => self.cr,
            0x14 => 0x0FFF_AAED,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<Cost> {
        match offset {
            0x00 => self.acr = value,
            0x04 => {
                if self.key == 0x4567_0123 && value == 0xCDEF_89AB {
                    self.cr &= !LOCK;
                }
                self.key = value;
            }
            0x0C => self.sr &= !value,
            0x10 if self.cr & LOCK == 0 => {
                self.cr = value & !STRT;
                if value & (STRT | SER) == STRT | SER {
                    return self.erase(value >> 3 & 0xF);
                }
            }
            0x10 => {}
            _ => return None,
        }
        Some(Cost::Free)
    }

    fn erase(&mut self, sector: u32) -> Option<Cost> {
        // Sectors 6 and 7; another would take the program away.
        let start = (sector.checked_sub(6).filter(|&index| index < 2)? as usize) * SECTOR;
        let bytes = &mut self.settings[start..start + SECTOR];
        if self.cut_at == Some(self.operations + 1) {
            // Cells are discharged together; cut short, any of them may read either way.
            for (index, byte) in bytes.iter_mut().enumerate() {
                *byte |= (index as u8).wrapping_mul(0x9D) ^ 0x5A;
            }
        } else {
            bytes.fill(0xFF);
        }
        Some(if self.operation() { Cost::PowerCut } else { Cost::Stall(ERASE) })
    }

    pub fn read_memory(&self, offset: usize, size: usize) -> Option<u32> {
        let bytes = self.settings.get(offset..offset + size)?;
        Some(bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte)))
    }

    /// Programming clears bits and sets none.
    pub fn program(&mut self, offset: usize, size: usize, value: u32) -> Option<Cost> {
        if self.cr & (PG | LOCK) != PG {
            self.sr |= PROGRAM_SEQUENCE_ERROR;
            return Some(Cost::Free);
        }
        let cut = self.cut_at == Some(self.operations + 1);
        for (index, byte) in self.settings.get_mut(offset..offset + size)?.iter_mut().enumerate() {
            // Cut short, every second bit has made it.
            *byte &= (value >> (8 * index)) as u8 | if cut { 0x55 } else { 0 };
        }
        Some(if self.operation() { Cost::PowerCut } else { Cost::Stall(PROGRAM) })
    }
}
