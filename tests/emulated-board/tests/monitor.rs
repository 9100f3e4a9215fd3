//! `host-sim monitor` on the ELF: a sequence to its end, and a recording of what the plant did.

use anyhow::Result;
use emulated_board::OnLine;
use emulated_board::time::MILLISECOND;
use host_sim::monitor::headless;
use host_sim::monitor::live::Live;
use host_sim::monitor::recording::Recorder;
use host_sim::monitor::script::Script;
use host_sim::monitor::source::{Device, Happened};
use host_sim::monitor::summary::Summary;
use host_sim::report::csv::{Recording, read};
use host_sim::report::record::{Record, Source};
use model_core::actuation::Actuation;
use model_core::protocol::{LinkCommand, LinkMode};
use model_core::sequence::library;
use std::cell::RefCell;
use std::path::Path;
use std::process::Command;
use std::rc::Rc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What the bench itself says of one moment: board's clock in ms, pressures, pins.
struct Seen {
    board_ms: u32,
    chambers_kpa: [f64; 3],
    pins: Actuation,
}

/// The board on its line, watched from behind, and with a cable that can be out.
struct Watched {
    board: OnLine,
    seen: Rc<RefCell<Vec<Seen>>>,
    /// From when to when the cable is out, ms.
    out: std::ops::Range<u64>,
    is_out: bool,
}

impl Device for Watched {
    fn source(&self) -> Source {
        self.board.source()
    }

    fn name(&self) -> String {
        self.board.name()
    }

    fn now_ms(&self) -> u64 {
        self.board.now_ms()
    }

    fn unix_ms(&self) -> Option<u64> {
        None
    }

    fn poll(&mut self, wait: Duration) -> Result<Happened> {
        let happened = self.board.poll(wait)?;
        let bench = &self.board.bench;
        self.seen.borrow_mut().push(Seen {
            board_ms: (bench.board.time() / MILLISECOND) as u32,
            chambers_kpa: bench.plant.truth().chambers_kpa,
            pins: bench.actuation(),
        });
        let was_out = self.is_out;
        self.is_out = self.out.contains(&self.board.now_ms());
        Ok(match (was_out, self.is_out) {
            (false, true) => Happened::Lost("the cable is out".into()),
            (true, true) => Happened::Nothing,
            (true, false) => Happened::Opened,
            (false, false) => happened,
        })
    }

    fn send(&mut self, bytes: &[u8]) {
        if !self.is_out {
            self.board.send(bytes);
        }
    }

    fn complete(&self, row: &mut Record) {
        self.board.complete(row);
    }
}

fn watched(seed: u64, out: std::ops::Range<u64>) -> (Watched, Rc<RefCell<Vec<Seen>>>) {
    let seen = Rc::default();
    let board = OnLine::new(seed, None).expect("built");
    (Watched { board, seen: Rc::clone(&seen), out, is_out: false }, seen)
}

/// Runs a sequence to its end.
fn run(name: &str, out: std::ops::Range<u64>) -> (Summary, Recording, Vec<Seen>) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("one.csv");
    let (device, seen) = watched(4, out);
    let mut live = Live::new(Box::new(device), Recorder::create(Some(&path)).expect("new"));
    let mut script = Script::new(Vec::new(), library::find(name), None);
    let (summary, failure) = headless::run(&mut live, &mut script, &AtomicBool::new(false)).expect("goes on");
    assert_eq!(failure, None, "{summary:?}");
    drop(live);
    let recording = read(&std::fs::read(&path).expect("there")).expect("a recording");
    assert_eq!((recording.bad_lines, recording.torn), (0, false));
    (summary, recording, seen.take())
}

/// The row of this time of the board's clock, the one after it, and whether its reference has rested for a second.
fn row_at(rows: &[Record], board_ms: u32) -> Option<(&Record, &Record, bool)> {
    let at = rows.iter().position(|row| row.device_ms.is_some_and(|tick| tick.abs_diff(board_ms) <= 5))?;
    let rested = at >= 100 && rows[at - 100..=at].iter().all(|row| row.holding && row.mode == LinkMode::Running);
    Some((&rows[at], rows.get(at + 1)?, rested))
}

