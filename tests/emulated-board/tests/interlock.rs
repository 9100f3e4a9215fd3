//! Nothing that fails leaves the finger pressurised: emergency stop, pressure switch, hung code, restarts.

use emulated_board::bench::{START, STOP, SWITCH};
use emulated_board::time::MICROSECOND;
use emulated_board::{Bench, Halt, ResetCause, firmware_elf};
use host_sim::plant::{FaultKind, InjectedFault, PlantParameters, Scene};
use model_core::actuation::{Actuation, Passage, Segment};
use model_core::controller::Fault;
use model_core::protocol::{LinkCommand, LinkMode, Reason, Report, SequenceName};
use model_core::self_test::Part;

/// A bench in the hold of `all`, every chamber above 140 kPa.
fn pressurised() -> Bench {
    let mut bench = Bench::with_seed(&firmware_elf().expect("built"), 3).expect("starts");
    bench.ready().expect("passes its self test");
    bench.start("all").expect("taken");
    bench.run_ms(5000).expect("runs");
    assert!(bench.plant.truth().chambers_kpa.iter().all(|&kpa| kpa > 140.0), "{:?}", bench.plant.truth());
    assert_ne!(bench.actuation(), Actuation::SAFE);
    bench
}

/// Every coil rests until every chamber is at atmosphere, which is soon.
fn vents(bench: &mut Bench) {
    let mut milliseconds = 0;
    while bench.plant.truth().chambers_kpa.iter().any(|&kpa| kpa > 5.0) {
        bench.step().expect("goes on");
        assert_eq!(bench.actuation(), Actuation::SAFE);
        milliseconds += 1;
        assert!(milliseconds < 2500, "{:?}", bench.plant.truth());
    }
}

/// After a restart that nobody wanted the finger stays vented, with this fault, until it is cleared; then the self test of
/// the new start passes, and nothing runs by itself after it.
fn comes_up(bench: &mut Bench, fault: Option<Fault>) {
    bench.telemetry.clear();
    if let Some(fault) = fault {
        bench.run_ms(500).expect("runs");
        let told = bench.telemetry.last().expect("telemetry");
        assert_eq!(told.mode, LinkMode::Faulted(fault.code()));
        assert_eq!((told.faults, told.priority), (1 << fault.code(), fault.priority() as u8 + 1));
        assert_eq!(bench.actuation(), Actuation::SAFE);
        bench.take(&LinkCommand::ClearFault).expect("cleared");
        bench.telemetry.clear();
    }
    bench.ready().expect("passes its self test");
    bench.run_ms(1000).expect("runs");
    assert_eq!(bench.actuation(), Actuation::SAFE);
    assert_eq!(bench.telemetry.last().expect("telemetry").mode, LinkMode::Vented);
}

#[test]
fn the_interlock_rests_every_coil_within_100_us_at_any_moment_of_a_tick() {
    let mut worst = [0.0_f64; 2];
    for (index, (pin, fault)) in
        [(STOP, Fault::EmergencyStop), (SWITCH, Fault::OverPressureSwitch)].into_iter().enumerate()
    {
        let mut bench = pressurised();
        for moment in 0..40 {
            // Spread over the tick, so that the control task is met in every part of its work.
            let settle = bench.board.time() + moment * 25 * MICROSECOND;
            assert_eq!(bench.board.run_until(settle).expect("runs"), None);
            if bench.actuation() == Actuation::SAFE {
                bench.start("all").expect("taken");
                bench.run_ms(60).expect("runs");
            }
            worst[index] = worst[index].max(bench.rest_latency_us(pin).expect("rests"));
            // The tick after it cannot undo it, nor can one after the release.
            bench.run_ms(5).expect("runs");
            assert_eq!(bench.actuation(), Actuation::SAFE);
            bench.run_ms(20).expect("runs");
            let mode = bench.telemetry.last().expect("telemetry").mode;
            assert_eq!(mode, LinkMode::Faulted(fault.code()));
            bench.take(&LinkCommand::ClearFault).expect("cleared");
        }
    }
    println!("emergency stop {:.2} us, pressure switch {:.2} us at the worst", worst[0], worst[1]);
    assert!(worst.iter().all(|&us| us <= 100.0), "{worst:?}");
}

#[test]
fn a_stop_that_stays_pressed_cannot_be_cleared() {
    let mut bench = pressurised();
    bench.stop_pressed = true;
    vents(&mut bench);
    let answer = bench.ask(&LinkCommand::ClearFault).expect("answers");
    assert!(matches!(answer, Report::Nack { reason: Reason::CauseStillPresent, .. }), "{answer:?}");
    bench.stop_pressed = false;
    bench.run_ms(50).expect("runs");
    bench.take(&LinkCommand::ClearFault).expect("cleared");
    bench.run_ms(50).expect("runs");
    assert_eq!(bench.telemetry.last().expect("telemetry").mode, LinkMode::Vented);
}

