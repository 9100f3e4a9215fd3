use super::super::recording::Recorder;
use super::super::testing::{frame, identity, telemetry, told};
use super::*;
use crate::report::csv;
use model_core::protocol::{LinkCommand, LinkMode, Report};

/// What a device of these tests does in a turn.
type Turn = Box<dyn FnMut(&mut Vec<u8>, u64)>;

/// A device on a line that never breaks, with a clock of its own.
struct Virtual {
    now_ms: u64,
    turn: Turn,
    answers: Vec<u8>,
    asked: std::rc::Rc<std::cell::RefCell<Vec<LinkCommand>>>,
}

impl super::super::source::Device for Virtual {
    fn source(&self) -> crate::report::record::Source {
        crate::report::record::Source::Device
    }

    fn name(&self) -> String {
        "virtual".into()
    }

    fn now_ms(&self) -> u64 {
        self.now_ms
    }

    fn unix_ms(&self) -> Option<u64> {
        None
    }

    fn poll(&mut self, _: Duration) -> Result<super::super::source::Happened> {
        self.now_ms += 10;
        let mut bytes = core::mem::take(&mut self.answers);
        (self.turn)(&mut bytes, self.now_ms);
        Ok(super::super::source::Happened::Bytes(bytes))
    }

    fn send(&mut self, bytes: &[u8]) {
        for request in super::super::testing::requests(bytes) {
            self.asked.borrow_mut().push(request.command.clone());
            self.answers.extend(frame(&match request.command {
                LinkCommand::Identify => identity(request.id),
                _ => Report::Ack { id: request.id },
            }));
        }
    }
}

fn summarised(script: &mut Script, turn: Turn) -> (Summary, Option<String>, Vec<LinkCommand>, Vec<u8>) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("one.csv");
    let asked = std::rc::Rc::default();
    let device = Virtual { now_ms: 0, turn, answers: Vec::new(), asked: std::rc::Rc::clone(&asked) };
    let mut live = Live::new(Box::new(device), Recorder::create(Some(&path)).expect("new"));
    let (summary, failure) = run(&mut live, script, &AtomicBool::new(false)).expect("goes on");
    drop(live);
    let asked = asked.borrow().clone();
    (summary, failure, asked, std::fs::read(&path).expect("there"))
}

#[test]
fn malformed_frames_are_counted_and_the_others_are_recorded() {
    let turn = |bytes: &mut Vec<u8>, now: u64| {
        let mut one = frame(&telemetry(now as u32));
        match now {
            // A flipped bit, noise before the frame, and a frame that never comes.
            500 => one[10] ^= 1,
            700 => one.splice(0..0, [9, 9, 9, 0]).for_each(drop),
            900 => one.clear(),
            _ => {}
        }
        bytes.extend(one);
    };
    let (summary, failure, _, bytes) = summarised(&mut Script::new(vec![], None, Some(2000)), Box::new(turn));
    assert_eq!(failure, None);
    assert_eq!((summary.frames_bad, summary.frames_bad_crc, summary.frames_lost), (Some(2), Some(1), Some(2)));
    assert_eq!((summary.link_gaps, summary.mode.as_deref()), (0, Some("vented")));
    assert_eq!(summary.firmware.as_deref(), Some("0.1.0"));
    let recording = csv::read(&bytes).expect("a recording");
    assert_eq!((recording.records.len() as u64, recording.bad_lines, recording.torn), (summary.rows, 0, false));
    let link = recording.records.last().expect("rows").link;
    assert_eq!((link.frames_lost, link.frames_bad), (Some(2), Some(2)));
}

#[test]
fn what_was_set_in_motion_is_vented_at_the_end_and_nothing_else_is() {
    let sequence = model_core::sequence::library::find("all");
    let running = |bytes: &mut Vec<u8>, now: u64| {
        let mode = if now < 1500 { LinkMode::Vented } else { LinkMode::Running };
        bytes.extend(frame(&Report::Telemetry(told(now as u32, mode))));
    };
    let (summary, _, asked, bytes) = summarised(&mut Script::new(vec![], sequence, Some(2000)), Box::new(running));
    assert_eq!(asked.last(), Some(&LinkCommand::Vent));
    assert_eq!(summary.sequence_outcome.as_deref(), Some("running"));
    let events: Vec<_> = csv::read(&bytes)
        .expect("reads")
        .records
        .into_iter()
        .map(|row| row.event)
        .filter(|one| !one.is_empty())
        .collect();
    assert!(events.last().is_some_and(|last| last.ends_with("taken: vent")), "{events:?}");
    let (_, _, asked, _) = summarised(&mut Script::new(vec![], None, Some(1000)), Box::new(running));
    assert_eq!(asked, [LinkCommand::Identify]);
}

#[test]
fn a_line_without_a_frame_fails() {
    let (summary, failure, _, _) = summarised(&mut Script::new(vec![], None, Some(1000)), Box::new(|_, _| {}));
    assert!(failure.is_some_and(|why| why.contains("no frame came")));
    assert_eq!((summary.rows, summary.mode), (0, None));
}

