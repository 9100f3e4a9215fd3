//! USART with DMA both ways; both directions take their time on the line.

use std::collections::VecDeque;

use crate::time::NEVER;

const IDLE: u32 = 1 << 4;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Usart {
    /// Ticks in one cycle of its clock.
    input: u64,
    sr: u32,
    brr: u32,
    cr: [u32; 3],
    dr: u32,
    /// Bytes on their way to the board, with the time each is there.
    arriving: VecDeque<(u64, u8)>,
    /// When the line has been silent for a character; `NEVER` when that was seen.
    idle_at: u64,
    last_arrival: u64,
    pub sent: Vec<u8>,
}

impl Usart {
    pub const fn new(input: u64) -> Self {
        Self {
            input,
            sr: TC | TXE,
            brr: 0,
            cr: [0; 3],
            dr: 0,
            arriving: VecDeque::new(),
            idle_at: NEVER,
            last_arrival: 0,
            sent: Vec::new(),
        }
    }

    /// Ticks of one character: start, eight bits, stop.
    pub fn character(&self) -> u64 {
        10 * self.input * u64::from(self.brr.max(16))
    }

    /// Queues bytes that a host sends from `now` on.
    pub fn receive(&mut self, now: u64, bytes: &[u8]) {
        let mut at = self.last_arrival.max(now);
        for &byte in bytes {
            at += self.character();
            self.arriving.push_back((at, byte));
        }
        self.last_arrival = at;
    }

    pub const fn receives_by_dma(&self) -> bool {
        self.cr[2] & 1 << 6 != 0 && self.cr[0] & 1 << 2 != 0
    }

    pub const fn transmits_by_dma(&self) -> bool {
        self.cr[2] & 1 << 7 != 0 && self.cr[0] & 1 << 3 != 0
    }

    pub fn next_arrival(&self) -> u64 {
        self.arriving.front().map_or(NEVER, |&(at, _)| at)
    }

    /// The next byte that has arrived by `time`. Without a receiver it is lost.
    pub fn arrived(&mut self, time: u64) -> Option<u8> {
        let (at, byte) = self.arriving.pop_front_if(|&mut (at, _)| at <= time)?;
        self.idle_at = at + self.character();
        (self.cr[0] & 1 << 2 != 0).then_some(byte)
    }

    pub const fn idle_at(&self) -> u64 {
        self.idle_at
    }

    pub fn advance(&mut self, time: u64) {
        if self.idle_at <= time && self.next_arrival() > self.idle_at {
            self.sr |= IDLE;
            self.idle_at = NEVER;
        }
    }

    pub fn raises(&self) -> bool {
        let cr1 = self.cr[0];
        self.sr & IDLE != 0 && cr1 & IDLE != 0
            || self.sr & RXNE != 0 && cr1 & RXNE != 0
            || self.sr & TC != 0 && cr1 & TC != 0
            || self.sr & TXE != 0 && cr1 & TXE != 0
    }

    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.sr,
            0x04 => {
                // Reading the data after the status clears what the receiver flagged.
                self.sr &= !(IDLE | RXNE);
                self.dr
            }
            0x08 => self.brr,
            0x0C..=0x14 => self.cr[(offset as usize - 0x0C) / 4],
            0x18 => 0,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            // TC and RXNE are cleared by writing zero; this transmitter is always done with what it was given.
            0x00 => self.sr &= value | !RXNE,
            0x04 => self.sent.push(value as u8),
            0x08 => self.brr = value,
            0x0C..=0x14 => self.cr[(offset as usize - 0x0C) / 4] = value,
            0x18 => {}
            _ => return None,
        }
        Some(())
    }
}
