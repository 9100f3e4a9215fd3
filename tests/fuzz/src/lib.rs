//! What the fuzz tests share: frames read by their definition, a session of commands and disturbed sensors told by bytes,
//! and the seeds of the corpora.
//!
//! `tests/link.rs` has the tests; docs/testing.md says how to run them for longer.

pub mod reference;
pub mod seeds;
pub mod session;