#[cfg(unix)]
mod on_a_line {
    use super::*;
    use crate::monitor::source::serial::{Serial, Wanted};
    use serialport::{SerialPort, TTYPort};
    use std::io::{Read, Write};
    use std::path::{Path, PathBuf};
    use std::sync::Arc;
    use std::time::Instant;

    /// Puts a new pseudo terminal where the monitor looks for its port; returns the device's end.
    fn plug(link: &Path) -> TTYPort {
        let (device, port) = TTYPort::pair().expect("a pseudo terminal");
        let path: PathBuf = port.name().expect("named").into();
        // The monitor opens it for itself, and locks it.
        drop(port);
        std::os::unix::fs::symlink(path, link).expect("a link");
        device
    }

    /// Waits until the monitor has asked who is there, so it listens. Until it has opened the port, reading fails.
    fn heard(device: &mut TTYPort) {
        device.set_timeout(Duration::from_millis(100)).expect("set");
        let mut byte = [0];
        while device.read_exact(&mut byte).is_err() {
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn a_cable_pulled_in_mid_frame_and_put_back_is_survived() {
        let folder = tempfile::tempdir().expect("a folder");
        let (link, path) = (folder.path().join("port"), folder.path().join("one.csv"));
        let mut device = plug(&link);
        let stop = Arc::new(AtomicBool::new(false));
        let monitor = {
            let (stop, link, path) = (Arc::clone(&stop), link.clone(), path.clone());
            std::thread::spawn(move || {
                let wanted = Wanted::Path(link.display().to_string());
                let serial = Serial::new(wanted).expect("opens");
                let mut live = Live::new(Box::new(serial), Recorder::create(Some(&path)).expect("new"));
                run(&mut live, &mut Script::new(vec![], None, None), &stop).expect("goes on")
            })
        };
        heard(&mut device);
        let rows =
            |path: &Path| csv::read(&std::fs::read(path).unwrap_or_default()).map_or(0, |read| read.records.len());
        let reached = |least: usize| {
            while rows(&path) < least {
                std::thread::sleep(Duration::from_millis(5));
            }
        };
        let frames = |first: u32, count: u32| -> Vec<u8> {
            (0..count).flat_map(|index| frame(&telemetry(first + 10 * index))).collect()
        };
        device.write_all(&frames(1000, 50)).expect("written");
        reached(50);
        let then = Instant::now();
        // Half a frame, and the cable is out. The recording has a row for it before the cable is back.
        device.write_all(&frame(&telemetry(1500))[..20]).expect("written");
        while device.bytes_to_write().expect("known") > 0 {}
        std::fs::remove_file(&link).expect("removed");
        drop(device);
        reached(51);
        let mut device = plug(&link);
        heard(&mut device);
        // Whole frames later by the device's clock, which has gone on as the host's has.
        let missing = then.elapsed().as_millis() as u32 / 10;
        device.write_all(&frames(1500 + 10 * missing, 30)).expect("written");
        reached(81);
        stop.store(true, Ordering::Relaxed);
        let (summary, failure) = monitor.join().expect("ends");
        assert_eq!(failure, None);
        // The half frame is bad only if it was read before the line broke.
        assert_eq!((summary.frames_lost, summary.device_restarts), (Some(missing), 0));
        assert!(summary.frames_bad.is_some_and(|bad| bad <= 1), "{summary:?}");
        let bytes = std::fs::read(&path).expect("there");
        let recording = csv::read(&bytes).expect("a recording");
        assert_eq!((recording.bad_lines, recording.torn), (0, false));
        // A slow machine may take the silence at the end for another lost link.
        let rows = &recording.records[..81];
        let gaps: Vec<_> = (0..81).filter(|&index| rows[index].event.contains("link lost: ")).collect();
        assert_eq!(gaps, [50]);
        let back = &rows[51].event;
        assert!(back.contains("link back after") && back.contains(&format!("{missing} frames lost")), "{back}");
        assert!(rows[50].estimates_kpa[0].is_nan() && !rows[51].estimates_kpa[0].is_nan());
        cut_anywhere(&bytes);
    }

    /// A recording that is cut at any byte after its first row is still one, with every whole row.
    fn cut_anywhere(bytes: &[u8]) {
        let ends: Vec<_> = (0..bytes.len()).filter(|&at| bytes[at] == b'\n').collect();
        for cut in ends[1] + 1..=ends[6] {
            let recording = csv::read(&bytes[..cut]).expect("a recording");
            let whole = ends.iter().filter(|&&end| end < cut).count() - 1;
            assert_eq!((recording.records.len(), recording.bad_lines), (whole, 0), "cut at {cut}");
        }
    }

    #[test]
    fn a_port_that_is_not_there_is_refused_by_name() {
        let wanted = Wanted::Path("/dev/ttyNOTHERE".into());
        let error = Serial::new(wanted).err().expect("not there");
        assert!(error.contains("/dev/ttyNOTHERE"), "{error}");
    }
}
