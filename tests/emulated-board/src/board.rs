//! The board: core, memory, exceptions, and what a test reaches from outside.

use crate::machine::{self, Core, Halt, Machine};
use crate::peripheral::flash::{Flash, SECTOR, SETTINGS};
use crate::rtt::Log;
use crate::time::{INSTRUCTION, MILLISECOND};
use anyhow::{Result, anyhow, bail, ensure};
use model_core::protocol::ResetCause;
use object::elf::PT_LOAD;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Object, ObjectSymbol};
use unicorn_engine::{Arch, ArmCpuModel, HookType, Mode, Prot, RegisterARM, Unicorn, uc_error};

pub(crate) const FLASH: u32 = 0x0800_0000;
pub(crate) const RAM: u32 = 0x2000_0000;
pub(crate) const RAM_BYTES: u32 = 128 * 1024;
/// System memory with the serial number and the flash size.
const SYSTEM_ROM: u32 = 0x1FFF_0000;
const SERIAL: [u32; 3] = [0x0046_0052, 0x4D4F_5243, 0x2034_3436];
/// Fills the RAM before a start, so that it shows how deep the stack has been.
const PAINT: u8 = 0xA5;
/// An endless loop (`b .`) lies here, in RAM that nothing uses, for tests that hang the core.
const TRAP: u32 = RAM + RAM_BYTES / 2;

/// Returns to thread mode, floating-point frame, main stack.
const EXC_RETURN_THREAD: u32 = 0xFFFF_FFE9;
/// Returns to another handler.
const EXC_RETURN_HANDLER: u32 = 0xFFFF_FFE1;
/// Bytes of a frame with floating-point registers: r0-r3, r12, lr, pc, xPSR; s0-s15, FPSCR, one reserved.
const FRAME: u32 = 0x68;

const FRAME_REGISTERS: [RegisterARM; 7] = [
    RegisterARM::R0,
    RegisterARM::R1,
    RegisterARM::R2,
    RegisterARM::R3,
    RegisterARM::R12,
    RegisterARM::LR,
    RegisterARM::PC,
];
const FLOAT_REGISTERS: [RegisterARM; 8] = [
    RegisterARM::D0,
    RegisterARM::D1,
    RegisterARM::D2,
    RegisterARM::D3,
    RegisterARM::D4,
    RegisterARM::D5,
    RegisterARM::D6,
    RegisterARM::D7,
];

/// A pin: port letter and number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin(pub char, pub u8);

impl Pin {
    const fn port(self) -> u8 {
        self.0 as u8 - b'A'
    }
}

/// The board with the firmware in its flash.
pub struct Board {
    uc: Unicorn<'static, Machine>,
    log: Log,
    elf_segments: Vec<(u32, Vec<u8>)>,
    /// The ELF's unmangled functions.
    symbols: Vec<(String, u64)>,
    /// Levels that are wired to pins; they outlive a reset.
    wired: Vec<(Pin, bool)>,
    inputs: Vec<(u8, f64)>,
    asleep: bool,
    /// Exceptions in service: what the frame on the stack does not hold.
    floats: Vec<[u64; 9]>,
    /// Instructions of earlier starts.
    instructions: u64,
    lines: Vec<String>,
    sent: Vec<u8>,
}

impl Board {
    /// Puts the firmware into the flash of a board without settings, and switches it on.
    ///
    /// # Errors
    /// When the file is not the firmware's ELF.
    pub fn new(elf: &[u8]) -> Result<Self> {
        Self::with_settings(elf, None)
    }