#[test]
fn the_recording_is_what_the_plant_did() {
    let (summary, recording, seen) = run("reconfigure", 0..0);
    assert_eq!(summary.sequence_outcome.as_deref(), Some("finished"));
    assert_eq!((summary.frames_lost, summary.frames_bad, summary.link_gaps), (Some(0), Some(0), 0));
    assert_eq!(summary.alarms, []);
    let rows = &recording.records;
    for pair in rows.windows(2) {
        assert_eq!(
            (pair[1].time_ms - pair[0].time_ms, pair[1].device_ms),
            (10, pair[0].device_ms.map(|tick| tick + 10))
        );
    }
    let (mut held, mut pumped, mut compared) = (0, 0, 0);
    for one in &seen {
        let Some((row, next, rested)) = row_at(rows, one.board_ms) else { continue };
        compared += 1;
        // The truth that stands in the row is the plant's, at most 5 ms away; pressure changes by less than 1 kPa in that time
        // but while it vents.
        if rested {
            held += 1;
            for index in 0..3 {
                let (is, estimate) = (one.chambers_kpa[index], row.estimates_kpa[index]);
                assert!((is - row.chambers_kpa[index]).abs() < 0.5, "{} ms: {is} and {row:?}", one.board_ms);
                assert!((is - estimate).abs() < 2.0, "{} ms: {is} where the row says {estimate}", one.board_ms);
                assert!((is - row.setpoints_kpa[index]).abs() < 3.0, "{} ms: {is} of {row:?}", one.board_ms);
            }
        }
        pumped += usize::from(one.pins.pump && row.actuation.pump);
        // The pin may have switched since the row, which the next one tells: the pump runs and rests for 15 ms at the least.
        let told = [row, next].map(|row| row.actuation.pump);
        assert!(
            told.contains(&one.pins.pump),
            "{} ms: pump {} where the rows say {told:?}",
            one.board_ms,
            one.pins.pump
        );
    }
    // Every 20 ms of more than 14 s; four of the five seconds at 60/30/60 kPa at the least.
    assert!(
        compared > 700 && held >= 200 && pumped > 20,
        "{compared} compared, {held} held, {pumped} with the pump on"
    );
    let last = rows.last().expect("rows");
    assert!(last.chambers_kpa.iter().all(|&kpa| kpa < 2.0), "vented at the end: {last:?}");
    assert_eq!((last.mode, last.actuation), (LinkMode::Vented, Actuation::SAFE));
}

#[test]
fn a_sequence_goes_on_without_its_host_and_the_gap_is_counted_to_the_frame() {
    let (summary, recording, _) = run("reconfigure", 6000..7500);
    assert_eq!(summary.sequence_outcome.as_deref(), Some("finished"));
    assert_eq!((summary.link_gaps, summary.device_restarts, summary.alarms.len()), (1, 0, 0));
    let rows = &recording.records;
    let back = rows.iter().position(|row| row.event.contains("link back after")).expect("it comes back");
    assert!(rows[back - 1].event.contains("link lost: the cable is out"), "{:?}", rows[back - 1]);
    let (before, after) = (rows[back - 2].device_ms.expect("a tick"), rows[back].device_ms.expect("a tick"));
    assert_eq!(summary.frames_lost, Some((after - before) / 10 - 1));
    assert!((140..160).contains(&summary.frames_lost.unwrap_or(0)), "{summary:?}");
    assert_eq!(rows[back].mode, LinkMode::Running);
}

#[test]
fn a_finger_driven_by_hand_stays_where_it_is_while_the_monitor_beats_and_vents_when_it_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let (device, seen) = watched(4, 0..0);
    let recorder = Recorder::create(Some(&folder.path().join("one.csv"))).expect("new");
    let mut live = Live::new(Box::new(device), recorder);
    let mut last = None;
    let mut turn = |live: &mut Live, until: u64| {
        while live.device().now_ms() < until {
            last = live.turn(Duration::ZERO).expect("goes on").pop().or(last.take());
        }
        last.clone().expect("a row")
    };
    turn(&mut live, 4000);
    live.ask(LinkCommand::Setpoints([40 << 16, 20 << 16, 0]));
    let row = turn(&mut live, 12_000);
    assert_eq!((row.mode, row.faults.is_empty()), (LinkMode::Holding, true), "{row:?}");
    for (is, should) in seen.borrow().last().expect("seen").chambers_kpa.into_iter().zip([40.0, 20.0, 0.0]) {
        assert!((is - should).abs() < 3.0, "{is} where {should} kPa should be");
    }
    let rows = live.vent().expect("answers");
    assert_eq!(rows.last().map(|row| row.mode), Some(LinkMode::Vented), "{rows:?}");
}

fn monitor(arguments: &[&str], record: &Path) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_emulated-board"))
        .args(["monitor", "--elf", "--json", "--record"])
        .arg(record)
        .args(arguments)
        .output()
        .expect("starts")
}

#[test]
fn the_command_prints_its_summary_and_overwrites_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("one.csv");
    let output = monitor(&["--sequence", "proximal", "--for", "20"], &path);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert_eq!(json["sequence"], "proximal");
    assert_eq!(json["sequence_outcome"], "finished");
    assert_eq!((&json["frames_lost"], &json["frames_bad"], &json["mode"]), (&0.into(), &0.into(), &"vented".into()));
    assert_eq!(json["alarms"].as_array().map(Vec::len), Some(0), "{json:#}");
    let bytes = std::fs::read(&path).expect("there");
    let recording = read(&bytes).expect("a recording");
    // A row each 10 ms from the first frame on.
    assert_eq!(json["rows"], recording.records.len());
    assert!((1995..=2005).contains(&recording.records.len()), "{}", recording.records.len());
    let highest = recording.records.iter().map(|row| row.chambers_kpa[0]).fold(0.0, f64::max);
    let told = json["highest_estimate_kpa"][0].as_f64().expect("a number");
    assert!((148.0..160.0).contains(&highest) && (told - highest).abs() < 3.0, "{highest} and {told}");

    let again = monitor(&["--for", "1"], &path);
    assert_eq!(again.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&again.stderr).contains("--record"));
    assert!(std::fs::read(&path).expect("there") == bytes, "the first recording is as it was");

    let unknown = monitor(&["--sequence", "gymnastics"], &folder.path().join("two.csv"));
    assert_eq!(unknown.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("reconfigure"));
    assert!(!folder.path().join("two.csv").exists());
}
