//! How much flash a function takes with everything that it reaches: a graph over the ELF's symbols, whose edges are
//! the relocations that the linker has left in it (`--emit-relocs`).

use anyhow::{Context, Result, anyhow, bail, ensure};
use object::elf::{
    R_ARM_ABS32, R_ARM_NONE, R_ARM_PREL31, R_ARM_REL32, R_ARM_THM_JUMP19, R_ARM_THM_JUMP24, R_ARM_THM_MOVT_ABS,
    R_ARM_THM_MOVW_ABS_NC, R_ARM_THM_PC22,
};
use object::read::elf::{ElfFile32, ElfSymbol32};
use object::{Object, ObjectSection, ObjectSymbol, RelocationFlags, RelocationTarget, SectionKind, SymbolKind};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Flash in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bytes {
    /// Instructions with the constants that lie between them.
    pub code: u64,
    /// Read-only data.
    pub tables: u64,
}

/// A function or a piece of data.
#[derive(Debug)]
struct Piece {
    name: String,
    bytes: u32,
    code: bool,
    /// Addresses of the pieces that this one refers to.
    reaches: BTreeSet<u32>,
}

/// The graph.
#[derive(Debug)]
pub struct Footprint {
    pieces: BTreeMap<u32, Piece>,
    by_name: HashMap<String, u32>,
}

type File<'a> = ElfFile32<'a, object::Endianness>;

impl Footprint {
    /// Reads symbols and relocations.
    ///
    /// # Errors
    /// When the ELF has been linked without `--emit-relocs`, or has a relocation that is not known here or leads to
    /// nothing with a size.
    pub fn new(elf: &[u8]) -> Result<Self> {
        let file = File::parse(elf).context("not a 32-bit ELF")?;
        let mut footprint = Self { pieces: BTreeMap::new(), by_name: HashMap::new() };
        for symbol in file.symbols() {
            footprint.add(&file, &symbol)?;
        }
        let mut relocations = 0;
        for section in file.sections().filter(|section| in_flash(section.kind())) {
            relocations += footprint.connect(&file, &section)?;
        }
        ensure!(relocations > 0, "the ELF has no relocations: it must be linked with --emit-relocs");
        Ok(footprint)
    }

    fn add(&mut self, file: &File<'_>, symbol: &ElfSymbol32<'_, '_>) -> Result<()> {
        let kind = symbol.section_index().and_then(|index| file.section_by_index(index).ok()).map(|it| it.kind());
        let data = matches!(symbol.kind(), SymbolKind::Data | SymbolKind::Unknown);
        if !(data || symbol.kind() == SymbolKind::Text) || !kind.is_some_and(in_flash) {
            return Ok(());
        }
        let address = u32::try_from(symbol.address())?;
        // Bit 0 of a function's address says that it is Thumb code.
        let address = if symbol.kind() == SymbolKind::Text { address & !1 } else { address };
        let name = symbol.name()?.to_owned();
        if symbol.kind() == SymbolKind::Text {
            self.by_name.insert(name.clone(), address);
        }
        let bytes = u32::try_from(symbol.size())?;
        // A second name of the same piece may come without a size.
        let code = kind == Some(SectionKind::Text);
        let piece = Piece { name, bytes, code, reaches: BTreeSet::new() };
        match self.pieces.get(&address) {
            Some(known) if known.bytes >= bytes => {}
            _ if bytes == 0 => {}
            _ => drop(self.pieces.insert(address, piece)),
        }
        Ok(())
    }

