//! The bus: peripherals at their addresses, events in their order.

use crate::peripheral::adc::Adc;
use crate::peripheral::dma::Dma;
use crate::peripheral::flash::{Cost, Flash};
use crate::peripheral::gpio::{Exti, Port};
use crate::peripheral::nvic::Nvic;
use crate::peripheral::power::{Pwr, Rcc};
use crate::peripheral::timer::Timer;
use crate::peripheral::usart::Usart;
use crate::peripheral::watchdog::Watchdog;
use crate::time::NEVER;
use model_core::protocol::ResetCause;
use unicorn_engine::{RegisterARM, Unicorn};

/// Number of the ADC's trigger that TIM3's update is.
const TIM3_TRIGGER: u32 = 8;
const RECEIVE_STREAM: usize = 5;
const TRANSMIT_STREAM: usize = 6;
const CONVERTER_STREAM: usize = 0;

/// Why the core stopped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Halt {
    /// An access that is not modelled, or one that a chip would fault on.
    Error(String),
    /// The board was reset.
    Reset(ResetCause),
    /// The power went in the middle of a flash operation.
    PowerCut,
}

/// Everything but the core and its memory.
#[derive(Debug)]
pub struct Machine {
    pub time: u64,
    /// Not before this time does anything happen by itself.
    pub next_event: u64,
    pub halt: Option<Halt>,
    pub nvic: Nvic,
    pub ports: [Port; 8],
    pub exti: Exti,
    pub adc: Adc,
    pub usart: Usart,
    pub flash: Flash,
    pub watchdog: Watchdog,
    rcc: Rcc,
    pwr: Pwr,
    /// TIM3, which triggers the converter, and TIM5, which keeps the firmware's time; both clocked at 90 MHz.
    sampling: Timer,
    clock: Timer,
    dma1: Dma,
    dma2: Dma,
    system: [u32; 0x400],
    debug: [u32; 4],
    scanned_to: u64,
    sent_at: u64,
    /// What the converter delivered, scan by scan.
    pub converted: Vec<[u16; 2]>,
    /// The core's own state between quanta.
    pub core: Core,
}

/// What the emulator keeps of the core beside its registers.
#[derive(Debug, Default)]
pub struct Core {
    /// The event register that WFE waits for.
    pub event: bool,
    /// An exception is over: its frame has to be popped.
    pub returned: bool,
    /// The core was stopped from outside, at the start of a block.
    pub stopped: bool,
    /// Blocks to let pass until interrupts are looked at again, because they are masked.
    pub grace: u32,
    pub instructions: u64,
    /// Time at which the core stops whatever happens.
    pub deadline: u64,
}

impl Machine {
    pub fn new(cause: ResetCause, flash: Flash) -> Self {
        // Debug pins of ports A and B are alternate functions after reset.
        let mut ports: [Port; 8] = core::array::from_fn(|_| Port::new(0));
        ports[0] = Port::new(0xA800_0000);
        ports[1] = Port::new(0x0000_0280);
        Self {
            time: 0,
            next_event: NEVER,
            halt: None,
            nvic: Nvic::new(),
            ports,
            exti: Exti::default(),
            adc: Adc::new(),
            usart: Usart::new(16),
            flash,
            watchdog: Watchdog::new(),
            rcc: Rcc::new(cause),
            pwr: Pwr::default(),
            sampling: Timer::new(8, false),
            clock: Timer::new(8, true),
            dma1: Dma::default(),
            dma2: Dma::default(),
            system: [0; 0x400],
            debug: [0; 4],
            scanned_to: 0,
            sent_at: NEVER,
            converted: Vec::new(),
            core: Core::default(),
        }
    }

    /// The first scan after `scanned_to` that a trigger starts.
    fn next_scan(&self) -> u64 {
        if self.adc.triggered_by(TIM3_TRIGGER) && self.sampling.triggers() {
            self.sampling.next_update(self.scanned_to)
        } else {
            NEVER
        }
    }

    /// When the converter's DMA next raises its interrupt: scans before that need nobody.
    fn next_conversion_interrupt(&self) -> u64 {
        let first = self.next_scan();
        let channels = self.adc.channels().count() as u32;
        match self.dma2.streams[CONVERTER_STREAM].until_interrupt() {
            Some(items) if first != NEVER => first + u64::from(items.div_ceil(channels) - 1) * self.sampling.period(),
            _ => NEVER,
        }
    }

    pub fn reschedule(&mut self) {
        if self.sent_at == NEVER && self.usart.transmits_by_dma() && self.dma1.streams[TRANSMIT_STREAM].runs() {
            let characters = u64::from(self.dma1.streams[TRANSMIT_STREAM].left());
            self.sent_at = self.time + characters * self.usart.character();
        }
        self.next_event = [
            self.clock.next_event(),
            self.sampling.next_event(),
            self.next_conversion_interrupt(),
            if self.adc.started > 0 { self.time } else { NEVER },
            self.usart.next_arrival(),
            self.usart.idle_at(),
            self.sent_at,
            self.watchdog.bites_at(),
        ]
        .into_iter()
        .min()
        .unwrap_or(NEVER);
        self.raise();
    }

