//! What the corpora begin with: every message as it is really encoded, damaged in ways that lines damage, and sessions that
//! reach every mode.

use crate::reference::framed;
use model_core::actuation::Segment;
use model_core::protocol::{LinkCommand, MAX_FRAME, Request, SequenceName, encode};

/// A seed's file name and bytes.
pub type Seed = (String, Vec<u8>);

/// One request of every kind.
#[must_use]
pub fn commands() -> Vec<(&'static str, LinkCommand)> {
    let run = |name: &str| LinkCommand::Run(SequenceName::try_from(name).unwrap_or_default());
    vec![
        ("run", run("reconfigure")),
        ("run-longest-name", run("abcdefghijklmnopqrstuvwx")),
        ("pause", LinkCommand::Pause),
        ("resume", LinkCommand::Resume),
        ("vent", LinkCommand::Vent),
        ("setpoints", LinkCommand::Setpoints([60 << 16, 30 << 16, 60 << 16])),
        ("setpoints-widest", LinkCommand::Setpoints([i32::MIN; 3])),
        ("zero-sensors", LinkCommand::ZeroSensors),
        ("calibrate", LinkCommand::Calibrate { segment: Segment::Middle, k: 0, c1: 232_121_178, c2: 5_630_601 }),
        ("identify", LinkCommand::Identify),
        ("clear-fault", LinkCommand::ClearFault),
        ("beat", LinkCommand::Beat),
        ("bends", LinkCommand::Bends([45 << 16, 30 << 16, 15 << 16])),
        ("identification", LinkCommand::Identification),
        ("adopt-identified", LinkCommand::AdoptIdentified),
        ("bends-widest", LinkCommand::Bends([i32::MIN; 3])),
        ("identification", LinkCommand::Identification),
        ("adopt-identified", LinkCommand::AdoptIdentified),
    ]
}

fn message(command: &LinkCommand) -> Vec<u8> {
    let mut buffer = [0; MAX_FRAME];
    let request = Request { id: 0x1234, command: command.clone() };
    postcard::to_slice(&request, &mut buffer).map(|bytes| bytes.to_vec()).unwrap_or_default()
}

/// Streams for the decoder.
#[must_use]
pub fn frames() -> Vec<Seed> {
    let mut seeds = Vec::new();
    for (name, command) in commands() {
        let mut buffer = [0; MAX_FRAME];
        let length = encode(&Request { id: 0x1234, command }, &mut buffer).unwrap_or(0);
        let frame = buffer[..length].to_vec();
        let mut flipped = frame.clone();
        flipped[length / 2] ^= 0x10;
        let mut cut = frame[..length / 2].to_vec();
        cut.push(0);
        cut.extend(&frame);
        let mut joined = frame[..length - 1].to_vec();
        joined.extend(&frame);
        let damaged = [("flipped", flipped), ("cut", cut), ("joined", joined)];
        seeds.extend(damaged.map(|(how, bytes)| (format!("{name}-{how}"), bytes)));
        seeds.push((name.to_owned(), frame));
    }
    // Another version, too long, nothing but zeros, full blocks of COBS.
    let mut other = framed(&[1]);
    other[1] = 0;
    seeds.push(("other-version".to_owned(), other));
    seeds.push(("too-long".to_owned(), [vec![7; MAX_FRAME + 1], vec![0]].concat()));
    seeds.push(("longest".to_owned(), [vec![7; MAX_FRAME], vec![0]].concat()));
    seeds.push(("zeros".to_owned(), vec![0; 9]));
    seeds.push(("full-block".to_owned(), [vec![255; 255], vec![0]].concat()));
    seeds
}

/// Messages for the decoder, without frames.
#[must_use]
pub fn messages() -> Vec<Seed> {
    let whole = commands().into_iter().map(|(name, command)| (name.to_owned(), message(&command)));
    let mut seeds: Vec<Seed> = whole.collect();
    // Varints that are longer than they need be, or than they may be; a name that is no text; a length past the end.
    seeds.push(("padded-varint".to_owned(), vec![0x80, 0x80, 0x00, 0x03]));
    seeds.push(("endless-varint".to_owned(), vec![0xFF; 12]));
    seeds.push(("no-text".to_owned(), vec![1, 0, 2, 0xC3, 0x28]));
    seeds.push(("length-past-end".to_owned(), vec![1, 0, 24, b'a']));
    seeds
}

