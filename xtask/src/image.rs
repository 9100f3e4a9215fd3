//! From an ELF to what a programmer writes: a flat image, Intel HEX, and how much of the chip it takes.

use anyhow::{Context, Result, ensure};
use object::elf::PT_LOAD;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, Object, ObjectSection, SectionFlags};

/// What goes to flash.
#[derive(Debug, PartialEq, Eq)]
pub struct Image {
    /// Address of the first byte.
    pub address: u32,
    /// All bytes from there, gaps filled with 0xFF, which is erased flash.
    pub bytes: Vec<u8>,
}

/// How much of the chip the firmware takes.
#[derive(Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Flash: code, constants, and the start values of variables.
    pub flash_bytes: u64,
    /// Static RAM: variables with and without start values; the stack is not in it.
    pub ram_bytes: u64,
    /// Each section that takes flash or RAM, with its bytes.
    pub sections: Vec<(String, u64)>,
}

/// Reads the ELF's loadable segments at their physical addresses.
///
/// # Errors
/// When the file is no 32-bit ELF, or has nothing to load.
pub fn image(elf: &[u8]) -> Result<Image> {
    let file = ElfFile32::<Endianness>::parse(elf).context("not a 32-bit ELF")?;
    let endian = file.endian();
    let mut parts = Vec::new();
    for header in file.elf_program_headers() {
        let data = header.data(endian, elf).map_err(|()| anyhow::anyhow!("a segment lies outside the file"))?;
        if header.p_type(endian) == PT_LOAD && !data.is_empty() {
            parts.push((header.p_paddr(endian), data));
        }
    }
    parts.sort_by_key(|&(address, _)| address);
    let address = parts.first().context("nothing to load")?.0;
    let mut bytes = Vec::new();
    for (start, data) in parts {
        let offset = (start - address) as usize;
        ensure!(offset >= bytes.len(), "two segments overlap at {start:#010x}");
        ensure!(offset < 16 << 20, "the segment at {start:#010x} lies far from the first at {address:#010x}");
        bytes.resize(offset, 0xFF);
        bytes.extend_from_slice(data);
    }
    Ok(Image { address, bytes })
}

/// The image as Intel HEX, 16 bytes a record.
///
/// # Errors
/// When the encoder refuses a record.
pub fn hex(image: &Image) -> Result<String> {
    let mut records = Vec::new();
    let mut upper = None;
    let mut address = image.address;
    let mut rest = image.bytes.as_slice();
    while !rest.is_empty() {
        if upper != Some(address >> 16) {
            upper = Some(address >> 16);
            records.push(ihex::Record::ExtendedLinearAddress((address >> 16) as u16));
        }
        // A record does not cross a 64 KiB border.
        let room = 0x1_0000 - (address & 0xFFFF) as usize;
        let (now, later) = rest.split_at(rest.len().min(16).min(room));
        records.push(ihex::Record::Data { offset: address as u16, value: now.to_vec() });
        (address, rest) = (address.wrapping_add(now.len() as u32), later);
    }
    records.push(ihex::Record::EndOfFile);
    Ok(ihex::create_object_file_representation(&records)?)
}

/// Flash and RAM by section.
///
/// # Errors
/// When the file is no 32-bit ELF.
pub fn sizes(elf: &[u8]) -> Result<Sizes> {
    let file = ElfFile32::<Endianness>::parse(elf).context("not a 32-bit ELF")?;
    let mut sizes = Sizes { flash_bytes: 0, ram_bytes: 0, sections: Vec::new() };
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        if sh_flags & u64::from(object::elf::SHF_ALLOC) == 0 || section.size() == 0 {
            continue;
        }
        let stored = section.file_range().is_some();
        let writable = sh_flags & u64::from(object::elf::SHF_WRITE) != 0 && section.address() >= 0x2000_0000;
        sizes.flash_bytes += if stored { section.size() } else { 0 };
        sizes.ram_bytes += if writable { section.size() } else { 0 };
        sizes.sections.push((section.name()?.to_owned(), section.size()));
    }
    Ok(sizes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_reads_back_as_the_image_across_a_64_kib_border() {
        let bytes: Vec<u8> = (0..0x1_0123_u32).map(|i| (i * 7) as u8).collect();
        let image = Image { address: 0x0800_FFF5, bytes };
        let text = hex(&image).expect("encodes");
        let (mut upper, mut read) = (0_u32, std::collections::BTreeMap::new());
        for record in ihex::Reader::new(&text) {
            match record.expect("valid, checksum included") {
                ihex::Record::ExtendedLinearAddress(value) => upper = u32::from(value) << 16,
                ihex::Record::Data { offset, value } => {
                    for (index, byte) in value.into_iter().enumerate() {
                        assert!(read.insert(upper + u32::from(offset) + index as u32, byte).is_none());
                    }
                }
                _ => {}
            }
        }
        assert_eq!(read.keys().next(), Some(&image.address));
        assert_eq!(read.into_values().collect::<Vec<_>>(), image.bytes);
    }

    #[test]
    fn anything_else_than_an_elf_is_refused() {
        assert!(image(b"not an ELF").is_err());
        assert!(sizes(&[]).is_err());
    }

    #[test]
    fn sizes_count_what_is_stored_and_what_is_written() {
        use object::write::{Object as Writer, StandardSection};
        let mut writer = Writer::new(object::BinaryFormat::Elf, object::Architecture::Arm, Endianness::Little);
        let text = writer.section_id(StandardSection::Text);
        writer.append_section_data(text, &[0; 40], 4);
        let bss = writer.section_id(StandardSection::UninitializedData);
        writer.append_section_bss(bss, 24, 4);
        let elf = writer.write().expect("writes");
        let sizes = sizes(&elf).expect("reads");
        // A relocatable file has no addresses yet, so its variables do not count as the chip's RAM.
        assert_eq!((sizes.flash_bytes, sizes.ram_bytes), (40, 0));
        assert_eq!(sizes.sections, [(".text".to_owned(), 40), (".bss".to_owned(), 24)]);
    }
}