    /// With the contents of the settings' flash that another board left.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_settings(elf: &[u8], settings: Option<Vec<u8>>) -> Result<Self> {
        let segments = load_segments(elf)?;
        let file = ElfFile32::<object::Endianness>::parse(elf)?;
        let symbols = file.symbols().filter_map(|symbol| Some((symbol.name().ok()?.to_owned(), symbol.address())));
        let symbols = symbols.filter(|(name, _)| name == "HardFault").collect();
        let mut flash = Flash::new();
        if let Some(settings) = settings {
            ensure!(settings.len() == 2 * SECTOR, "the settings take two sectors");
            flash.settings = settings;
        }
        let uc = core(&segments, Machine::new(ResetCause::PowerOn, flash)).map_err(engine)?;
        let mut board = Self {
            uc,
            log: Log::new(elf)?,
            elf_segments: segments,
            symbols,
            wired: Vec::new(),
            inputs: Vec::new(),
            asleep: false,
            floats: Vec::new(),
            instructions: 0,
            lines: Vec::new(),
            sent: Vec::new(),
        };
        board.start().map_err(engine)?;
        Ok(board)
    }

    /// Stack pointer and first address from the vector table.
    fn start(&mut self) -> Result<(), uc_error> {
        let mut vectors = [0; 8];
        self.uc.mem_read(u64::from(FLASH), &mut vectors)?;
        let word = |at: usize| u64::from(u32::from_le_bytes([0, 1, 2, 3].map(|byte| vectors[at + byte])));
        self.uc.reg_write(RegisterARM::SP, word(0))?;
        self.uc.reg_write(RegisterARM::PC, word(4))?;
        self.uc.reg_write(RegisterARM::LR, 0xFFFF_FFFF)?;
        self.asleep = false;
        self.floats.clear();
        Ok(())
    }

    /// Restarts the board; the flash keeps what it holds, and so does what is wired to the pins.
    ///
    /// # Errors
    /// When the emulator cannot be set up again.
    pub fn reset(&mut self, cause: ResetCause) -> Result<()> {
        self.collect()?;
        let old = self.uc.get_data_mut();
        self.instructions += old.core.instructions;
        let mut flash = core::mem::replace(&mut old.flash, Flash::new());
        flash.reset();
        self.uc = core(&self.elf_segments, Machine::new(cause, flash)).map_err(engine)?;
        for (pin, high) in self.wired.clone() {
            self.uc.get_data_mut().wire(pin.port(), pin.1, high);
        }
        for &(channel, code) in &self.inputs {
            self.uc.get_data_mut().adc.set_input(channel, code);
        }
        self.start().map_err(engine)
    }

    /// Virtual time since the last start, in ticks of [`crate::time::TICKS_PER_SECOND`].
    #[must_use]
    pub fn time(&self) -> u64 {
        self.uc.get_data().time
    }

    /// Instructions that the core has done, over all starts.
    #[must_use]
    pub fn instructions(&self) -> u64 {
        self.instructions + self.uc.get_data().core.instructions
    }

    /// Runs for whole milliseconds.
    ///
    /// # Errors
    /// As [`Self::run_until`]; a reset and a power cut are errors here too.
    pub fn run_ms(&mut self, milliseconds: u64) -> Result<()> {
        let until = self.time() + milliseconds * MILLISECOND;
        match self.run_until(until)? {
            None => Ok(()),
            Some(halt) => bail!("the board stopped: {halt:?}; log: {:?}", self.log_lines()),
        }
    }

    /// Runs until a time; returns early, with the reason, when the board is reset or loses power.
    ///
    /// # Errors
    /// An access that is not modelled, naming address and PC; an instruction that a chip would fault on.
    pub fn run_until(&mut self, time: u64) -> Result<Option<Halt>> {
        self.uc.get_data_mut().core.deadline = time;
        while self.uc.get_data().time < time {
            if let Some(halt) = self.step().map_err(engine)? {
                let halt = match halt {
                    Halt::Error(message) => bail!("{message}; log: {:?}", self.log_lines()),
                    other => other,
                };
                return Ok(Some(halt));
            }
        }
        Ok(None)
    }

    /// One quantum: sleep, or run to the next event.
    fn step(&mut self) -> Result<Option<Halt>, uc_error> {
        machine::settle(&mut self.uc);
        if let Some(halt) = self.uc.get_data_mut().halt.take() {
            return Ok(Some(halt));
        }
        self.take_exception()?;
        if self.asleep {
            let machine = self.uc.get_data_mut();
            if core::mem::take(&mut machine.core.event) {
                self.asleep = false;
            } else {
                machine.time = machine.next_event.min(machine.core.deadline).max(machine.time);
                return Ok(None);
            }
        }
        self.uc.get_data_mut().core.stopped = false;
        let pc = self.uc.reg_read(RegisterARM::PC)?;
        let outcome = self.uc.emu_start(pc | 1, 0xFFFF_FFFE, 0, 0);
        let machine = self.uc.get_data_mut();
        if let Some(halt) = machine.halt.take() {
            return Ok(Some(halt));
        }
        if core::mem::take(&mut machine.core.returned) {
            self.leave_exception()?;
            return Ok(None);
        }
        if machine.core.stopped {
            return Ok(None);
        }
        // Stopped by itself: asleep, or something that a chip would fault on.
        let pc = self.uc.reg_read(RegisterARM::PC)? as u32;
        let mut before = [0; 2];
        self.uc.mem_read(u64::from(pc.wrapping_sub(2)), &mut before)?;
        match (u16::from_le_bytes(before), outcome) {
            (0xBF20 | 0xBF30, _) => {
                self.asleep = true;
                Ok(None)
            }
            (_, Ok(())) => Ok(Some(Halt::Error(format!("the core stopped at {pc:#010x}")))),
            (_, Err(error)) => Ok(Some(Halt::Error(format!("{error:?} at {pc:#010x}")))),
        }
    }

    /// Takes the interrupt that is due, unless masked.
    fn take_exception(&mut self) -> Result<(), uc_error> {
        let Some(irq) = self.uc.get_data().nvic.deliverable() else { return Ok(()) };
        if self.uc.reg_read(RegisterARM::PRIMASK)? & 1 != 0 {
            // Looked at again a few blocks on: critical sections are short.
            self.uc.get_data_mut().core.grace = 3;
            // It wakes a sleeping core all the same.
            self.uc.get_data_mut().core.event = true;
            return Ok(());
        }
        let nested = !self.floats.is_empty();
        let number = self.uc.get_data_mut().nvic.enter(irq);
        let sp = self.uc.reg_read(RegisterARM::SP)? as u32;
        let xpsr = self.uc.reg_read(RegisterARM::XPSR)? as u32;
        // The frame is aligned to eight bytes; bit 9 of the saved xPSR says that it took four for that.
        let padding = sp & 4;
        let frame = sp - padding - FRAME;
        for (index, register) in FRAME_REGISTERS.into_iter().enumerate() {
            let value = self.uc.reg_read(register)? as u32;
            self.uc.mem_write(u64::from(frame) + 4 * index as u64, &value.to_le_bytes())?;
        }
        let saved = xpsr & !(1 << 9) | padding << 7;
        self.uc.mem_write(u64::from(frame) + 28, &saved.to_le_bytes())?;
        // The floating-point part of the frame is kept beside the stack, whose room is taken all the same.
        let mut floats = [0; 9];
        for (value, register) in floats.iter_mut().zip(FLOAT_REGISTERS) {
            *value = self.uc.reg_read(register)?;
        }
        floats[8] = self.uc.reg_read(RegisterARM::FPSCR)?;
        self.floats.push(floats);

        let mut vector = [0; 4];
        self.uc.mem_read(u64::from(FLASH) + 4 * u64::from(number), &mut vector)?;
        self.uc.reg_write(RegisterARM::XPSR, u64::from(xpsr & 0xF800_0000 | 1 << 24 | u32::from(number)))?;
        self.uc.reg_write(RegisterARM::SP, u64::from(frame))?;
        let exc_return = if nested { EXC_RETURN_HANDLER } else { EXC_RETURN_THREAD };
        self.uc.reg_write(RegisterARM::LR, u64::from(exc_return))?;
        self.uc.reg_write(RegisterARM::PC, u64::from(u32::from_le_bytes(vector)))?;
        self.asleep = false;
        let machine = self.uc.get_data_mut();
        machine.core.event = true;
        // Entering takes twelve cycles (ARM's Cortex-M4 manual).
        machine.time += 12 * INSTRUCTION;
        Ok(())
    }

    fn leave_exception(&mut self) -> Result<(), uc_error> {
        let machine = self.uc.get_data_mut();
        machine.nvic.leave();
        machine.raise();
        machine.core.event = true;
        machine.time += 10 * INSTRUCTION;
        let frame = self.uc.reg_read(RegisterARM::SP)? as u32;
        let word = |uc: &Unicorn<'_, Machine>, index: u32| -> Result<u32, uc_error> {
            let mut bytes = [0; 4];
            uc.mem_read(u64::from(frame + 4 * index), &mut bytes)?;
            Ok(u32::from_le_bytes(bytes))
        };
        let saved = word(&self.uc, 7)?;
        self.uc.reg_write(RegisterARM::XPSR, u64::from(saved & !(1 << 9)))?;
        self.uc.reg_write(RegisterARM::SP, u64::from(frame + FRAME + (saved >> 7 & 4)))?;
        for (index, register) in FRAME_REGISTERS.into_iter().enumerate() {
            let value = word(&self.uc, index as u32)?;
            let value = if register as i32 == RegisterARM::PC as i32 { value | 1 } else { value };
            self.uc.reg_write(register, u64::from(value))?;
        }
        if let Some(floats) = self.floats.pop() {
            for (value, register) in floats.into_iter().zip(FLOAT_REGISTERS) {
                self.uc.reg_write(register, value)?;
            }
            self.uc.reg_write(RegisterARM::FPSCR, floats[8])?;
        }
        Ok(())
    }

    /// Wires a level to a pin.
    pub fn wire(&mut self, pin: Pin, high: bool) {
        self.wired.retain(|&(other, _)| other != pin);
        self.wired.push((pin, high));
        machine::settle(&mut self.uc);
        self.uc.get_data_mut().wire(pin.port(), pin.1, high);
    }

    /// What the pin drives; `None` while it is no output, as from a reset on.
    #[must_use]
    pub fn driven(&self, pin: Pin) -> Option<bool> {
        self.uc.get_data().ports[usize::from(pin.port())].driven(pin.1)
    }

    /// Sets the mean code that a converter channel's input carries.
    pub fn set_analogue(&mut self, channel: u8, code: f64) {
        self.inputs.retain(|&(other, _)| other != channel);
        self.inputs.push((channel, code));
        machine::settle(&mut self.uc);
        self.uc.get_data_mut().adc.set_input(channel, code);
    }

    /// Sends bytes to the board's UART, at its baud rate, from now on.
    pub fn send(&mut self, bytes: &[u8]) {
        machine::settle(&mut self.uc);
        let machine = self.uc.get_data_mut();
        machine.usart.receive(machine.time, bytes);
        machine.reschedule();
    }

    /// Takes what the board has sent.
    pub fn take_sent(&mut self) -> Vec<u8> {
        let mut sent = core::mem::take(&mut self.sent);
        sent.append(&mut self.uc.get_data_mut().usart.sent);
        sent
    }

    /// Keeps what a reset would lose.
    fn collect(&mut self) -> Result<()> {
        self.sent = self.take_sent();
        let uc = &mut self.uc;
        let read = |address: u64, bytes: &mut [u8]| uc.mem_read(address, bytes).map_err(engine);
        // Written later: reading borrows the core.
        let mut written = Vec::new();
        let lines = self.log.drain(read, |address, bytes| {
            written.push((address, bytes.to_vec()));
            Ok(())
        })?;
        for (address, bytes) in written {
            uc.mem_write(address, &bytes).map_err(engine)?;
        }
        self.lines.extend(lines);
        Ok(())
    }

    /// Takes the log's lines.
    pub fn log_lines(&mut self) -> Vec<String> {
        if let Err(error) = self.collect() {
            self.lines.push(format!("(no log: {error})"));
        }
        core::mem::take(&mut self.lines)
    }

    /// Scans that [`Self::take_converted`] would return.
    #[must_use]
    pub fn converted(&self) -> usize {
        self.uc.get_data().converted.len()
    }

    /// The codes that the converter has delivered since the last call, scan by scan: pressure, bend.
    pub fn take_converted(&mut self) -> Vec<[u16; 2]> {
        core::mem::take(&mut self.uc.get_data_mut().converted)
    }

    /// Contents of the settings' flash.
    #[must_use]
    pub fn settings(&self) -> &[u8] {
        &self.uc.get_data().flash.settings
    }

    /// Flash operations since the last start.
    #[must_use]
    pub fn flash_operations(&self) -> u32 {
        self.uc.get_data().flash.operations
    }

    /// Lets the power go in the middle of the flash operation with this number, counted from the last start.
    pub fn cut_power_at(&mut self, operation: u32) {
        self.uc.get_data_mut().flash.cut_at = Some(operation);
    }

    /// The core loops for ever from here on, where it is: in thread mode, or in the interrupt that it serves.
    ///
    /// # Errors
    /// When the emulator does not let it.
    pub fn hang(&mut self) -> Result<()> {
        self.asleep = false;
        self.uc.reg_write(RegisterARM::PC, u64::from(TRAP | 1)).map_err(engine)
    }

    /// The tasks stand still from here on, while interrupts are served. Returns where they go on, for [`Self::release`].
    ///
    /// # Errors
    /// As [`Self::run_until`]; a reset and a power cut too.
    pub fn suspend(&mut self) -> Result<u64> {
        self.leave_interrupts()?;
        let pc = self.uc.reg_read(RegisterARM::PC).map_err(engine)?;
        self.hang()?;
        Ok(pc)
    }

    /// The tasks go on after [`Self::suspend`].
    ///
    /// # Errors
    /// As [`Self::suspend`].
    pub fn release(&mut self, pc: u64) -> Result<()> {
        self.leave_interrupts()?;
        self.uc.reg_write(RegisterARM::PC, pc | 1).map_err(engine)
    }

    fn leave_interrupts(&mut self) -> Result<()> {
        while !self.floats.is_empty() {
            if let Some(halt) = self.run_until(self.time() + 1)? {
                bail!("the board stopped: {halt:?}");
            }
        }
        Ok(())
    }

    /// The converter's trigger is gone: no conversion any more.
    pub fn stop_conversions(&mut self) {
        machine::settle(&mut self.uc);
        let machine = self.uc.get_data_mut();
        machine.adc.stopped = true;
        machine.reschedule();
    }

    /// The core goes on at a function of the ELF, as it does when it faults.
    ///
    /// # Errors
    /// When the ELF has no such symbol, or the emulator does not let it.
    pub fn jump(&mut self, symbol: &str) -> Result<()> {
        let Some(&(_, address)) = self.symbols.iter().find(|(name, _)| name == symbol) else {
            bail!("the ELF has no symbol {symbol}");
        };
        self.asleep = false;
        self.uc.reg_write(RegisterARM::PC, address | 1).map_err(engine)
    }

    /// The deepest that the stack has been since the last start, bytes, exception frames included.
    #[must_use]
    pub fn stack_bytes(&self) -> u32 {
        let mut ram = vec![0; RAM_BYTES as usize];
        if self.uc.mem_read(u64::from(RAM), &mut ram).is_err() {
            return RAM_BYTES;
        }
        let top = self.stack_top() - RAM;
        // From the top down to the highest stretch that still has its paint.
        let mut depth = 0;
        let mut quiet = 0;
        for (index, &byte) in ram[..top as usize].iter().rev().enumerate() {
            if byte == PAINT {
                quiet += 1;
                if quiet == 512 {
                    break;
                }
            } else {
                quiet = 0;
                depth = index as u32 + 1;
            }
        }
        depth
    }

    fn stack_top(&self) -> u32 {
        let mut bytes = [0; 4];
        match self.uc.mem_read(u64::from(FLASH), &mut bytes) {
            Ok(()) => u32::from_le_bytes(bytes).clamp(RAM, RAM + RAM_BYTES),
            Err(_) => RAM + RAM_BYTES,
        }
    }
}

