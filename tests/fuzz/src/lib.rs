//! What the fuzz tests share: frames read by their definition, a session of commands and disturbed sensors told by bytes,
//! and the seeds of the corpora.
//!
//! `link.rs` has the tests; no other program may be built from this crate, because one without bolero does not link under
//! libFuzzer. docs/testing.md says how to run them for longer.

#[cfg(test)]
mod link;
pub mod reference;
pub mod seeds;
pub mod session;
