//! What the fuzz tests share: frames read by their definition, a session of commands and disturbed sensors told by bytes,
//! and the seeds of the corpora.
//!
//! ```
//! use finger_fuzz::reference::read;
//!
//! // The frame of Pause with id 0x1234 from docs/protocol.md, and one that has lost its end.
//! let pause = [0x09, 0x02, 0xB4, 0x24, 0x01, 0x6B, 0x90, 0xF5, 0xCF, 0x00];
//! let seen = read(&[&pause[..], &pause[..6], &[0]].concat());
//! assert_eq!((seen.requests.len(), seen.dropped), (1, 1));
//! ```
//!
//! ```text
//! cargo test -p finger-fuzz       the corpora and a bounded number of random inputs, in seconds
//! ```
//!
//! `link.rs` has the tests; no other program may be built from this crate, because one without bolero does not link under
//! libFuzzer. docs/testing.md says how to run them for longer.

#[cfg(test)]
mod link;
pub mod reference;
pub mod seeds;
pub mod session;
