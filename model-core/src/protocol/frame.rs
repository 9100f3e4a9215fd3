//! From messages to frames on the line and back.

use super::VERSION;
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The longest frame, its zero included. The longest message is the telemetry with every number at its widest.
pub const MAX_FRAME: usize = 160;

/// One kilobyte of table.
static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);
const CRC_BYTES: usize = 4;

/// CRC-32 as Ethernet, zip and PNG have it.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// Why a frame was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than any message.
    TooLong,
    /// No COBS.
    Cobs,
    /// Damaged: the CRC does not fit.
    Crc,
    /// Of another version.
    Version(u8),
    /// Whole, but no message of this version.
    Message,
}

/// Writes a message as a frame, its zero included; returns its length. `None` when the buffer is too small:
/// [`MAX_FRAME`] bytes hold every message.
#[must_use]
pub fn encode(message: &impl Serialize, buffer: &mut [u8]) -> Option<usize> {
    let mut plain = [0; MAX_FRAME];
    let (version, rest) = plain.split_first_mut()?;
    *version = VERSION;
    let length = 1 + postcard::to_slice(message, rest).ok()?.len();
    let crc = checksum(plain.get(..length)?);
    plain.get_mut(length..length + CRC_BYTES)?.copy_from_slice(&crc.to_le_bytes());
    let plain = plain.get(..length + CRC_BYTES)?;
    let length = cobs::try_encode(plain, buffer.get_mut(..cobs::max_encoding_length(plain.len()))?).ok()?;
    *buffer.get_mut(length)? = 0;
    Some(length + 1)
}

/// Collects bytes into frames, and counts.
#[derive(Clone, Debug)]
pub struct Decoder {
    buffer: [u8; MAX_FRAME],
    length: usize,
    too_long: bool,
    dropped: u16,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// At a frame's start.
    #[must_use]
    pub const fn new() -> Self {
        Self { buffer: [0; MAX_FRAME], length: 0, too_long: false, dropped: 0 }
    }

    /// Frames dropped so far; stops at 65535.
    #[must_use]
    pub const fn dropped(&self) -> u16 {
        self.dropped
    }

    /// Takes a byte. Returns a message, or why none came of it, when it ends a frame. Empty frames say nothing.
    pub fn push<M: DeserializeOwned>(&mut self, byte: u8) -> Option<Result<M, FrameError>> {
        if byte != 0 {
            match self.buffer.get_mut(self.length) {
                Some(place) => {
                    *place = byte;
                    self.length += 1;
                }
                // Nothing of it is kept until the next zero.
                None => self.too_long = true,
            }
            return None;
        }
        let length = core::mem::take(&mut self.length);
        let outcome = if core::mem::take(&mut self.too_long) {
            Err(FrameError::TooLong)
        } else if length == 0 {
            return None;
        } else {
            self.buffer.get_mut(..length).ok_or(FrameError::TooLong).and_then(decode)
        };
        if outcome.is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
        Some(outcome)
    }
}

/// Decodes a frame without its zero, in place.
fn decode<M: DeserializeOwned>(frame: &mut [u8]) -> Result<M, FrameError> {
    let length = remove_cobs(frame).ok_or(FrameError::Cobs)?;
    let plain = frame.get(..length).ok_or(FrameError::Cobs)?;
    let (content, crc) = plain.split_last_chunk::<CRC_BYTES>().ok_or(FrameError::Crc)?;
    if checksum(content) != u32::from_le_bytes(*crc) {
        return Err(FrameError::Crc);
    }
    match content.split_first() {
        Some((&VERSION, message)) => match postcard::take_from_bytes(message) {
            Ok((message, [])) => Ok(message),
            _ => Err(FrameError::Message),
        },
        Some((&version, _)) => Err(FrameError::Version(version)),
        None => Err(FrameError::Message),
    }
}

/// Takes the COBS off a frame without its zero, in place; returns the length of what is left. The same as
/// `cobs::decode_in_place`, by the crate's state machine, because that function indexes its buffer and so can panic as far
/// as the compiler knows.
fn remove_cobs(frame: &mut [u8]) -> Option<usize> {
    let mut state = cobs::DecoderState::Idle;
    let mut length = 0;
    for at in 0..frame.len() {
        // A byte is written at the earliest where the last one was read: the first one read is a distance.
        if let cobs::DecodeResult::DataContinue(plain) = state.feed(*frame.get(at)?).ok()? {
            *frame.get_mut(length)? = plain;
            length += 1;
        }
    }
    matches!(state.feed(0), Ok(cobs::DecodeResult::DataComplete)).then_some(length)
}

