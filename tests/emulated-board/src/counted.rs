//! Single functions on the emulated Cortex-M4: called with arguments of one's own, their instructions counted.
//!
//! No board around it: flash, RAM and nothing else, so that whatever a function reaches for beyond them is an error.

use crate::board::{FLASH, RAM, RAM_BYTES, engine, instructions_in, load_segments};
use anyhow::{Context, Result, anyhow, bail, ensure};
use object::read::elf::ElfFile32;
use object::{Object, ObjectSymbol, SymbolKind};
use std::collections::HashMap;
use unicorn_engine::{Arch, ArmCpuModel, HookType, Mode, Prot, RegisterARM, Unicorn, uc_error};

const FLASH_BYTES: u32 = 256 * 1024;
/// Where a called function returns to, in flash that no program reaches.
const RETURN: u32 = FLASH + FLASH_BYTES - 16;
/// Where the caller's own data begins; the stack comes down from the RAM's end.
const DATA: u32 = RAM + 0x1000;
/// Most that [`Counted::room`] gives: the rest is stack.
const DATA_END: u32 = RAM + RAM_BYTES / 4 * 3;
/// A call that takes more than this has lost its way, unless [`Counted::set_limit`] says otherwise.
const MOST_INSTRUCTIONS: u64 = 1_000_000_000;

/// `counted` as `cargo xtask pareto` leaves it.
///
/// # Errors
/// When it has not been built.
pub fn counted_elf() -> Result<Vec<u8>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/counted/counted.elf");
    std::fs::read(path)
        .map_err(|error| anyhow!("no ELF in target/counted ({error}): build it with `cargo xtask pareto`"))
}

/// What the hooks see and count.
#[derive(Default)]
struct Seen {
    instructions: u64,
    limit: u64,
    /// Of each block, by its halfword's number in flash: bytes << 16 | instructions.
    blocks: Vec<u32>,
    /// First trouble of the call.
    trouble: Option<String>,
}

/// A function's address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Function(u32);

/// What a function is called with (AAPCS, hard-float variant).
#[derive(Clone, Copy, Debug, Default)]
pub struct Arguments {
    /// r0 to r3.
    pub core: [u32; 4],
    /// d0, of which s0 is the lower half.
    pub float: u64,
}

/// What a function leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// r0, r1.
    pub core: [u32; 2],
    /// d0, of which s0 is the lower half.
    pub float: u64,
    /// From the function's first instruction to its return, both included; those that an IT block skips count too.
    pub instructions: u64,
}

/// The core with an ELF in its flash.
pub struct Counted {
    uc: Unicorn<'static, Seen>,
    functions: HashMap<String, u32>,
    free: u32,
}

impl Counted {
    /// Loads an ELF.
    ///
    /// # Errors
    /// When it is no 32-bit ELF, does not fit the chip, or the emulator cannot be set up.
    pub fn new(elf: &[u8]) -> Result<Self> {
        let file = ElfFile32::<object::Endianness>::parse(elf).context("not a 32-bit ELF")?;
        let text = |symbol: &object::read::elf::ElfSymbol32<'_, '_>| symbol.kind() == SymbolKind::Text;
        let functions = file.symbols().filter(text).filter_map(|symbol| {
            let address = u32::try_from(symbol.address()).ok()?;
            Some((symbol.name().ok()?.to_owned(), address & !1))
        });
        let functions = functions.collect();
        let uc = core(&load_segments(elf)?).map_err(engine)?;
        Ok(Self { uc, functions, free: DATA })
    }

    /// Finds a function by its symbol.
    ///
    /// # Errors
    /// When the ELF has none of this name.
    pub fn function(&self, symbol: &str) -> Result<Function> {
        let address = self.functions.get(symbol);
        address.map(|&address| Function(address)).ok_or_else(|| anyhow!("the ELF has no function {symbol}"))
    }

    /// Room in RAM for the caller's data; it is never given back.
    ///
    /// # Errors
    /// When the RAM is used up.
    pub fn room(&mut self, bytes: u32, alignment: u32) -> Result<u32> {
        let at = self.free.next_multiple_of(alignment.max(1));
        ensure!(at <= DATA_END && bytes <= DATA_END - at, "no room in RAM for {bytes} bytes more");
        self.free = at + bytes;
        Ok(at)
    }

    /// The instructions after which a call is given up; a thousand million at first.
    pub fn set_limit(&mut self, instructions: u64) {
        self.uc.get_data_mut().limit = instructions;
    }

    /// Calls a function.
    ///
    /// # Errors
    /// An access outside flash and RAM, an exception, an instruction that the core does not have, or no return within
    /// the limit; each names the address.
    pub fn call(&mut self, function: Function, arguments: &Arguments) -> Result<Outcome> {
        self.enter(function, arguments).map_err(engine)?;
        let ended = self.uc.emu_start(u64::from(function.0 | 1), u64::from(RETURN), 0, 0);
        let pc = self.uc.reg_read(RegisterARM::PC).map_err(engine)? as u32;
        if let Some(trouble) = self.uc.get_data_mut().trouble.take() {
            bail!("{trouble}");
        }
        if let Err(error) = ended {
            bail!("{error:?} at {pc:#010x}");
        }
        ensure!(pc & !1 == RETURN, "the core stopped at {pc:#010x}");
        self.leave().map_err(engine)
    }