pub(crate) fn engine(error: uc_error) -> anyhow::Error {
    anyhow!("the emulator: {error:?}")
}

/// What an ELF puts into flash: address and bytes of each segment.
pub(crate) fn load_segments(elf: &[u8]) -> Result<Vec<(u32, Vec<u8>)>> {
    let file = ElfFile32::<object::Endianness>::parse(elf)?;
    let endian = file.endian();
    let mut segments = Vec::new();
    for header in file.elf_program_headers() {
        let data = header.data(endian, elf).map_err(|()| anyhow!("a segment lies outside the ELF"))?;
        if header.p_type(endian) == PT_LOAD && !data.is_empty() {
            segments.push((header.p_paddr(endian), data.to_vec()));
        }
    }
    Ok(segments)
}

/// A core with its memory, at reset.
fn core(segments: &[(u32, Vec<u8>)], machine: Machine) -> Result<Unicorn<'static, Machine>, uc_error> {
    let mut uc = Unicorn::new_with_data(Arch::ARM, Mode::THUMB | Mode::MCLASS, machine)?;
    uc.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32)?;
    uc.mem_map(u64::from(FLASH), u64::from(SETTINGS - FLASH), Prot::READ | Prot::EXEC)?;
    uc.mem_map(u64::from(RAM), u64::from(RAM_BYTES), Prot::ALL)?;
    uc.mem_map(u64::from(SYSTEM_ROM), 0x1_0000, Prot::READ)?;
    uc.mem_write(u64::from(RAM), &vec![PAINT; RAM_BYTES as usize])?;
    uc.mem_write(u64::from(TRAP), &[0xFE, 0xE7])?;
    for (index, word) in SERIAL.into_iter().enumerate() {
        uc.mem_write(u64::from(SYSTEM_ROM) + 0x7A10 + 4 * index as u64, &word.to_le_bytes())?;
    }
    uc.mem_write(u64::from(SYSTEM_ROM) + 0x7A22, &512_u16.to_le_bytes())?;
    let mut sleeps_and_events = Vec::new();
    for (address, bytes) in segments {
        uc.mem_write(u64::from(*address), bytes)?;
        for (index, half) in bytes.chunks_exact(2).enumerate() {
            // SEV
            if half == [0x40, 0xBF] {
                sleeps_and_events.push(u64::from(*address) + 2 * index as u64);
            }
        }
    }
    for address in sleeps_and_events {
        uc.add_code_hook(address, address, |uc: &mut Unicorn<'_, Machine>, _, _| uc.get_data_mut().core.event = true)?;
    }
    uc.mmio_map(
        u64::from(SETTINGS),
        2 * SECTOR as u64,
        Some(|uc: &mut Unicorn<'_, Machine>, offset, size| machine::load_settings(uc, offset as usize, size)),
        Some(|uc: &mut Unicorn<'_, Machine>, offset, size, value| {
            machine::program_settings(uc, offset as usize, size, value);
        }),
    )?;
    for (base, size) in [(0x4000_0000_u32, 0x8_0000_u64), (0xE000_0000, 0x10_0000)] {
        uc.mmio_map(
            u64::from(base),
            size,
            Some(move |uc: &mut Unicorn<'_, Machine>, offset, size| machine::load_at(uc, base + offset as u32, size)),
            Some(move |uc: &mut Unicorn<'_, Machine>, offset, size, value| {
                machine::store_at(uc, base + offset as u32, size, value);
            }),
        )?;
    }
    let mut counts = vec![0_u32; (SETTINGS - FLASH) as usize / 2];
    uc.add_block_hook(1, 0, move |uc: &mut Unicorn<'_, Machine>, address, size| block(uc, address, size, &mut counts))?;
    uc.add_intr_hook(|uc: &mut Unicorn<'_, Machine>, number| {
        // Eight is a return from an exception; anything else is a fault or a breakpoint.
        if number == 8 {
            uc.get_data_mut().core.returned = true;
        } else {
            let pc = uc.reg_read(RegisterARM::PC).unwrap_or(0);
            let message = format!("exception {number} in the core at {pc:#010x}");
            uc.get_data_mut().halt.get_or_insert(Halt::Error(message));
        }
        let _ = uc.emu_stop();
    })?;
    uc.add_mem_hook(HookType::MEM_INVALID, 1, 0, |uc: &mut Unicorn<'_, Machine>, kind, address, size, _| {
        let pc = uc.reg_read(RegisterARM::PC).unwrap_or(0);
        let message = format!("{kind:?} of {size} bytes at {address:#010x} (PC {pc:#010x})");
        uc.get_data_mut().halt.get_or_insert(Halt::Error(message));
        false
    })?;
    Ok(uc)
}

