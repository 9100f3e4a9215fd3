//! Log frames out of the RTT buffer in the emulated RAM.

use anyhow::{Context, Result, anyhow};
use defmt_decoder::{DecodeError, StreamDecoder, Table};
use object::{Object, ObjectSymbol};

/// Where the control block lies, and how to read what it carries.
pub struct Log {
    address: u64,
    decoder: Box<dyn StreamDecoder + 'static>,
}

impl Log {
    /// Reads the ELF's table of messages.
    pub fn new(elf: &[u8]) -> Result<Self> {
        let table = Table::parse(elf)?.context("the ELF carries no defmt messages")?;
        let file = object::File::parse(elf)?;
        let symbol = file.symbols().find(|symbol| symbol.name() == Ok("_SEGGER_RTT"));
        let address = symbol.ok_or_else(|| anyhow!("the ELF has no RTT control block"))?.address();
        // One table for each board that a test makes: a few kilobytes, and it has to outlive its decoder.
        let table: &'static Table = Box::leak(Box::new(table));
        Ok(Self { address, decoder: table.new_stream_decoder() })
    }

    /// Takes what the firmware has written since the last call. `read` and `write` reach the emulated RAM.
    pub fn drain(
        &mut self,
        read: impl Fn(u64, &mut [u8]) -> Result<()>,
        mut write: impl FnMut(u64, &[u8]) -> Result<()>,
    ) -> Result<Vec<String>> {
        // SEGGER's control block: 16 bytes of name, two counts, then the first channel up: name, buffer, size, written,
        // read.
        let word = |offset: u64| -> Result<u32> {
            let mut bytes = [0; 4];
            read(self.address + offset, &mut bytes)?;
            Ok(u32::from_le_bytes(bytes))
        };
        let (buffer, size) = (word(28)?, word(32)?);
        let (written, taken) = (word(36)?, word(40)?);
        if size == 0 || written == taken || written >= size {
            return Ok(Vec::new());
        }
        let mut bytes = vec![0; size as usize];
        read(u64::from(buffer), &mut bytes)?;
        bytes.rotate_left(taken as usize);
        bytes.truncate(((written + size - taken) % size) as usize);
        write(self.address + 40, &written.to_le_bytes())?;
        self.decoder.received(&bytes);
        let mut lines = Vec::new();
        loop {
            match self.decoder.decode() {
                Ok(frame) => lines.push(frame.display_message().to_string()),
                Err(DecodeError::UnexpectedEof) => return Ok(lines),
                Err(DecodeError::Malformed) => lines.push("(a malformed log frame)".to_owned()),
            }
        }
    }
}