/// Steps until the board is reset; returns why and after how many milliseconds.
fn until_reset(bench: &mut Bench, limit_ms: u32) -> (ResetCause, u32) {
    for waited in 1..=limit_ms {
        if let Some(Halt::Reset(cause)) = bench.step().expect("goes on") {
            return (cause, waited);
        }
    }
    panic!("no reset within {limit_ms} ms");
}

#[test]
fn hung_code_is_reset_by_the_watchdog_and_comes_up_vented() {
    // At ten moments of a tick: asleep, in a task, in an interrupt.
    for moment in 0..10 {
        let mut bench = pressurised();
        let then = bench.board.time() + moment * 100 * MICROSECOND;
        assert_eq!(bench.board.run_until(then).expect("runs"), None);
        bench.board.hang().expect("hangs");
        let (cause, waited) = until_reset(&mut bench, 110);
        assert_eq!(cause, ResetCause::Watchdog);
        vents(&mut bench);
        assert!(bench.board.log_lines().iter().any(|line| line.contains("watchdog")));
        println!("moment {moment}: reset {waited} ms after the hang");
        if moment == 0 {
            comes_up(&mut bench, Some(Fault::TaskHang));
        }
    }
}

#[test]
fn a_converter_that_stops_is_noticed_by_the_core_and_by_the_watchdog() {
    let mut bench = pressurised();
    bench.board.stop_conversions();
    // The core takes missing samples for a failed sensor after its five ticks, late as they are.
    bench.run_ms(25).expect("runs");
    assert_eq!(bench.actuation(), Actuation::SAFE);
    let (cause, _) = until_reset(&mut bench, 110);
    assert_eq!(cause, ResetCause::Watchdog);
    vents(&mut bench);
}

#[test]
fn a_hard_fault_rests_every_coil_and_restarts() {
    let mut bench = pressurised();
    bench.board.jump("HardFault").expect("jumps");
    let start = bench.board.time();
    let halt = bench.board.run_until(start + 1000 * MICROSECOND).expect("runs");
    assert_eq!(halt, Some(Halt::Reset(ResetCause::Software)));
    assert_eq!(bench.actuation(), Actuation::SAFE, "before the reset lets the pins go");
    bench.board.reset(ResetCause::Software).expect("restarts");
    vents(&mut bench);
    assert!(bench.board.log_lines().iter().any(|line| line.contains("by the firmware itself")));
}

#[test]
fn a_restart_in_mid_sequence_comes_up_vented_and_says_why() {
    for (cause, words, fault) in [
        (ResetCause::Brownout, "brown-out", Some(Fault::PowerDip)),
        (ResetCause::Pin, "reset pin", None),
        (ResetCause::PowerOn, "power", None),
    ] {
        let mut bench = pressurised();
        bench.board.log_lines();
        bench.board.reset(cause).expect("restarts");
        assert_eq!(bench.actuation(), Actuation::SAFE);
        vents(&mut bench);
        let lines = bench.board.log_lines();
        assert!(lines.iter().any(|line| line.contains(words)), "{lines:?}");
        comes_up(&mut bench, fault);
    }
}

#[test]
fn a_part_that_does_not_respond_is_named_and_keeps_the_finger_vented() {
    let part = Part::SegmentValve(Segment::Middle);
    let stuck = FaultKind::SegmentValveStuck(Segment::Middle, Passage::Closed);
    let scene = Scene::default().with_faults([InjectedFault::lasting(stuck, 0)]);
    let elf = firmware_elf().expect("built");
    let mut bench = Bench::new(&elf, PlantParameters::default(), scene, 1).expect("starts");
    bench.run_ms(4000).expect("runs");
    let mode = bench.telemetry.last().expect("telemetry").mode;
    assert_eq!(mode, LinkMode::Faulted(Fault::SelfTest(part).code()));
    assert_eq!(bench.actuation(), Actuation::SAFE);
    let name = SequenceName::try_from("all").expect("short");
    let answer = bench.ask(&LinkCommand::Run(name)).expect("answers");
    assert!(matches!(answer, Report::Nack { reason: Reason::Faulted, .. }), "{answer:?}");
}

#[test]
fn the_start_button_starts_and_stops() {
    let mut bench = Bench::with_seed(&firmware_elf().expect("built"), 4).expect("starts");
    bench.ready().expect("passes its self test");
    let press = |bench: &mut Bench| {
        bench.board.wire(START, false);
        bench.run_ms(50).expect("runs");
        bench.board.wire(START, true);
        bench.run_ms(50).expect("runs");
        bench.telemetry.last().expect("telemetry").mode
    };
    assert_eq!(press(&mut bench), LinkMode::Running);
    bench.run_ms(1000).expect("runs");
    assert_eq!(press(&mut bench), LinkMode::Vented);
}