/// At the start of each block: stops when something is due, and counts otherwise.
fn block(uc: &mut Unicorn<'_, Machine>, address: u64, size: u32, counts: &mut [u32]) {
    let machine = uc.get_data_mut();
    let Core { grace, deadline, .. } = machine.core;
    let due = machine.time >= machine.next_event.min(deadline);
    let interrupted = if grace > 0 {
        machine.core.grace = grace - 1;
        false
    } else {
        machine.nvic.deliverable().is_some()
    };
    if due || interrupted || machine.halt.is_some() {
        machine.core.stopped = true;
        let _ = uc.emu_stop();
        return;
    }
    let index = (address as u32).wrapping_sub(FLASH) as usize / 2;
    let known = counts.get(index).copied().unwrap_or(0);
    let count = if known >> 16 == size {
        known & 0xFFFF
    } else {
        let count = instructions_in(uc, address, size);
        if let Some(entry) = counts.get_mut(index) {
            *entry = size << 16 | count;
        }
        count
    };
    let machine = uc.get_data_mut();
    machine.core.instructions += u64::from(count);
    machine.time += u64::from(count) * INSTRUCTION;
}

/// Thumb instructions in a block: halfwords that do not start a 32-bit instruction count one.
pub(crate) fn instructions_in<D>(uc: &Unicorn<'_, D>, address: u64, size: u32) -> u32 {
    let mut bytes = vec![0; size as usize];
    if uc.mem_read(address & !1, &mut bytes).is_err() {
        return size / 2;
    }
    let (mut at, mut count) = (0, 0);
    while let Some(&high) = bytes.get(at + 1) {
        at += if high >> 3 >= 0b11101 { 4 } else { 2 };
        count += 1;
    }
    count
}
