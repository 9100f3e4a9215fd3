//! The host's link on the ELF: every command taken and refused, and no damage that is taken for a command.

use emulated_board::{Bench, firmware_elf};
use model_core::actuation::{Actuation, Segment};
use model_core::protocol::{LinkCommand, LinkMode, MAX_FRAME, Reason, Report, Request, SequenceName, encode};

fn bench() -> Bench {
    let mut bench = Bench::with_seed(&firmware_elf().expect("built"), 2).expect("starts");
    bench.ready().expect("passes its self test");
    bench
}

fn run(name: &str) -> LinkCommand {
    LinkCommand::Run(SequenceName::try_from(name).expect("short"))
}

fn kpa(value: i32) -> i32 {
    value << 16
}

fn refused(bench: &mut Bench, command: &LinkCommand, reason: Reason) {
    let answer = bench.ask(command).expect("answers");
    assert!(matches!(answer, Report::Nack { reason: other, .. } if other == reason), "{command:?}: {answer:?}");
}

fn mode(bench: &mut Bench) -> LinkMode {
    bench.run_ms(30).expect("runs");
    bench.telemetry.last().expect("telemetry").mode
}

#[test]
fn every_command_is_taken_and_refused_for_its_reason() {
    let mut bench = bench();
    let calibrate = |k: i32| LinkCommand::Calibrate { segment: Segment::Middle, k: k << 24, c1: 14 << 24, c2: 1 << 23 };
    refused(&mut bench, &run("no such sequence"), Reason::UnknownSequence);
    refused(&mut bench, &LinkCommand::Pause, Reason::NotRunning);
    refused(&mut bench, &LinkCommand::Resume, Reason::NotPaused);
    refused(&mut bench, &LinkCommand::Setpoints([kpa(10), kpa(151), 0]), Reason::SetpointOutOfLimits);
    refused(&mut bench, &LinkCommand::Bends([0, 0, 111 << 16]), Reason::SetpointOutOfLimits);
    refused(&mut bench, &LinkCommand::ClearFault, Reason::NoFault);
    refused(&mut bench, &calibrate(61), Reason::CoefficientOutOfLimits);
    bench.take(&LinkCommand::ZeroSensors).expect("taken");
    bench.take(&calibrate(2)).expect("taken");
    match bench.ask(&LinkCommand::Identify).expect("answers") {
        Report::Identity(identity) => assert_eq!(identity.coefficients[1], [2 << 24, 14 << 24, 1 << 23]),
        other => panic!("{other:?}"),
    }
    bench.take(&run("all")).expect("taken");
    bench.run_ms(500).expect("runs");
    refused(&mut bench, &LinkCommand::ZeroSensors, Reason::NotVented);
    refused(&mut bench, &calibrate(2), Reason::NotVented);
    bench.take(&LinkCommand::Pause).expect("taken");
    assert_eq!(mode(&mut bench), LinkMode::Paused);
    bench.take(&LinkCommand::Resume).expect("taken");
    assert_eq!(mode(&mut bench), LinkMode::Running);
    bench.take(&LinkCommand::Setpoints([kpa(60), kpa(30), kpa(60)])).expect("taken");
    assert_eq!(mode(&mut bench), LinkMode::Holding);
    // A host that drives by hand has to be heard each second.
    for _ in 0..8 {
        bench.run_ms(500).expect("runs");
        bench.take(&LinkCommand::Beat).expect("taken");
    }
    for (is, should) in bench.plant.truth().chambers_kpa.into_iter().zip([60.0, 30.0, 60.0]) {
        assert!((is - should).abs() < 3.0, "{is} where {should} kPa should be");
    }
    bench.stop_pressed = true;
    bench.run_ms(20).expect("runs");
    for command in [run("all"), LinkCommand::Setpoints([0; 3]), LinkCommand::ZeroSensors, calibrate(2)] {
        refused(&mut bench, &command, Reason::Faulted);
    }
    refused(&mut bench, &LinkCommand::ClearFault, Reason::CauseStillPresent);
    bench.take(&LinkCommand::Vent).expect("taken");
    bench.stop_pressed = false;
    bench.run_ms(3000).expect("runs");
    bench.take(&LinkCommand::ClearFault).expect("taken");
    assert_eq!(mode(&mut bench), LinkMode::Vented);
    assert_eq!(bench.telemetry.last().expect("telemetry").dropped_frames, 0);
}

#[test]
fn telemetry_comes_a_hundred_times_a_second_in_step() {
    let mut bench = bench();
    bench.telemetry.clear();
    bench.run_ms(5000).expect("runs");
    assert!((499..=501).contains(&bench.telemetry.len()), "{}", bench.telemetry.len());
    for pair in bench.telemetry.windows(2) {
        assert_eq!(pair[1].tick - pair[0].tick, 10);
    }
    assert!(bench.damaged.is_empty());
}

#[test]
fn no_damaged_truncated_or_flooding_frame_moves_anything() {
    let mut bench = bench();
    let mut damaged = 0_u16;
    let commands = [
        run("all"),
        LinkCommand::Pause,
        LinkCommand::Resume,
        LinkCommand::Vent,
        LinkCommand::Setpoints([kpa(150); 3]),
        LinkCommand::ZeroSensors,
        LinkCommand::Calibrate { segment: Segment::Middle, k: 1, c1: 9 << 24, c2: 1 },
        LinkCommand::Identify,
        LinkCommand::ClearFault,
    ];
    for command in commands {
        let mut buffer = [0; MAX_FRAME];
        let length = encode(&Request { id: 700, command }, &mut buffer).expect("fits");
        let frame = &buffer[..length];
        for bit in 0..8 * length {
            let mut copy = frame.to_vec();
            copy[bit / 8] ^= 1 << (bit % 8);
            copy.push(0);
            bench.board.send(&copy);
            // Long enough for the bytes and for the line's silence after them.
            bench.run_ms(3).expect("runs");
            damaged += 1;
        }
        for cut in 1..length - 1 {
            let mut copy = frame[..cut].to_vec();
            copy.push(0);
            bench.board.send(&copy);
            bench.run_ms(3).expect("runs");
            damaged += 1;
        }
    }
    bench.board.send(&vec![0x55; 20_000]);
    bench.run_ms(1000).expect("runs through the flood");
    bench.board.send(&[0]);
    bench.run_ms(50).expect("runs");
    assert_eq!(bench.answers, []);
    assert_eq!(bench.actuation(), Actuation::SAFE);
    let last = *bench.telemetry.last().expect("telemetry");
    assert_eq!(last.mode, LinkMode::Vented);
    // Each of them was counted; a flip that made a zero ended two frames.
    assert!(last.dropped_frames > damaged, "{} of {damaged} counted", last.dropped_frames);
    assert_eq!(last.overruns, 0, "the flood did not hold up the control task");
    // And the link still works.
    bench.take(&LinkCommand::Vent).expect("taken");
}
