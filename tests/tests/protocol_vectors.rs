//! docs/figures/protocol-vectors.json, frames for hosts in other languages: they are what the core encodes, and
//! docs/protocol.py, written from docs/protocol.md, reads and writes the same.
//!
//! After a message has changed: `cargo test -p finger-tests --test protocol_vectors -- --ignored` writes the file anew.

use model_core::actuation::Segment;
use model_core::protocol::{
    Decoder, FrameError, IdentifiedSegment, Identity, LinkCommand, LinkMode, MAX_FRAME, Reason, Report, Request,
    ResetCause, SequenceName, Telemetry, VERSION, checksum, encode,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::Command;

fn docs(file: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs").join(file)
}

fn frame(message: &impl Serialize) -> Vec<u8> {
    let mut buffer = [0; MAX_FRAME];
    let length = encode(message, &mut buffer).expect("fits");
    buffer[..length].to_vec()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |text, byte| format!("{text}{byte:02x}"))
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).expect("hexadecimal")).collect()
}

fn vector(message: &impl Serialize) -> Value {
    json!({ "frame_hex": hex(&frame(message)), "message": message })
}

fn requests() -> Vec<Request> {
    let name = |name: &str| SequenceName::try_from(name).expect("short");
    let commands = [
        LinkCommand::Run(name("reconfigure")),
        LinkCommand::Pause,
        LinkCommand::Resume,
        LinkCommand::Vent,
        LinkCommand::Setpoints([60 << 16, 30 << 16, 60 << 16]),
        LinkCommand::ZeroSensors,
        LinkCommand::Calibrate { segment: Segment::Middle, k: 0, c1: 232_121_178, c2: 5_630_601 },
        LinkCommand::Identify,
        LinkCommand::ClearFault,
        LinkCommand::Beat,
        LinkCommand::Bends([45 << 16, 30 << 16, 15 << 16]),
        LinkCommand::Identification,
        LinkCommand::AdoptIdentified,
    ];
    // Numbers at the borders of their lengths.
    let ids = [0, 1, 127, 128, 16_383, 16_384, u16::MAX].map(|id| Request { id, command: LinkCommand::Beat });
    let wide = [
        LinkCommand::Setpoints([0, -1, 1]),
        LinkCommand::Setpoints([i32::MIN, i32::MAX, -65_536]),
        LinkCommand::Run(name("")),
        LinkCommand::Run(name("abcdefghij-klmnopqrst-uv")),
        LinkCommand::Calibrate { segment: Segment::Distal, k: i32::MAX, c1: i32::MIN, c2: -1 },
    ];
    commands.into_iter().chain(wide).map(|command| Request { id: 0x1234, command }).chain(ids).collect()
}

#[expect(clippy::too_many_lines, reason = "one report of each kind")]
fn reports() -> Vec<Report> {
    let at_rest = Telemetry {
        tick: 0,
        mode: LinkMode::Vented,
        faults: 0,
        priority: 0,
        setpoints: [0; 3],
        estimates: [0; 3],
        manifold: Some(0),
        bend: Some(0),
        outputs: 0,
        step: 0,
        repeat: 0,
        holding: false,
        fingertip_um: [0; 2],
        fingertip_millideg: 0,
        force_mn: 0,
        overruns: 0,
        dropped_frames: 0,
        tick_cycles: 0,
        worst_tick_cycles: 0,
    };
    let running = Telemetry {
        tick: 123_456,
        mode: LinkMode::Running,
        setpoints: [60 << 16, 30 << 16, 60 << 16],
        estimates: [3_932_000, 1_966_100, 3_931_999],
        manifold: Some(3_932_160),
        bend: Some(-1),
        outputs: 0b11110,
        step: 1,
        repeat: 2,
        holding: true,
        fingertip_um: [61_234, -5_678],
        fingertip_millideg: 123_456,
        force_mn: 1_500,
        tick_cycles: 3_600,
        worst_tick_cycles: 7_077,
        ..at_rest
    };
    let widest = Telemetry {
        tick: u32::MAX,
        mode: LinkMode::Faulted(3),
        faults: u64::MAX,
        priority: 3,
        setpoints: [i32::MIN; 3],
        estimates: [i32::MAX; 3],
        manifold: None,
        bend: None,
        outputs: 0,
        step: u16::MAX,
        repeat: u16::MAX,
        fingertip_um: [i32::MIN; 2],
        fingertip_millideg: i32::MIN,
        force_mn: i32::MIN,
        overruns: u16::MAX,
        dropped_frames: u16::MAX,
        tick_cycles: u32::MAX,
        worst_tick_cycles: u32::MAX,
        ..at_rest
    };
    let segment = IdentifiedSegment {
        coefficients: [0, 232_121_178, 5_630_601],
        residual_pressure: 6_554,
        residual_bend: 32_768,
        points: 20,
        ready: true,
    };
    let reasons = [
        Reason::UnknownSequence,
        Reason::Faulted,
        Reason::SetpointOutOfLimits,
        Reason::CoefficientOutOfLimits,
        Reason::NotRunning,
        Reason::NotPaused,
        Reason::NotVented,
        Reason::CauseStillPresent,
        Reason::NoFault,
        Reason::ZeroOutOfLimits,
        Reason::StorageFailed,
        Reason::SelfTesting,
        Reason::NothingIdentified,
    ];
    let causes = [
        ResetCause::PowerOn,
        ResetCause::Brownout,
        ResetCause::Pin,
        ResetCause::Software,
        ResetCause::Watchdog,
        ResetCause::Other,
    ];
    let identity = |reset_cause| Identity {
        id: 0x1234,
        protocol: VERSION,
        firmware: heapless_text("0.1.0"),
        serial: [1, 0x8000_0000, u32::MAX],
        reset_cause,
        coefficients: [[0, 232_121_178, 5_630_601]; 3],
        pressure_zero: -65_536,
        bend_zero: 65_536,
        sequences: 15,
    };
    let modes = [LinkMode::SelfTest, LinkMode::Holding, LinkMode::Paused].map(|mode| Telemetry { mode, ..at_rest });
    let telemetry = [at_rest, running, widest].into_iter().chain(modes).map(Report::Telemetry);
    telemetry
        .chain([Report::Ack { id: 0x1234 }])
        .chain(reasons.map(|reason| Report::Nack { id: 0x1234, reason }))
        .chain(causes.map(|cause| Report::Identity(identity(cause))))
        .chain([Report::Identification { id: 0x1234, segments: [segment; 3] }])
        .collect()
}