    /// Pends every interrupt whose source is up.
    pub fn raise(&mut self) {
        let dma1 = &self.dma1.streams;
        let sources = [
            (self.clock.raises(), 50),
            (self.sampling.raises(), 29),
            (self.usart.raises(), 38),
            (dma1[RECEIVE_STREAM].raises(), 16),
            (dma1[TRANSMIT_STREAM].raises(), 17),
            (self.dma2.streams[CONVERTER_STREAM].raises(), 56),
        ];
        let lines = self.exti.raised();
        for irq in sources.into_iter().filter_map(|(up, irq)| up.then_some(irq)).chain(lines) {
            if !self.nvic.is_active(irq) {
                self.nvic.pend(irq);
            }
        }
    }

    /// A level wired to a pin changes.
    pub fn wire(&mut self, port: u8, pin: u8, high: bool) {
        if self.ports[usize::from(port)].wire(pin, high) {
            self.exti.edge(port, pin, high);
            self.raise();
        }
    }

    fn peripheral_read(&mut self, address: u32) -> Option<u32> {
        match address {
            0x4000_0400..0x4000_0800 => self.sampling.read(address & 0x3FF),
            0x4000_0C00..0x4000_1000 => self.clock.read(address & 0x3FF),
            0x4000_3000..0x4000_3400 => self.watchdog.read(address & 0x3FF),
            0x4000_4400..0x4000_4800 => self.usart.read(address & 0x3FF),
            0x4000_7000..0x4000_7400 => self.pwr.read(address & 0x3FF),
            0x4001_2000..0x4001_2400 => self.adc.read(address & 0x3FF),
            0x4001_3800..0x4001_3C00 => self.exti.read_syscfg(address & 0x3FF),
            0x4001_3C00..0x4001_4000 => self.exti.read(address & 0x3FF),
            0x4002_0000..0x4002_2000 => self.ports[(address as usize >> 10) & 7].read(address & 0x3FF),
            0x4002_3800..0x4002_3C00 => self.rcc.read(address & 0x3FF),
            0x4002_3C00..0x4002_4000 => self.flash.read(address & 0x3FF),
            0x4002_6000..0x4002_6400 => self.dma1.read(address & 0x3FF),
            0x4002_6400..0x4002_6800 => self.dma2.read(address & 0x3FF),
            // Cycle counter.
            0xE000_1000 => Some(1),
            0xE000_1004 => Some((self.time / crate::time::INSTRUCTION) as u32),
            0xE000_E100..0xE000_E500 | 0xE000_EF00 => self.nvic.read(address - 0xE000_E100),
            0xE000_E008 | 0xE000_ED00..0xE000_EF90 => self.system.get((address as usize & 0xFFF) / 4).copied(),
            0xE004_2000..0xE004_2010 => self.debug.get((address as usize & 0xF) / 4).copied(),
            _ => None,
        }
    }

    fn peripheral_write(&mut self, address: u32, size: usize, value: u32) -> Option<()> {
        let now = self.time;
        match address {
            0x4000_0400..0x4000_0800 => self.sampling.write(address & 0x3FF, value),
            0x4000_0C00..0x4000_1000 => self.clock.write(address & 0x3FF, value),
            0x4000_3000..0x4000_3400 => self.watchdog.write(now, address & 0x3FF, value),
            0x4000_4400..0x4000_4800 => self.usart.write(address & 0x3FF, value),
            0x4000_7000..0x4000_7400 => self.pwr.write(address & 0x3FF, value),
            0x4001_2000..0x4001_2400 => self.adc.write(address & 0x3FF, value),
            0x4001_3800..0x4001_3C00 => self.exti.write_syscfg(address & 0x3FF, value),
            0x4001_3C00..0x4001_4000 => self.exti.write(address & 0x3FF, value),
            0x4002_0000..0x4002_2000 => self.ports[(address as usize >> 10) & 7].write(address & 0x3FF, value),
            0x4002_3800..0x4002_3C00 => self.rcc.write(address & 0x3FF, value),
            0x4002_3C00..0x4002_4000 => {
                let cost = self.flash.write(address & 0x3FF, value)?;
                self.pay(cost);
                Some(())
            }
            0x4002_6000..0x4002_6400 => self.dma1.write(address & 0x3FF, value),
            0x4002_6400..0x4002_6800 => self.dma2.write(address & 0x3FF, value),
            0xE000_1000..0xE000_1008 => Some(()),
            0xE000_E100..0xE000_E500 | 0xE000_EF00 => self.nvic.write(address - 0xE000_E100, size, value),
            0xE000_ED0C => {
                if value & 4 != 0 {
                    self.halt = Some(Halt::Reset(ResetCause::Software));
                }
                Some(())
            }
            0xE000_E008 | 0xE000_ED00..0xE000_EF90 => {
                *self.system.get_mut((address as usize & 0xFFF) / 4)? = value;
                Some(())
            }
            0xE004_2000..0xE004_2010 => {
                *self.debug.get_mut((address as usize & 0xF) / 4)? = value;
                Some(())
            }
            _ => None,
        }
    }

