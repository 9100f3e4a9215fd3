//! From bytes on the line to reports, and how good the line is.
//!
//! The telemetry has no number of its own; its clock counts instead: a frame comes every 10 ms of the device's time, so the
//! time between two frames says how many are missing.

use model_core::protocol::{Decoder, FrameError, Report};

/// Device time between two telemetry frames, ms.
pub const FRAME_MS: u32 = 10;
/// Host and device may differ by so much over a gap, ms, before the device must have started anew in it.
const SAME_START_MS: u64 = 1000;

/// Counts since the start. None of them ever falls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quality {
    /// Whole frames: telemetry and answers.
    pub frames: u64,
    /// Telemetry frames among them.
    pub telemetry: u64,
    /// Frames whose CRC does not fit.
    pub bad_crc: u32,
    /// Other frames that are no message: too long, no COBS, unknown, of another version, or cut by a pulled cable.
    pub bad_other: u32,
    /// Version of the last frame that had another one.
    pub other_version: Option<u8>,
    /// Telemetry frames that the device must have sent and that never came.
    pub lost: u32,
    /// Starts of the device that were seen: its clock went back.
    pub restarts: u32,
}

impl Quality {
    /// Every frame that came and was no message.
    #[must_use]
    pub const fn bad(&self) -> u32 {
        self.bad_crc.saturating_add(self.bad_other)
    }
}

/// The receiving end of the line.
#[derive(Debug, Default)]
pub struct Link {
    decoder: Decoder,
    /// Bytes of a frame have come, and not its end.
    inside: bool,
    /// No frame has ended since the line was there: the first one may have been joined in its middle.
    joined: bool,
    quality: Quality,
    last: Option<Seen>,
    /// The line was cut since the last telemetry.
    was_cut: bool,
}

/// When telemetry came last, by both clocks.
#[derive(Clone, Copy, Debug)]
struct Seen {
    host_ms: u64,
    tick: u32,
}

/// A report, and what the device's clock says about the one before.
#[derive(Clone, Debug, PartialEq)]
pub struct Received {
    /// What came.
    pub report: Report,
    /// The device has started anew since the last telemetry.
    pub restarted: bool,
    /// Telemetry frames missing before this one.
    pub lost: u32,
}

impl Link {
    /// Counts so far.
    #[must_use]
    pub const fn quality(&self) -> &Quality {
        &self.quality
    }

    /// Takes what the line gave.
    pub fn bytes(&mut self, host_ms: u64, bytes: &[u8]) -> Vec<Received> {
        bytes.iter().filter_map(|&byte| self.byte(host_ms, byte)).collect()
    }

    fn byte(&mut self, host_ms: u64, byte: u8) -> Option<Received> {
        self.inside = byte != 0;
        let outcome = self.decoder.push::<Report>(byte)?;
        let first = !core::mem::replace(&mut self.joined, true);
        match outcome {
            Ok(report) => Some(self.report(host_ms, report)),
            // Its start was sent before anybody listened.
            Err(_) if first => None,
            Err(error) => {
                self.bad(error);
                None
            }
        }
    }

    fn bad(&mut self, error: FrameError) {
        let count = if error == FrameError::Crc { &mut self.quality.bad_crc } else { &mut self.quality.bad_other };
        *count = count.saturating_add(1);
        if let FrameError::Version(version) = error {
            self.quality.other_version = Some(version);
        }
    }

    fn report(&mut self, host_ms: u64, report: Report) -> Received {
        self.quality.frames += 1;
        let Report::Telemetry(told) = &report else { return Received { report, restarted: false, lost: 0 } };
        self.quality.telemetry += 1;
        let cut = core::mem::take(&mut self.was_cut);
        let before = self.last.replace(Seen { host_ms, tick: told.tick });
        let (restarted, lost) = before.map_or((false, 0), |before| {
            let elapsed = u64::from(told.tick.saturating_sub(before.tick));
            let away = host_ms.saturating_sub(before.host_ms);
            // A device that was without power while the cable was out may have run for longer since than before.
            if told.tick < before.tick || cut && away > elapsed + SAME_START_MS {
                return (true, 0);
            }
            (false, ((elapsed as u32).saturating_add(FRAME_MS / 2) / FRAME_MS).saturating_sub(1))
        });
        self.quality.restarts += u32::from(restarted);
        self.quality.lost = self.quality.lost.saturating_add(lost);
        Received { report, restarted, lost }
    }

