//! Frames read by their definition in docs/protocol.md, with none of the core's code but its messages.

use model_core::protocol::{MAX_FRAME, Request, VERSION};

/// What a stream of bytes holds: the requests of its whole frames in order, and how many frames are dropped.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Read {
    /// Understood.
    pub requests: Vec<Request>,
    /// Not understood.
    pub dropped: u16,
}

/// Reads all frames that end in `stream`.
#[must_use]
pub fn read(stream: &[u8]) -> Read {
    let mut read = Read::default();
    let Some(end) = stream.iter().rposition(|&byte| byte == 0) else { return read };
    for frame in stream[..end].split(|&byte| byte == 0).filter(|frame| !frame.is_empty()) {
        match request(frame) {
            Some(request) => read.requests.push(request),
            None => read.dropped = read.dropped.saturating_add(1),
        }
    }
    read
}

fn request(frame: &[u8]) -> Option<Request> {
    if frame.len() > MAX_FRAME {
        return None;
    }
    let plain = without_cobs(frame)?;
    let (content, crc) = plain.split_at_checked(plain.len().checked_sub(4)?)?;
    if crc32(content).to_le_bytes() != crc || content.first() != Some(&VERSION) {
        return None;
    }
    match postcard::take_from_bytes(&content[1..]) {
        Ok((request, [])) => Some(request),
        _ => None,
    }
}

/// Each block begins with its length; a zero stood between blocks, except after a full one.
fn without_cobs(frame: &[u8]) -> Option<Vec<u8>> {
    let (mut plain, mut rest) = (Vec::new(), frame);
    while let Some((&distance, _)) = rest.split_first() {
        let (block, after) = rest.split_at_checked(usize::from(distance))?;
        plain.extend(&block[1..]);
        if distance != u8::MAX && !after.is_empty() {
            plain.push(0);
        }
        rest = after;
    }
    Some(plain)
}

/// CRC-32 of IEEE 802.3, bit by bit.
#[must_use]
pub fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
    })
}

/// A frame of this version around any message bytes, with the right CRC; its zero included.
#[must_use]
pub fn framed(message: &[u8]) -> Vec<u8> {
    let mut plain = vec![VERSION];
    plain.extend(message);
    plain.extend(crc32(&plain).to_le_bytes());
    let mut frame = vec![0; cobs::max_encoding_length(plain.len())];
    let length = cobs::try_encode(&plain, &mut frame).unwrap_or(0);
    frame.truncate(length);
    frame.push(0);
    frame
}
