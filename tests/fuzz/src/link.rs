//! The link under fuzzing. Under `cargo test` each test plays its corpus (`__fuzz__/link__TEST/corpus`), whatever crashed before
//! (`crashes`), and a bounded number of random inputs; docs/testing.md says how to fuzz for longer.

use crate::reference::{Read, framed, read};
use crate::{seeds, session};
use bolero::check;
use model_core::protocol::{Decoder, LinkCommand, MAX_FRAME, Report, Request, encode};
use model_core::supervisor::fault::FaultSet;
use serde::{Serialize, de::DeserializeOwned};
use std::path::{Path, PathBuf};

fn encoded<M: Serialize>(message: &M) -> Vec<u8> {
    let mut buffer = [0; MAX_FRAME];
    let length = encode(message, &mut buffer).expect("every message fits");
    buffer[..length].to_vec()
}

fn decoded(decoder: &mut Decoder, stream: &[u8]) -> Read {
    let outcomes: Vec<_> = stream.iter().filter_map(|&byte| decoder.push::<Request>(byte)).collect();
    Read { requests: outcomes.into_iter().flatten().collect(), dropped: decoder.dropped() }
}

/// Any bytes: the decoder takes what the definition takes and counts what it drops, and is in step after the next zero.
#[test]
fn frames() {
    check!().with_iterations(200_000).for_each(|stream: &[u8]| {
        let mut decoder = Decoder::new();
        assert_eq!(decoded(&mut decoder, stream), read(stream));
        // The zero may yet end a good frame.
        let all = read(&[stream, &[0]].concat());
        let ended = decoded(&mut decoder, &[0]);
        assert_eq!(
            (ended.requests.len(), decoder.dropped()),
            (all.requests.len() - read(stream).requests.len(), all.dropped)
        );
        let follower = Request { id: 1, command: LinkCommand::Vent };
        let after = decoded(&mut decoder, &encoded(&follower));
        assert_eq!(after.requests, [follower]);
    });
}

/// What a whole frame makes of a message's bytes, sent again, is received the same.
fn comes_back<M: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(bytes: &[u8]) {
    let receive = |frame: &[u8]| {
        let mut decoder = Decoder::new();
        frame.iter().find_map(|&byte| decoder.push::<M>(byte))
    };
    if let Some(Ok(message)) = receive(&framed(bytes)) {
        assert_eq!(receive(&encoded(&message)), Some(Ok(message)));
    }
}

/// Any message in a whole frame, as if the line's check had passed it.
#[test]
fn messages() {
    check!().with_iterations(200_000).for_each(|bytes: &[u8]| {
        comes_back::<Request>(bytes);
        comes_back::<Report>(bytes);
    });
}

/// Any commands, at any time, with any readings: [`session`] says what must hold.
#[test]
fn sessions() {
    check!().with_iterations(2_000).for_each(|bytes: &[u8]| {
        let _ = session::play(bytes);
    });
}

fn corpora() -> [(PathBuf, Vec<seeds::Seed>); 3] {
    let folder = |name: &str| {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("src/__fuzz__").join(format!("link__{name}")).join("corpus")
    };
    [
        (folder("frames"), seeds::frames()),
        (folder("messages"), seeds::messages()),
        (folder("sessions"), seeds::sessions()),
    ]
}

/// `cargo test -p finger-fuzz write_seeds -- --ignored`; what fuzzing found stays beside them.
#[test]
#[ignore = "writes the seeds into the corpora"]
fn write_seeds() {
    for (folder, seeds) in corpora() {
        std::fs::create_dir_all(&folder).expect("the crate's folder");
        for (file, bytes) in seeds {
            std::fs::write(folder.join(file), bytes).expect("the corpus");
        }
    }
}

/// The corpora hold today's messages, and their sessions get where they are meant to.
#[test]
fn the_corpora_hold_the_seeds_and_reach_every_part() {
    for (folder, seeds) in corpora() {
        for (file, bytes) in seeds {
            let path = folder.join(file);
            let stored = std::fs::read(&path).unwrap_or_default();
            let write = "cargo test -p finger-fuzz write_seeds -- --ignored";
            assert!(stored == bytes, "{}: not today's, run `{write}`", path.display());
        }
    }
    let (mut faults, mut taken, mut pump_ticks) = (FaultSet::EMPTY, 0, 0);
    for (name, bytes) in seeds::sessions() {
        let reached = session::play(&bytes);
        println!(
            "{name}: {} ticks, {} of {} requests taken, {:?}",
            reached.ticks,
            reached.taken,
            reached.requests,
            reached.faults.iter().collect::<Vec<_>>()
        );
        faults = faults.union(reached.faults);
        taken += reached.taken;
        pump_ticks += reached.pump_ticks;
    }
    assert!(taken > 20 && pump_ticks > 1000 && faults.iter().count() >= 5, "{taken} {pump_ticks} {faults:?}");
}
