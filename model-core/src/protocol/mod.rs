//! The host's link: messages in frames.
//!
//! A frame is `COBS(version, message, CRC-32 of both, little endian)` and a zero byte. The message is postcard. COBS lies
//! outside, so that a zero always ends a frame and a receiver that joins late or loses bytes is in step again at the
//! next one; the CRC lies next, because COBS and postcard accept many damaged frames as other valid ones.
//! `docs/protocol.md` describes every field and has test vectors.
//!
//! ```
//! use model_core::calibration;
//! use model_core::controller::Controller;
//! use model_core::protocol::{Decoder, Effect, LinkCommand, MAX_FRAME, Request, encode, handle};
//!
//! // On the host:
//! let mut line = [0; MAX_FRAME];
//! let request = Request { id: 7, command: LinkCommand::Vent };
//! let length = encode(&request, &mut line).expect("every message fits");
//!
//! // On the device:
//! let mut controller = Controller::new([calibration::DEFAULT; 3]);
//! let mut decoder = Decoder::new();
//! let received: Vec<Request> = line[..length].iter().filter_map(|&byte| decoder.push(byte)?.ok()).collect();
//! assert_eq!(received, [request]);
//! assert_eq!(handle(&mut controller, &received[0].command), Ok(Effect::Nothing));
//! ```

pub mod frame;
pub mod handler;
pub mod message;

pub use frame::{Decoder, FrameError, MAX_FRAME, checksum, encode};
pub use handler::{Effect, handle};
pub use message::{
    IdentifiedSegment, Identity, LinkCommand, LinkMode, Reason, Report, Request, ResetCause, SequenceName, Telemetry,
    actuation_of, outputs_of,
};

/// Version of frames and messages; a frame of another version is dropped.
pub const VERSION: u8 = 2;
