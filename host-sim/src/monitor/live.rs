//! A session on a line, recorded: what turns bytes into rows and requests into bytes, and vents when it ends.

use super::recording::Recorder;
use super::requests::framed;
use super::session::{Connection, Session};
use super::source::{Device, Happened};
use crate::report::record::Record;
use anyhow::Result;
use model_core::protocol::LinkCommand;
use std::time::Duration;

/// Longest wait for the answer to the last request, ms.
const FAREWELL_MS: u64 = 600;

/// See the module's page. Dropped without a [`Live::leave`] (a panic) it asks the device to vent.
pub struct Live {
    /// The pure part.
    pub session: Session,
    device: Box<dyn Device>,
    recorder: Recorder,
    left: bool,
}

impl Live {
    /// A device whose line is open.
    #[must_use]
    pub fn new(device: Box<dyn Device>, recorder: Recorder) -> Self {
        let mut session = Session::new(device.source());
        session.opened();
        Self { session, device, recorder, left: false }
    }

    /// One turn: what the line gave within the time becomes rows, and what is due is sent.
    ///
    /// # Errors
    /// When the device cannot go on at all.
    pub fn turn(&mut self, wait: Duration) -> Result<Vec<Record>> {
        let happened = self.device.poll(wait)?;
        let now_ms = self.device.now_ms();
        let mut rows = match happened {
            Happened::Bytes(bytes) => self.session.bytes(now_ms, &bytes),
            Happened::Lost(why) => self.session.cut(now_ms, &why).into_iter().collect(),
            Happened::Opened => {
                self.session.opened();
                Vec::new()
            }
            Happened::Nothing => Vec::new(),
        };
        let (bytes, silent) = self.session.tick(now_ms);
        self.device.send(&bytes);
        rows.extend(silent);
        let unix_ms = self.device.unix_ms();
        for row in &mut rows {
            row.unix_ms = unix_ms;
            self.device.complete(row);
            self.recorder.take(row);
        }
        Ok(rows)
    }

    /// Asks the device, at once.
    pub fn ask(&mut self, command: LinkCommand) {
        self.session.ask(command);
        let bytes = self.session.due(self.device.now_ms());
        self.device.send(&bytes);
    }

    /// Ends without venting.
    pub const fn leave(&mut self) {
        self.left = true;
    }

    /// Vents, and waits for the answer; returns the rows until then.
    ///
    /// # Errors
    /// As [`Self::turn`].
    pub fn vent(&mut self) -> Result<Vec<Record>> {
        let mut rows = Vec::new();
        if self.session.connection() == &Connection::Up {
            self.ask(LinkCommand::Vent);
            let until = self.device.now_ms() + FAREWELL_MS;
            while !self.session.idle() && self.device.now_ms() < until {
                rows.extend(self.turn(Duration::from_millis(5))?);
            }
            // One more row, for the answer to be noted in.
            let until = self.device.now_ms() + 2 * u64::from(super::link::FRAME_MS);
            while self.device.now_ms() < until {
                rows.extend(self.turn(Duration::from_millis(5))?);
            }
        }
        self.leave();
        Ok(rows)
    }

    /// The device.
    #[must_use]
    pub fn device(&self) -> &dyn Device {
        self.device.as_ref()
    }

    /// The recording.
    #[must_use]
    pub const fn recorder(&self) -> &Recorder {
        &self.recorder
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        if !self.left {
            self.device.send(&framed(u16::MAX, &LinkCommand::Vent));
        }
    }
}