/// The identity's text type, without naming its crate.
fn heapless_text<'text, T: TryFrom<&'text str>>(text: &'text str) -> T {
    T::try_from(text).unwrap_or_else(|_| panic!("{text} is short"))
}

/// Frames that say nothing, and why.
fn refused() -> Vec<(&'static str, Vec<u8>)> {
    let stuffed = |plain: &[u8]| {
        let mut content = plain.to_vec();
        content.extend(checksum(plain).to_le_bytes());
        assert!(content.len() < 254);
        let blocks = content.split(|&byte| byte == 0);
        let mut frame: Vec<u8> = blocks.flat_map(|block| [&[block.len() as u8 + 1], block].concat()).collect();
        frame.push(0);
        frame
    };
    let pause = frame(&Request { id: 0x1234, command: LinkCommand::Pause });
    let mut flipped = pause.clone();
    flipped[3] ^= 1;
    let cut = [&pause[..5], &[0]].concat();
    let doubled = [&pause[..pause.len() - 1], &pause[..]].concat();
    vec![
        ("one bit of the message flipped: the CRC does not fit", flipped),
        ("the second half lost", cut),
        ("the zero between two frames lost", doubled),
        ("of version 1", stuffed(&[1, 0xB4, 0x24, 1])),
        ("no request has the number 99", stuffed(&[VERSION, 0xB4, 0x24, 99])),
        ("a byte too many after the message", stuffed(&[VERSION, 0xB4, 0x24, 1, 0])),
        ("a message that ends early", stuffed(&[VERSION, 0xB4, 0x24, 4, 0])),
        ("longer than any frame", [vec![7; 200], vec![0]].concat()),
    ]
}

fn vectors() -> Value {
    let refused: Vec<_> =
        refused().into_iter().map(|(why, frame)| json!({ "frame_hex": hex(&frame), "why": why })).collect();
    json!({
        "protocol_version": VERSION,
        "requests": requests().iter().map(vector).collect::<Vec<_>>(),
        "reports": reports().iter().map(vector).collect::<Vec<_>>(),
        "refused_requests": refused,
    })
}

fn received<M: DeserializeOwned>(frame: &[u8]) -> Vec<Result<M, FrameError>> {
    let mut decoder = Decoder::new();
    frame.iter().filter_map(|&byte| decoder.push(byte)).collect()
}

#[test]
#[ignore = "writes docs/figures/protocol-vectors.json anew"]
fn write_vectors() {
    std::fs::write(docs("figures/protocol-vectors.json"), format!("{:#}\n", vectors())).expect("writes");
}

#[test]
fn the_vectors_are_what_the_core_sends_and_takes() {
    let text = std::fs::read_to_string(docs("figures/protocol-vectors.json")).expect("the vectors are there");
    let file: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(file, vectors(), "a message has changed: see this file's head");
    let frames = |name: &str| -> Vec<Vec<u8>> {
        let list = file[name].as_array().expect("a list").iter();
        list.map(|vector| bytes(vector["frame_hex"].as_str().expect("text"))).collect()
    };
    let taken: Vec<_> = frames("requests").iter().flat_map(|frame| received(frame)).collect();
    assert_eq!(taken, requests().into_iter().map(Ok).collect::<Vec<_>>());
    let taken: Vec<_> = frames("reports").iter().flat_map(|frame| received(frame)).collect();
    assert_eq!(taken, reports().into_iter().map(Ok).collect::<Vec<_>>());
    for frame in frames("refused_requests") {
        let taken = received::<Request>(&frame);
        assert!(taken.len() == 1 && taken[0].is_err(), "{taken:?}");
    }
}

#[test]
fn python_reads_and_writes_the_same_where_it_is_there() {
    let Ok(output) = Command::new("python3").arg("-B").arg(docs("protocol.py")).output() else {
        println!("no python3 here: nothing to compare with");
        return;
    };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let count = requests().len() + reports().len() + refused().len();
    let told = format!("{count} vectors hold");
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), told);
    let page = std::fs::read_to_string(docs("protocol.md")).expect("the page is there");
    assert!(page.contains(&told), "docs/protocol.md shows another number than: {told}");
}