    fn enter(&mut self, function: Function, arguments: &Arguments) -> Result<(), uc_error> {
        debug_assert!(function.0 >= FLASH);
        let core = [RegisterARM::R0, RegisterARM::R1, RegisterARM::R2, RegisterARM::R3];
        for (register, value) in core.into_iter().zip(arguments.core) {
            self.uc.reg_write(register, u64::from(value))?;
        }
        self.uc.reg_write(RegisterARM::D0, arguments.float)?;
        self.uc.reg_write(RegisterARM::SP, u64::from(RAM + RAM_BYTES))?;
        self.uc.reg_write(RegisterARM::LR, u64::from(RETURN | 1))?;
        let seen = self.uc.get_data_mut();
        seen.instructions = 0;
        seen.trouble = None;
        Ok(())
    }

    fn leave(&self) -> Result<Outcome, uc_error> {
        Ok(Outcome {
            core: [self.uc.reg_read(RegisterARM::R0)? as u32, self.uc.reg_read(RegisterARM::R1)? as u32],
            float: self.uc.reg_read(RegisterARM::D0)?,
            instructions: self.uc.get_data().instructions,
        })
    }

    /// The halfword at an address in flash or RAM.
    ///
    /// # Errors
    /// When there is no memory.
    pub fn halfword(&self, address: u32) -> Result<u16> {
        let mut bytes = [0; 2];
        self.uc.mem_read(u64::from(address), &mut bytes).map_err(engine)?;
        Ok(u16::from_le_bytes(bytes))
    }

    /// The call again, slowly: every instruction's address, in order, and every address in flash that was read.
    ///
    /// # Errors
    /// As [`Self::call`].
    pub fn trace(&mut self, function: Function, arguments: &Arguments) -> Result<Trace> {
        let trace = std::rc::Rc::new(std::cell::RefCell::new(Trace::default()));
        // Code that is translated already would not call a new hook.
        self.uc.ctl_flush_tb().map_err(engine)?;
        let seen = trace.clone();
        let hook = move |_: &mut Unicorn<'_, Seen>, address: u64, _: u32| {
            if address as u32 != RETURN {
                seen.borrow_mut().instructions.push(address as u32);
            }
        };
        let code = self.uc.add_code_hook(1, 0, hook).map_err(engine)?;
        let seen = trace.clone();
        let flash = u64::from(FLASH)..u64::from(FLASH + FLASH_BYTES);
        let hook = move |_: &mut Unicorn<'_, Seen>, _, address: u64, _: usize, _: i64| {
            if flash.contains(&address) {
                seen.borrow_mut().reads.push(address as u32);
            }
            true
        };
        let reads = self.uc.add_mem_hook(HookType::MEM_READ, 1, 0, hook).map_err(engine)?;
        let outcome = self.call(function, arguments);
        self.uc.remove_hook(code).map_err(engine)?;
        self.uc.remove_hook(reads).map_err(engine)?;
        self.uc.ctl_flush_tb().map_err(engine)?;
        outcome?;
        Ok(trace.take())
    }
}

/// What one call did, step by step.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Addresses of the instructions, in order. The engine leaves out those that an IT block skips, and now and then
    /// another one.
    pub instructions: Vec<u32>,
    /// Addresses in flash that were read as data.
    pub reads: Vec<u32>,
}

/// A core with flash and RAM, and the hooks that count.
fn core(segments: &[(u32, Vec<u8>)]) -> Result<Unicorn<'static, Seen>, uc_error> {
    let seen = Seen { blocks: vec![0; FLASH_BYTES as usize / 2], limit: MOST_INSTRUCTIONS, ..Seen::default() };
    let mut uc = Unicorn::new_with_data(Arch::ARM, Mode::THUMB | Mode::MCLASS, seen)?;
    uc.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32)?;
    uc.mem_map(u64::from(FLASH), u64::from(FLASH_BYTES), Prot::READ | Prot::EXEC)?;
    uc.mem_map(u64::from(RAM), u64::from(RAM_BYTES), Prot::READ | Prot::WRITE)?;
    for (address, bytes) in segments {
        uc.mem_write(u64::from(*address), bytes)?;
    }
    uc.add_block_hook(1, 0, block)?;
    uc.add_intr_hook(|uc: &mut Unicorn<'_, Seen>, number| {
        let pc = uc.reg_read(RegisterARM::PC).unwrap_or(0);
        uc.get_data_mut().trouble.get_or_insert(format!("exception {number} at {pc:#010x}"));
        let _ = uc.emu_stop();
    })?;
    uc.add_mem_hook(HookType::MEM_INVALID, 1, 0, |uc: &mut Unicorn<'_, Seen>, kind, address, size, _| {
        let pc = uc.reg_read(RegisterARM::PC).unwrap_or(0);
        let trouble = format!("{kind:?} of {size} bytes at {address:#010x} (PC {pc:#010x})");
        uc.get_data_mut().trouble.get_or_insert(trouble);
        false
    })?;
    Ok(uc)
}

/// At the start of each block: counts its instructions, all of which are done.
fn block(uc: &mut Unicorn<'_, Seen>, address: u64, size: u32) {
    if address as u32 == RETURN {
        return;
    }
    let index = (address as u32).wrapping_sub(FLASH) as usize / 2;
    let known = uc.get_data().blocks.get(index).copied().unwrap_or(0);
    let count = if known >> 16 == size {
        known & 0xFFFF
    } else {
        let count = instructions_in(uc, address, size);
        if let Some(entry) = uc.get_data_mut().blocks.get_mut(index) {
            *entry = size << 16 | count;
        }
        count
    };
    let seen = uc.get_data_mut();
    seen.instructions += u64::from(count);
    if seen.instructions > seen.limit {
        let trouble = format!("no return after {} instructions, at {address:#010x}", seen.limit);
        seen.trouble.get_or_insert(trouble);
        let _ = uc.emu_stop();
    }
}
