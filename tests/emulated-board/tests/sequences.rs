//! Every built-in sequence on the firmware's own ELF with the simulated finger; and the core on the host, fed with what
//! the ELF's converter delivered, decides the same in every tick.

use emulated_board::{Bench, firmware_elf};
use finger_drivers::bf350::{Bf350, BridgeLaw, NOMINAL_TABLE};
use finger_drivers::ise30a::{AnalogueLaw, Ise30a};
use model_core::actuation::Actuation;
use model_core::calibration;
use model_core::controller::{Command, Controller, Inputs};
use model_core::protocol::{LinkCommand, LinkMode, Report, SequenceName, outputs_of};
use model_core::sequence::{Sequence, library};
use model_core::units::{Millis, Pressure};

/// Scans in a control tick.
const SCANS: usize = 16;

fn run(sequence: &'static Sequence, seed: u64) -> Bench {
    let elf = firmware_elf().expect("built");
    let mut bench = Bench::with_seed(&elf, seed).expect("starts");
    bench.ready().expect("passes its self test");
    bench.start(sequence.name).expect("taken");
    bench
}

#[test]
fn every_sequence_stays_within_its_limits_and_ends_vented() {
    // Two at a time: each has its own board.
    let halves: Vec<Vec<&'static Sequence>> =
        (0..2).map(|half| library::ALL.iter().copied().skip(half).step_by(2).collect()).collect();
    std::thread::scope(|scope| {
        for half in halves {
            scope.spawn(move || half.into_iter().for_each(sequence_is_safe));
        }
    });
}

fn sequence_is_safe(sequence: &'static Sequence) {
    let mut bench = run(sequence, 5);
    // Repeats do the same again: one minute shows it.
    let duration = sequence.duration().0.min(60_000);
    let mut peak = 0.0_f64;
    let (mut error, mut held) = (0.0, 0_u32);
    for _ in 0..duration {
        bench.run_ms(1).expect("runs");
        let chambers = bench.plant.truth().chambers_kpa;
        peak = chambers.into_iter().fold(peak, f64::max);
        if let Some(telemetry) = bench.telemetry.last()
            && telemetry.holding
        {
            let setpoints = telemetry.setpoints.map(|bits| Pressure::from_bits(bits).to_f64());
            error += chambers.iter().zip(setpoints).map(|(is, should)| (is - should).abs()).sum::<f64>() / 3.0;
            held += 1;
        }
    }
    let ended = bench.telemetry.last().map(|telemetry| telemetry.mode);
    assert!(peak < 160.0, "{}: {peak} kPa", sequence.name);
    assert!(!matches!(ended, Some(LinkMode::Faulted(_)) | None), "{}: {ended:?}", sequence.name);
    let mean = error / f64::from(held.max(1));
    println!("{:<16} highest {peak:6.1} kPa, mean error while the reference rests {mean:5.2} kPa", sequence.name);
    // The settling at the start of each hold is in it.
    assert!(mean < 8.0, "{}: {mean} kPa", sequence.name);
    bench.ask(&LinkCommand::Vent).expect("answers");
    bench.run_ms(5000).expect("runs");
    assert!(bench.plant.truth().chambers_kpa.iter().all(|&kpa| kpa < 2.0), "{}", sequence.name);
    assert_eq!(outputs_of(&bench.actuation()), 0);
    let last = bench.telemetry.last().expect("telemetry");
    assert_eq!((last.mode, last.overruns, last.dropped_frames), (LinkMode::Vented, 0, 0), "{}", sequence.name);
    assert!(bench.damaged.is_empty());
}

/// The self test is over by then.
const READY_MS: u32 = 3000;

/// What the converter delivered for a tick, and what the pins did after it.
struct Tick {
    inputs: Inputs,
    pins: Actuation,
}

/// Runs a sequence on the ELF; returns every tick, and between which of them the request was taken.
fn record(name: &str, milliseconds: u32) -> (Vec<Tick>, std::ops::Range<usize>) {
    let mut bench = Bench::with_seed(&firmware_elf().expect("built"), 7).expect("starts");
    let bend = Bf350::new(BridgeLaw::NOMINAL, NOMINAL_TABLE);
    let (mut scans, mut ticks, mut taken) = (Vec::new(), Vec::new(), 0..0);
    for millisecond in 0..milliseconds {
        if millisecond == READY_MS {
            bench.request(LinkCommand::Run(SequenceName::try_from(name).expect("short")));
            taken.start = ticks.len();
        }
        bench.run_ms(1).expect("runs");
        scans.extend(bench.board.take_converted());
        // Sixteen scans are a tick; a part of one stays for the next round.
        while scans.len() >= SCANS {
            let sums = scans
                .drain(..SCANS)
                .fold([0_u32; 2], |[p, b], [code_p, code_b]: [u16; 2]| [p + u32::from(code_p), b + u32::from(code_b)]);
            let inputs = Inputs {
                now: Millis(ticks.len() as u32),
                manifold: Ise30a::new(AnalogueLaw::NOMINAL).reading(sums[0], SCANS as u32),
                bend: bend.reading(sums[1], SCANS as u32),
                over_pressure_switch: false,
                emergency_stop: false,
                host_heard: true,
                overrun: false,
            };
            ticks.push(Tick { inputs, pins: bench.actuation() });
        }
        if taken.end == 0 && bench.answers.iter().any(|answer| matches!(answer, Report::Ack { .. })) {
            taken.end = ticks.len();
        }
    }
    (ticks, taken)
}

/// The first tick after which core and pins differ, when the core takes the command after tick `taken`.
fn first_difference(ticks: &[Tick], sequence: &'static Sequence, taken: usize) -> Option<usize> {
    let mut core = Controller::with_self_test([calibration::DEFAULT; 3]);
    ticks.iter().enumerate().position(|(index, tick)| {
        let decided = core.step(&tick.inputs).actuation;
        if index == taken {
            core.command(Command::Run(sequence)).expect("no fault");
        }
        decided != tick.pins
    })
}

#[test]
fn the_elf_and_the_core_on_the_host_decide_the_same_in_every_tick() {
    for name in ["reconfigure", "grasp"] {
        let sequence = library::find(name).expect("built in");
        let (ticks, taken) = record(name, 11_000);
        assert!(ticks.len() >= 10_999 && !taken.is_empty(), "{name}: {} ticks, {taken:?}", ticks.len());
        assert!(ticks.iter().any(|tick| tick.pins.pump));
        // In which of these ticks the firmware takes the request is all that the host cannot know.
        let differences: Vec<_> = taken.map(|tick| first_difference(&ticks, sequence, tick)).collect();
        assert!(differences.contains(&None), "{name}: {differences:?} of {} ticks", ticks.len());
    }
}

#[test]
fn one_seed_gives_one_run() {
    let program = host_sim::simulate::Program::Setpoints([20, 0, 10].map(Pressure::from_kpa));
    let run = host_sim::simulate::Run::new(program, 11);
    let traces = [(); 2].map(|()| emulated_board::simulate::on_elf(&run, &mut |_, _| {}).expect("runs"));
    let [one, other] = traces.map(|trace| format!("{:?}", trace.samples));
    assert!(one == other && one.contains("Holding"));
}