    /// The line is gone; a frame that it cut is bad.
    pub fn cut(&mut self) {
        if core::mem::take(&mut self.inside) && self.joined {
            self.quality.bad_other = self.quality.bad_other.saturating_add(1);
        }
        self.decoder = Decoder::new();
        self.joined = false;
        self.was_cut = true;
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{frame, telemetry};
    use super::*;

    fn ticks(received: &[Received]) -> Vec<u32> {
        let tick = |one: &Received| match &one.report {
            Report::Telemetry(told) => told.tick,
            other => panic!("{other:?}"),
        };
        received.iter().map(tick).collect()
    }

    #[test]
    fn missing_ticks_are_lost_frames() {
        let mut link = Link::default();
        for tick in [1000, 1010, 1020, 1050, 1060] {
            link.bytes(0, &frame(&telemetry(tick)));
        }
        assert_eq!((link.quality().telemetry, link.quality().lost, link.quality().bad()), (5, 2, 0));
    }

    #[test]
    fn a_frame_joined_in_its_middle_is_not_the_lines_fault_and_a_damaged_one_is() {
        let whole = frame(&telemetry(10));
        let mut link = Link::default();
        assert_eq!(link.bytes(0, &whole[5..]), []);
        assert_eq!(link.quality().bad(), 0);
        let mut damaged = frame(&telemetry(20));
        let last_of_crc = damaged.len() - 2;
        damaged[last_of_crc] ^= 0x40;
        assert_eq!(link.bytes(0, &damaged), []);
        assert_eq!((link.quality().bad_crc, link.quality().bad_other), (1, 0));
        assert_eq!(ticks(&link.bytes(0, &frame(&telemetry(30)))), [30]);
        // Longer than any frame, then a good one.
        link.bytes(0, &[7; 500]);
        link.bytes(0, &[0]);
        assert_eq!((link.quality().bad_crc, link.quality().bad_other), (1, 1));
        assert_eq!(ticks(&link.bytes(0, &frame(&telemetry(40)))), [40]);
    }

    #[test]
    fn a_cable_pulled_anywhere_in_a_frame_costs_that_frame_alone() {
        let whole = frame(&telemetry(20));
        for at in 1..whole.len() {
            let mut link = Link::default();
            link.bytes(0, &frame(&telemetry(10)));
            link.bytes(10, &whole[..at]);
            link.cut();
            // Back in the middle of another frame.
            let received = link.bytes(500, &[&whole[at..], &frame(&telemetry(510))].concat());
            assert_eq!(ticks(&received), [510], "cut at {at}");
            let quality = link.quality();
            // The two halves are never taken for a whole; 49 frames between 10 and 510 ms never came.
            assert_eq!((quality.bad(), quality.lost, quality.restarts), (1, 49, 0), "cut at {at}");
        }
    }

    #[test]
    fn a_start_of_the_device_is_no_loss() {
        let mut link = Link::default();
        link.bytes(0, &frame(&telemetry(90_000)));
        assert!(link.bytes(100, &frame(&telemetry(10)))[0].restarted);
        link.cut();
        // Its clock is ahead of where it was, but by less than the time that the cable was out.
        assert!(link.bytes(60_000, &frame(&telemetry(5000)))[0].restarted);
        assert_eq!((link.quality().lost, link.quality().restarts), (0, 2));
    }

    #[test]
    fn another_version_is_told() {
        let mut link = Link::default();
        link.bytes(0, &frame(&telemetry(10)));
        let mut plain = vec![3, 1, 1];
        plain.extend(model_core::protocol::checksum(&plain).to_le_bytes());
        let mut coded = vec![0; 32];
        let length = cobs::try_encode(&plain, &mut coded).expect("fits");
        coded.truncate(length);
        coded.push(0);
        assert_eq!(link.bytes(0, &coded), []);
        assert_eq!((link.quality().other_version, link.quality().bad_other), (Some(3), 1));
    }
}