/// Sessions; [`crate::session`] reads them.
#[must_use]
pub fn sessions() -> Vec<Seed> {
    const WAIT_5_S: [u8; 2] = [12, 250];
    let number = |kpa: i16| (kpa * 128).to_le_bytes();
    let setpoints = |kpa: [i16; 3]| [vec![4], kpa.map(number).concat()].concat();
    let run = |index: u8| vec![0, index];
    let wait = |ticks: u8| vec![11, ticks];
    let long = |twenties: u8| vec![12, twenties];
    let mut seeds = Vec::new();
    let mut add = |name: &str, start: u8, parts: &[Vec<u8>]| {
        seeds.push((name.to_owned(), [&[start], parts.concat().as_slice()].concat()));
    };
    add("self-test-then-run", 1, &[WAIT_5_S.to_vec(), run(7), WAIT_5_S.to_vec()]);
    add("self-test-refuses", 1, &[wait(200), run(7), setpoints([30, 30, 30]), vec![6], vec![5], wait(1)]);
    add("setpoints", 0, &[long(50), setpoints([60, 30, 60]), WAIT_5_S.to_vec(), vec![3], long(100)]);
    add("setpoints-out-of-limits", 0, &[long(50), setpoints([151, 0, 0]), setpoints([0, -1, 0]), wait(9)]);
    let bends = |deg: [i16; 3]| [vec![16], deg.map(number).concat()].concat();
    add(
        "bends",
        0,
        &[long(50), bends([45, 30, 15]), WAIT_5_S.to_vec(), bends([111, 0, 0]), bends([10, 20, 110]), long(100)],
    );
    add("pause-and-resume", 0, &[long(50), run(0), long(50), vec![1], long(50), vec![2], long(50), vec![3], wait(9)]);
    add(
        "emergency-stop",
        0,
        &[
            setpoints([90, 90, 90]),
            long(50),
            vec![15, 1],
            wait(9),
            run(1),
            vec![8, 15, 0],
            wait(0),
            vec![8],
            wait(9),
            run(1),
            wait(9),
        ],
    );
    add("switch", 0, &[setpoints([90, 90, 90]), long(50), vec![15, 2], wait(9), vec![19], wait(9), vec![8], wait(9)]);
    add("late-ticks", 0, &[run(3), long(20), vec![15, 4], wait(50), vec![19], long(60), vec![8], wait(9)]);
    add(
        "silent-host",
        0,
        &[setpoints([50, 60, 70]), vec![15, 8], WAIT_5_S.to_vec(), vec![19], vec![9], vec![8], wait(9)],
    );
    for (name, kind) in [("below-range", 1), ("above-range", 2)] {
        add(
            name,
            0,
            &[setpoints([80, 0, 80]), long(50), vec![13, kind], wait(20), vec![19], long(60), vec![8], wait(9)],
        );
        add(
            &format!("bend-{name}"),
            0,
            &[setpoints([80, 0, 80]), long(50), vec![14, kind], long(20), vec![19], long(9), vec![8], wait(9)],
        );
    }
    for (name, kpa) in [("stuck-at-zero", 0_i16), ("stuck-at-50", 50), ("stuck-over-limit", 180), ("vacuum", -90)] {
        let [low, high] = kpa.to_le_bytes();
        add(
            name,
            0,
            &[
                setpoints([60, 30, 60]),
                long(50),
                vec![13, 3, low, high],
                long(150),
                vec![19],
                long(150),
                vec![8],
                wait(9),
            ],
        );
        add(&format!("self-test-{name}"), 1, &[vec![13, 3, low, high], long(250), vec![19], vec![8], long(250)]);
    }
    let calibrate =
        |k: i16, c1: i16, c2: i16| [vec![6, 1], [k, c1, c2].map(|kpa| (kpa * 512).to_le_bytes()).concat()].concat();
    add("calibrate", 0, &[wait(1), calibrate(35, 7, 1), run(9), long(100), calibrate(0, 14, 0), vec![5], wait(1)]);
    add(
        "zero-sensors",
        0,
        &[vec![13, 4, 40, 0, 14, 4, 100, 0], long(30), vec![5], long(30), vec![13, 3, 3, 0], wait(0), vec![5]],
    );
    let calibrates = run(library_index("calibrate"));
    let fifteen_s = WAIT_5_S.repeat(3);
    add("identify", 0, &[long(50), calibrates, fifteen_s, vec![17], vec![3], long(50), vec![18], wait(1)]);
    add(
        "noise-on-the-line",
        0,
        &[vec![10, 15, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 0], vec![3], wait(9), vec![10, 4, 255, 0, 1, 0]],
    );
    seeds
}

fn library_index(name: &str) -> u8 {
    model_core::sequence::library::ALL.iter().position(|sequence| sequence.name == name).unwrap_or(0) as u8
}