    fn pay(&mut self, cost: Cost) {
        match cost {
            Cost::Free => {}
            Cost::Stall(ticks) => self.time += ticks,
            Cost::PowerCut => self.halt = Some(Halt::PowerCut),
        }
    }
}

/// Lets every event up to the present happen.
pub fn settle(uc: &mut Unicorn<'_, Machine>) {
    let now = uc.get_data().time;
    scan(uc, now);
    receive(uc, now);
    transmit(uc, now);
    let machine = uc.get_data_mut();
    machine.clock.advance(now);
    machine.sampling.advance(now);
    machine.usart.advance(now);
    if machine.watchdog.bites_at() <= now {
        machine.halt = Some(Halt::Reset(ResetCause::Watchdog));
    }
    machine.reschedule();
}

/// Conversions whose triggers have come.
fn scan(uc: &mut Unicorn<'_, Machine>, now: u64) {
    loop {
        let machine = uc.get_data_mut();
        if machine.adc.started > 0 {
            machine.adc.started -= 1;
        } else {
            let next = machine.next_scan();
            if next > now {
                break;
            }
            machine.scanned_to = next;
        }
        let mut codes = [0; 2];
        for (index, channel) in machine.adc.channels().enumerate() {
            let machine = uc.get_data_mut();
            let code = machine.adc.convert(channel);
            if let Some(place) = codes.get_mut(index) {
                *place = code;
            }
            if !machine.adc.uses_dma() {
                continue;
            }
            match machine.dma2.streams[CONVERTER_STREAM].next() {
                Some(address) => store(uc, address, &code.to_le_bytes()),
                None => machine.adc.overrun(),
            }
        }
        uc.get_data_mut().converted.push(codes);
    }
    uc.get_data_mut().scanned_to = now;
}

fn receive(uc: &mut Unicorn<'_, Machine>, now: u64) {
    while uc.get_data().usart.next_arrival() <= now {
        let machine = uc.get_data_mut();
        let Some(byte) = machine.usart.arrived(now) else { continue };
        if machine.usart.receives_by_dma()
            && let Some(address) = machine.dma1.streams[RECEIVE_STREAM].next()
        {
            store(uc, address, &[byte]);
        }
        uc.get_data_mut().usart.advance(now);
    }
}

fn transmit(uc: &mut Unicorn<'_, Machine>, now: u64) {
    if uc.get_data().sent_at > now {
        return;
    }
    while let Some(address) = uc.get_data_mut().dma1.streams[TRANSMIT_STREAM].next() {
        let mut byte = [0];
        if uc.mem_read(u64::from(address), &mut byte).is_err() {
            uc.get_data_mut().halt = Some(Halt::Error(format!("DMA reads {address:#010x}, where nothing is")));
        }
        uc.get_data_mut().usart.sent.push(byte[0]);
    }
    uc.get_data_mut().sent_at = NEVER;
}

fn store(uc: &mut Unicorn<'_, Machine>, address: u32, bytes: &[u8]) {
    if uc.mem_write(u64::from(address), bytes).is_err() {
        uc.get_data_mut().halt = Some(Halt::Error(format!("DMA writes {address:#010x}, where nothing is")));
    }
}

/// A load from a peripheral.
pub fn load_at(uc: &mut Unicorn<'_, Machine>, address: u32, size: usize) -> u64 {
    settle(uc);
    // Smaller loads than a word take their part of it.
    let word = uc.get_data_mut().peripheral_read(address & !3);
    let Some(word) = word else {
        refuse(uc, "reads", address, size);
        return 0;
    };
    u64::from(word >> (8 * (address & 3)))
}

/// A store to a peripheral.
pub fn store_at(uc: &mut Unicorn<'_, Machine>, address: u32, size: usize, value: u64) {
    settle(uc);
    if uc.get_data_mut().peripheral_write(address, size, value as u32).is_none() {
        refuse(uc, "writes", address, size);
    }
    uc.get_data_mut().reschedule();
    if uc.get_data().halt.is_some() {
        let _ = uc.emu_stop();
    }
}

/// A load from the settings' sectors.
pub fn load_settings(uc: &mut Unicorn<'_, Machine>, offset: usize, size: usize) -> u64 {
    u64::from(uc.get_data().flash.read_memory(offset, size).unwrap_or(0))
}

/// A store to the settings' sectors.
pub fn program_settings(uc: &mut Unicorn<'_, Machine>, offset: usize, size: usize, value: u64) {
    let machine = uc.get_data_mut();
    if let Some(cost) = machine.flash.program(offset, size, value as u32) {
        machine.pay(cost);
    }
    settle(uc);
    if uc.get_data().halt.is_some() {
        let _ = uc.emu_stop();
    }
}

fn refuse(uc: &mut Unicorn<'_, Machine>, what: &str, address: u32, size: usize) {
    let pc = uc.reg_read(RegisterARM::PC).unwrap_or(0);
    let message = format!("the firmware {what} {size} bytes at {address:#010x}, which is not modelled (PC {pc:#010x})");
    uc.get_data_mut().halt.get_or_insert(Halt::Error(message));
    let _ = uc.emu_stop();
}