    /// Adds the edges that a section's relocations are, and returns their number.
    fn connect(&mut self, file: &File<'_>, section: &object::read::elf::ElfSection32<'_, '_>) -> Result<usize> {
        let data = section.data()?;
        let word = |address: u32| -> Result<[u8; 4]> {
            let at = u64::from(address).checked_sub(section.address()).context("a relocation outside its section")?;
            let bytes = data.get(at as usize..).and_then(|rest| rest.first_chunk());
            bytes.copied().context("a relocation outside its section")
        };
        // The lower half of an address, by the register that waits for the upper one.
        let mut halves = [0; 16];
        let mut count = 0;
        for (at, relocation) in section.relocations() {
            count += 1;
            let at = u32::try_from(at)?;
            let RelocationFlags::Elf { r_type } = relocation.flags() else { bail!("no ELF relocation") };
            let RelocationTarget::Symbol(index) = relocation.target() else { continue };
            let symbol = file.symbol_by_index(index)?;
            let whole = match r_type {
                R_ARM_NONE => continue,
                R_ARM_THM_MOVW_ABS_NC => {
                    let (register, half) = immediate(word(at)?);
                    halves[register] = half;
                    continue;
                }
                R_ARM_THM_MOVT_ABS => {
                    let (register, half) = immediate(word(at)?);
                    Some(half << 16 | halves[register])
                }
                R_ARM_ABS32 => Some(u32::from_le_bytes(word(at)?)),
                R_ARM_REL32 | R_ARM_PREL31 | R_ARM_THM_PC22 | R_ARM_THM_JUMP24 | R_ARM_THM_JUMP19 => None,
                other => bail!("relocation type {other} at {at:#010x} is not known here"),
            };
            // The symbol itself is the surest; a section's stands for any piece of it, and the address decides.
            let target = match (symbol.kind(), whole) {
                (SymbolKind::Section, Some(address)) => address,
                (SymbolKind::Section, None) => bail!("the jump at {at:#010x} names no function"),
                (_, _) => u32::try_from(symbol.address())?,
            };
            let in_section = symbol.section_index().and_then(|index| file.section_by_index(index).ok());
            if !in_section.is_some_and(|section| in_flash(section.kind())) {
                // RAM, or an address that the linker script defines.
                continue;
            }
            // Code that belongs to no function, such as the vector table, is nobody's cost.
            let Some(from) = self.containing(at) else { continue };
            let Some(to) = self.containing(target) else {
                let user = self.pieces.get(&from).map_or("", |piece| &piece.name);
                // Labels of the linker script have no size; only the start-up code, which is in assembly, uses them.
                if symbol.size() == 0 && symbol.kind() == SymbolKind::Unknown || user == "Reset" {
                    continue;
                }
                bail!("{user} refers to {target:#010x}, where no symbol has a size");
            };
            if let Some(piece) = self.pieces.get_mut(&from) {
                piece.reaches.insert(to);
            }
        }
        Ok(count)
    }

    /// The piece that an address lies in.
    fn containing(&self, address: u32) -> Option<u32> {
        let (&start, piece) = self.pieces.range(..=address).next_back()?;
        (address - start < piece.bytes).then_some(start)
    }

    fn reached(&self, symbol: &str) -> Result<BTreeSet<u32>> {
        let start = *self.by_name.get(symbol).ok_or_else(|| anyhow!("the ELF has no function {symbol}"))?;
        let mut reached = BTreeSet::new();
        let mut open = vec![start];
        while let Some(address) = open.pop() {
            if reached.insert(address) {
                open.extend(self.pieces.get(&address).into_iter().flat_map(|piece| &piece.reaches));
            }
        }
        Ok(reached)
    }

    /// The flash of a function and of everything that it reaches, library code that others share among it.
    ///
    /// # Errors
    /// When the ELF has no such function.
    pub fn of(&self, symbol: &str) -> Result<Bytes> {
        let mut sum = Bytes::default();
        for piece in self.reached(symbol)?.iter().filter_map(|address| self.pieces.get(address)) {
            *(if piece.code { &mut sum.code } else { &mut sum.tables }) += u64::from(piece.bytes);
        }
        Ok(sum)
    }

    /// Names and sizes of the same.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn pieces(&self, symbol: &str) -> Result<Vec<(&str, u32)>> {
        let reached = self.reached(symbol)?;
        let pieces = reached.iter().filter_map(|address| self.pieces.get(address));
        Ok(pieces.map(|piece| (piece.name.as_str(), piece.bytes)).collect())
    }

    /// The first of the addresses that lies outside of what a function reaches.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn first_outside(&self, symbol: &str, mut addresses: impl Iterator<Item = u32>) -> Result<Option<u32>> {
        let reached = self.reached(symbol)?;
        Ok(addresses.find(|&address| !self.containing(address).is_some_and(|piece| reached.contains(&piece))))
    }
}

fn in_flash(kind: SectionKind) -> bool {
    matches!(kind, SectionKind::Text | SectionKind::ReadOnlyData | SectionKind::ReadOnlyString)
}

/// Destination register and 16 bits of a MOVW or MOVT in encoding T3 / T1: i:imm4:imm3:imm8.
fn immediate(bytes: [u8; 4]) -> (usize, u32) {
    let first = u32::from(u16::from_le_bytes([bytes[0], bytes[1]]));
    let second = u32::from(u16::from_le_bytes([bytes[2], bytes[3]]));
    let half = (first & 0xF) << 12 | (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xFF;
    ((second >> 8 & 0xF) as usize, half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn immediates_are_put_together() {
        // llvm-mc: `movw r3, #0x1748` is 41 f2 48 73 hex, `movt r12, #0x0800` is c0 f6 00 0c.
        assert_eq!(immediate([0x41, 0xF2, 0x48, 0x73]), (3, 0x1748));
        assert_eq!(immediate([0xC0, 0xF6, 0x00, 0x0C]), (12, 0x0800));
    }
}
