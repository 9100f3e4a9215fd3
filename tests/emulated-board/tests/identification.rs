//! One calibration on the ELF: the sequence, what it identified, adopting it, and bends with it after a restart.

use emulated_board::{Bench, firmware_elf};
use host_sim::plant::{PlantParameters, Scene};
use model_core::protocol::{IdentifiedSegment, LinkCommand, LinkMode, Reason, Report, SequenceName};

/// k, c1, c2 in kPa: a bare chamber, one between, one with a stiffer exoskeleton.
const FINGER_KPA: [[f64; 3]; 3] = [[35.3, 7.24, 0.831], [10.0, 11.0, 0.5], [0.0, 16.0, 0.25]];

fn identified(bench: &mut Bench) -> [IdentifiedSegment; 3] {
    match bench.ask(&LinkCommand::Identification).expect("answers") {
        Report::Identification { segments, .. } => segments,
        other => panic!("{other:?}"),
    }
}

fn in_use(bench: &mut Bench) -> [[i32; 3]; 3] {
    match bench.ask(&LinkCommand::Identify).expect("answers") {
        Report::Identity(identity) => identity.coefficients,
        other => panic!("{other:?}"),
    }
}

#[test]
fn one_calibration_is_identified_adopted_kept_and_bends_by_it() {
    let elf = firmware_elf().expect("built");
    let mut parameters = PlantParameters::default();
    parameters.finger.coefficients_kpa = FINGER_KPA;
    parameters.bend_sensor.gain_error = 0.0;
    let mut bench = Bench::new(&elf, parameters, Scene::default(), 1).expect("starts");
    bench.ready().expect("passes its self test");
    let nothing = bench.ask(&LinkCommand::AdoptIdentified).expect("answers");
    assert!(matches!(nothing, Report::Nack { reason: Reason::NothingIdentified, .. }), "{nothing:?}");
    // Empty for long enough to be known to be.
    bench.run_ms(2000).expect("runs");
    let calibrate = SequenceName::try_from("calibrate").expect("short");
    bench.take(&LinkCommand::Run(calibrate)).expect("taken");
    bench.run_ms(60_000).expect("runs");
    assert_eq!(bench.telemetry.last().expect("telemetry").mode, LinkMode::Vented);
    let found = identified(&mut bench);
    for segment in &found {
        println!("{segment:?}");
        assert!(segment.ready && segment.points >= 15, "{segment:?}");
    }
    bench.take(&LinkCommand::AdoptIdentified).expect("taken");
    assert_eq!(in_use(&mut bench), found.map(|segment| segment.coefficients));

    // A minute's hold by hand would need the host's beat; here every request is one.
    bench.take(&LinkCommand::Bends([60 << 16; 3])).expect("taken");
    for _ in 0..12 {
        bench.run_ms(500).expect("runs");
        bench.take(&LinkCommand::Beat).expect("taken");
    }
    for bend in bench.plant.truth().bends_deg {
        assert!((bend - 60.0).abs() <= 1.0, "{bend} degrees where 60 were asked for");
    }

    // What was adopted is in the flash.
    let flash = bench.board.settings().to_vec();
    let mut again = Bench::with_settings(&elf, 1, flash).expect("starts");
    again.ready().expect("passes its self test");
    assert_eq!(in_use(&mut again), found.map(|segment| segment.coefficients));
}