#[cfg(test)]
mod tests {
    use super::super::message::*;
    use super::*;
    use crate::actuation::Segment;
    use proptest::prelude::*;

    fn commands() -> Vec<LinkCommand> {
        let name = SequenceName::try_from("reconfigure").expect("short");
        vec![
            LinkCommand::Run(name),
            LinkCommand::Pause,
            LinkCommand::Resume,
            LinkCommand::Vent,
            LinkCommand::Setpoints([60 << 16, 30 << 16, 60 << 16]),
            LinkCommand::ZeroSensors,
            LinkCommand::Calibrate { segment: Segment::Middle, k: 0, c1: 232_121_178, c2: 5_630_601 },
            LinkCommand::Identify,
            LinkCommand::ClearFault,
            LinkCommand::Beat,
            LinkCommand::Bends([45 << 16, 30 << 16, 15 << 16]),
            LinkCommand::Identification,
            LinkCommand::AdoptIdentified,
        ]
    }

    fn framed(command: &LinkCommand) -> Vec<u8> {
        let mut buffer = [0; MAX_FRAME];
        let request = Request { id: 0x1234, command: command.clone() };
        let length = encode(&request, &mut buffer).expect("fits");
        buffer[..length].to_vec()
    }

    fn decoded(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Result<Request, FrameError>> {
        bytes.iter().filter_map(|&byte| decoder.push(byte)).collect()
    }

    /// The CRC bit by bit, from its definition.
    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(u32::MAX, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
        })
    }

    #[test]
    fn a_frame_is_version_message_and_crc_between_zeros() {
        let frame = framed(&LinkCommand::Pause);
        // Version 2; id 0x1234 as varint B4 24; variant 1.
        let plain = [VERSION, 0xB4, 0x24, 1];
        let mut expected = plain.to_vec();
        expected.extend(crc32(&plain).to_le_bytes());
        // No zero in it, so COBS is one distance in front.
        assert!(!expected.contains(&0));
        expected.insert(0, expected.len() as u8 + 1);
        expected.push(0);
        assert_eq!(frame, expected);
    }

    #[test]
    fn the_documented_vectors_hold_both_ways() {
        let page = include_str!("../../../docs/protocol.md");
        let vectors = page.split("## Test vectors").nth(1).expect("the section is there");
        let rows = vectors.lines().filter_map(|line| line.strip_suffix("` |")?.rsplit_once("| `"));
        let frames: Vec<Vec<u8>> = rows
            .map(|(_, hex)| (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).expect("hex")))
            .map(Iterator::collect)
            .collect();
        assert_eq!(frames.len(), commands().len());
        for (command, frame) in commands().into_iter().zip(frames) {
            assert_eq!(framed(&command), frame, "{command:?}");
            assert_eq!(decoded(&mut Decoder::new(), &frame), [Ok(Request { id: 0x1234, command })]);
        }
    }

    #[test]
    fn no_bit_flip_makes_another_command() {
        let follower = framed(&LinkCommand::Vent);
        for command in commands() {
            let frame = framed(&command);
            for bit in 0..8 * frame.len() {
                let mut damaged = frame.clone();
                damaged[bit / 8] ^= 1 << (bit % 8);
                damaged.extend(&follower);
                damaged.extend(&follower);
                let mut decoder = Decoder::new();
                let taken = decoded(&mut decoder, &damaged);
                assert!(decoder.dropped() >= 1, "{command:?} bit {bit}");
                // What follows is understood; without its zero the frame takes the first follower with it.
                let vents = taken.iter().flatten().filter(|request| request.command == LinkCommand::Vent).count();
                assert_eq!(taken.iter().flatten().count(), vents, "{command:?} bit {bit}: {taken:?}");
                assert!((1..=2).contains(&vents), "{command:?} bit {bit}");
            }
        }
    }

    #[test]
    fn no_truncation_is_a_command_and_the_next_frame_is_understood() {
        for command in commands() {
            let frame = framed(&command);
            for length in 1..frame.len() - 1 {
                let mut decoder = Decoder::new();
                let mut bytes = frame[..length].to_vec();
                bytes.push(0);
                bytes.extend(&frame);
                let taken = decoded(&mut decoder, &bytes);
                assert_eq!(taken.len(), 2);
                assert!(taken[0].is_err() && taken[1].is_ok());
            }
        }
    }

    #[test]
    fn a_flood_is_one_dropped_frame() {
        let mut decoder = Decoder::new();
        let mut bytes = vec![7; 10_000];
        bytes.push(0);
        bytes.extend(framed(&LinkCommand::Vent));
        let taken = decoded(&mut decoder, &bytes);
        assert_eq!(taken[0], Err(FrameError::TooLong));
        assert_eq!(taken[1].as_ref().map(|request| &request.command), Ok(&LinkCommand::Vent));
        assert_eq!(decoder.dropped(), 1);
    }

    #[test]
    fn another_version_and_trailing_bytes_are_refused() {
        for (plain, error) in [
            (vec![1, 1, 1], FrameError::Version(1)),
            (vec![2, 1, 1, 9], FrameError::Message),
            (vec![2, 1, 99], FrameError::Message),
            (vec![2], FrameError::Message),
        ] {
            let mut content = plain.clone();
            content.extend(crc32(&plain).to_le_bytes());
            let mut frame = vec![0; 64];
            let length = cobs::try_encode(&content, &mut frame).expect("fits");
            frame.truncate(length);
            frame.push(0);
            assert_eq!(decoded(&mut Decoder::new(), &frame), [Err(error)]);
        }
    }

    #[test]
    fn the_widest_identification_fits() {
        let widest = IdentifiedSegment {
            coefficients: [i32::MIN; 3],
            residual_pressure: i32::MIN,
            residual_bend: i32::MIN,
            points: u16::MAX,
            ready: true,
        };
        let widest = Report::Identification { id: u16::MAX, segments: [widest; 3] };
        assert!(encode(&widest, &mut [0; MAX_FRAME]).is_some());
    }

    #[test]
    fn the_widest_telemetry_fits() {
        let widest = Report::Telemetry(Telemetry {
            tick: u32::MAX,
            mode: LinkMode::Faulted(255),
            faults: u64::MAX,
            priority: 3,
            setpoints: [i32::MIN; 3],
            estimates: [i32::MIN; 3],
            manifold: Some(i32::MIN),
            bend: Some(i32::MIN),
            outputs: 31,
            step: u16::MAX,
            repeat: u16::MAX,
            holding: true,
            fingertip_um: [i32::MIN; 2],
            fingertip_millideg: i32::MIN,
            force_mn: i32::MIN,
            overruns: u16::MAX,
            dropped_frames: u16::MAX,
            tick_cycles: u32::MAX,
            worst_tick_cycles: u32::MAX,
        });
        assert!(encode(&widest, &mut [0; MAX_FRAME]).is_some());
        assert_eq!(encode(&widest, &mut [0; 40]), None);
    }

    /// Every frame of up to five bytes with distances of 1 to 6 and of a run, and every length of one distance repeated.
    #[test]
    fn cobs_is_removed_as_the_crate_does_it() {
        const BYTES: [u8; 7] = [1, 2, 3, 4, 5, 6, 255];
        let agree = |frame: &[u8]| {
            let (mut ours, mut theirs) = (frame.to_vec(), frame.to_vec());
            let length = remove_cobs(&mut ours);
            assert_eq!(length, cobs::decode_in_place(&mut theirs).ok(), "{frame:?}");
            let length = length.unwrap_or(0);
            assert_eq!(ours[..length], theirs[..length], "{frame:?}");
        };
        for number in 0..BYTES.len().pow(5) {
            let frame: Vec<u8> = (0..5).map(|digit| BYTES[number / BYTES.len().pow(digit) % BYTES.len()]).collect();
            (1..=5).for_each(|length| agree(&frame[..length]));
        }
        // Runs of 254 bytes end without a zero.
        for (distance, length) in (1..=255_u8).flat_map(|distance| (1..=600).map(move |length| (distance, length))) {
            let frame: Vec<u8> =
                (0..length).map(|at| if at % usize::from(distance) == 0 { distance } else { 9 }).collect();
            agree(&frame);
        }
    }

    proptest! {
        #[test]
        fn requests_come_back(id: u16, which in 0_usize..10, cut in 0_usize..20) {
            let request = Request { id, command: commands()[which].clone() };
            let mut buffer = [0; MAX_FRAME];
            let length = encode(&request, &mut buffer).expect("fits");
            // Joining in the middle of a frame costs that frame only.
            let mut bytes = buffer[cut.min(length - 1)..length].to_vec();
            bytes.extend(&buffer[..length]);
            let taken = decoded(&mut Decoder::new(), &bytes);
            prop_assert_eq!(taken.last(), Some(&Ok(request)));
        }

        #[test]
        fn noise_is_no_command(bytes in proptest::collection::vec(any::<u8>(), 0..4000)) {
            prop_assert!(decoded(&mut Decoder::new(), &bytes).iter().all(Result::is_err));
        }
    }
}
