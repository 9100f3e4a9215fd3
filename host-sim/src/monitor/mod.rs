//! `host-sim monitor`: a device on the bench, or the emulated board, or a recording, on a terminal.
//!
//! What decides anything is pure: [`session`] makes rows of bytes and time, [`state`] makes of rows what is shown, [`keys`]
//! makes requests of keys, [`script`] takes their place where nobody watches, [`dashboard`] draws. I/O is around it:
//! [`source`] has the lines, [`recording`] the file, [`live`] joins them, [`terminal`] and [`headless`] are the loops.
//! `docs/monitor.md` is the page for users.

pub(crate) mod command;
pub mod dashboard;
pub mod event;
pub mod headless;
pub mod keys;
pub mod link;
pub mod live;
pub mod playback;
pub mod recording;
pub mod requests;
pub mod script;
pub mod session;
pub mod snapshot;
pub mod source;
pub mod state;
pub mod summary;
pub mod terminal;
#[cfg(test)]
mod testing;
