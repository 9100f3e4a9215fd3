//! Where bytes come from and go to.

pub mod serial;

use crate::report::record::{Record, Source};
use anyhow::Result;
use std::time::Duration;

/// What happened on a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Happened {
    /// Nothing.
    Nothing,
    /// It is there, for the first time or again.
    Opened,
    /// Bytes came.
    Bytes(Vec<u8>),
    /// It is gone: why.
    Lost(String),
}

/// A device on a line, with the clock that goes with it.
pub trait Device {
    /// What the recording calls it.
    fn source(&self) -> Source;

    /// What people call it.
    fn name(&self) -> String;

    /// The host's clock, ms since the start: a virtual one for a virtual device.
    fn now_ms(&self) -> u64;

    /// Time of day, ms since 1970 (UTC); nothing for a virtual device.
    fn unix_ms(&self) -> Option<u64>;

    /// Waits for the next thing to happen, but not much longer than this.
    ///
    /// # Errors
    /// When it cannot go on at all.
    fn poll(&mut self, wait: Duration) -> Result<Happened>;

    /// Sends bytes. A line that is not there, or breaks meanwhile, takes none; [`Self::poll`] tells.
    fn send(&mut self, bytes: &[u8]);

    /// Adds what is known of a row beside what the device said.
    fn complete(&self, _row: &mut Record) {}
}
