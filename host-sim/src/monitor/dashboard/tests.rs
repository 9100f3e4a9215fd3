use super::super::testing::{identified, told};
use super::*;
use crate::monitor::keys::Question;
use crate::report::record::{Record, Source};
use model_core::protocol::{LinkMode, Telemetry};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;

fn status() -> Status {
    Status {
        source: "/dev/ttyACM0".into(),
        firmware: Some("0.1.0".into()),
        connection: Some(Connection::Up),
        age_ms: Some(7),
        now_ms: 12_000,
        quality: Quality { frames: 1200, telemetry: 1199, bad_crc: 1, bad_other: 1, lost: 3, ..Quality::default() },
        recording: Ok("bench.csv".into()),
        asked: None,
        identified: Some(identified()),
        replay: None,
    }
}

/// Ten seconds of `reconfigure`, as the device tells them.
fn running() -> State {
    let mut state = State::default();
    for tick in (0..10_000_u32).step_by(10) {
        let rise = |kpa: f64| ((kpa * f64::from(tick.min(2000)) / 2000.0) * 65_536.0) as i32;
        let setpoints = [60.0, 30.0, 60.0].map(rise);
        let estimates = setpoints.map(|bits| bits - bits / 20);
        let step = u16::from(tick >= 7000);
        let told = Telemetry { setpoints, estimates, step, ..told(tick, LinkMode::Running) };
        let mut row = Record::from_telemetry(Source::Device, tick, &told);
        row.model_bends_deg = [70.0, 45.0, 70.0];
        row.event = if tick == 0 { "taken: run reconfigure".into() } else { String::new() };
        state.take(&row);
    }
    state
}

fn drawn(state: &State, keys: &Keys, status: &Status, size: (u16, u16)) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(size.0, size.1)).expect("a test's terminal");
    terminal.draw(|frame| draw(frame, state, keys, status)).expect("drawn");
    terminal.backend().buffer().clone()
}

fn text(buffer: &Buffer) -> String {
    let row = |y| (0..buffer.area.width).map(|x| buffer[(x, y)].symbol()).collect::<String>();
    (0..buffer.area.height).map(|y| row(y).trim_end().to_owned() + "\n").collect()
}

/// Compares with the golden text; `UPDATE_GOLDEN=1 cargo test -p host-sim dashboard` writes it anew.
fn golden(name: &str, buffer: &Buffer) {
    let path = format!("{}/src/monitor/dashboard/golden/{name}.txt", env!("CARGO_MANIFEST_DIR"));
    let text = text(buffer);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, &text).expect("writable");
    }
    let expected = std::fs::read_to_string(&path).expect("a golden text");
    assert!(text == expected, "{name} is\n{text}\nand should be\n{expected}");
}

#[test]
fn a_running_sequence_fits_the_smallest_terminal() {
    golden("running", &drawn(&running(), &Keys::default(), &status(), SMALLEST));
}

#[test]
fn more_room_shows_more() {
    golden("large", &drawn(&running(), &Keys::default(), &status(), (120, 40)));
}

#[test]
fn a_lost_link_and_alarms_stand_out() {
    let mut state = running();
    let told = Telemetry {
        faults: 1 << 4 | 1 << 42 | 1 << 63,
        priority: 3,
        manifold: None,
        ..told(10_000, LinkMode::Faulted(4))
    };
    let mut row = Record::from_telemetry(Source::Device, 10_000, &told);
    row.event = "link lost: the port is gone".into();
    state.take(&row);
    let status = Status {
        connection: Some(Connection::Down("the port is gone".into(), 9500)),
        recording: Err("no space left on device".into()),
        ..status()
    };
    let buffer = drawn(&state, &Keys::default(), &status, SMALLEST);
    golden("lost", &buffer);
    // Not yet seen: reversed. Seen: not any more.
    let reversed = |buffer: &Buffer| {
        let cells = buffer.content.iter().filter(|cell| cell.modifier.contains(Modifier::REVERSED));
        cells.map(ratatui::buffer::Cell::symbol).collect::<String>()
    };
    assert!(reversed(&buffer).contains("emergency-stop"), "{}", reversed(&buffer));
    state.acknowledge();
    assert!(!reversed(&drawn(&state, &Keys::default(), &status, SMALLEST)).contains("emergency-stop"));
}

#[test]
fn every_question_fits_the_smallest_terminal() {
    let values = |text: &str, wrong: Option<&str>| Question::Values {
        bends: false,
        text: text.into(),
        wrong: wrong.map(str::to_owned),
    };
    let calibration = [None, Some(model_core::calibration::DEFAULT), None];
    for (name, question) in [
        ("sequences", Question::Sequence(1)),
        ("values", values("60,30,151", Some("151 kPa is outside 0..=150 kPa, the finger's working range"))),
        ("zero", Question::Zero),
        ("calibrate", Question::Calibrate),
        ("adopt", Question::Adopt),
        ("help", Question::Help),
    ] {
        let keys = Keys { question, calibration, replay: false };
        golden(name, &drawn(&running(), &keys, &status(), SMALLEST));
    }
    let keys = Keys { question: Question::Adopt, ..Keys::default() };
    let unanswered = drawn(&running(), &keys, &Status { identified: None, ..status() }, SMALLEST);
    assert!(text(&unanswered).contains("has not answered yet"));
}

#[test]
fn before_the_first_frame_and_on_a_tiny_terminal_it_says_what_is_missing() {
    let waiting =
        Status { connection: Some(Connection::Waiting), age_ms: None, quality: Quality::default(), ..status() };
    assert!(
        text(&drawn(&State::default(), &Keys::default(), &waiting, SMALLEST)).contains("waiting for the first frame")
    );
    let tiny = text(&drawn(&running(), &Keys::default(), &status(), (70, 20)));
    assert!(tiny.contains("80 columns and 24 rows are needed"), "{tiny}");
    for size in [(1, 1), (3, 2), (0, 0), (500, 200)] {
        drawn(&running(), &Keys::default(), &status(), size);
    }
}

#[test]
fn a_simulated_run_replays_with_its_true_bends() {
    let sequence = model_core::sequence::library::find("reconfigure").expect("built in");
    let run = crate::simulate::Run::new(crate::simulate::Program::Sequence(sequence), 1);
    let trace = run.simulate(|_, _| {}).expect("taken");
    let mut state = State::default();
    trace.samples.iter().take(6000).for_each(|sample| state.take(&sample.into()));
    let replay = Status {
        source: "samples.csv".into(),
        firmware: None,
        connection: None,
        age_ms: None,
        quality: Quality::default(),
        replay: Some((5999, 16_000, false)),
        ..status()
    };
    let keys = Keys { replay: true, ..Keys::default() };
    golden("replay", &drawn(&state, &keys, &replay, SMALLEST));
}
