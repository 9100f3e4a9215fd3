//! Nothing is energised while the supervisor says safe: every fault and every pair of faults, latched in every mode, with the
//! regulator, the observer and the sequence wherever a random history left them, and with any readings and commands after.

use finger_drivers::coils::Coils;
use finger_drivers::relay::{Coil, Relay, Valve};
use finger_fuzz::session::diagnoses;
use host_sim::plant::{Plant, PlantParameters, Scene};
use model_core::actuation::{Actuation, Segment};
use model_core::calibration;
use model_core::controller::{Command, Controller, Inputs, Mode, Outputs, Reading};
use model_core::sequence::library;
use model_core::supervisor::fault::{Action, Fault, FaultSet};
use model_core::supervisor::table::TABLE;
use model_core::units::{Bend, Millis, Pressure};
use proptest::prelude::*;
use std::cell::Cell;
use std::convert::Infallible;

/// How a controller got where it is.
#[derive(Clone, Debug)]
struct History {
    seed: u64,
    sequence: usize,
    setpoints_kpa: [i16; 3],
    ticks: u32,
}

fn history() -> impl Strategy<Value = History> {
    (any::<u64>(), 0..library::ALL.len(), [0_i16..=150, 0..=150, 0..=150], 1_u32..4000)
        .prop_map(|(seed, sequence, setpoints_kpa, ticks)| History { seed, sequence, setpoints_kpa, ticks })
}

/// Controllers in every mode that is no fault, on the simulated plant, and what each did last.
fn in_every_mode(history: &History) -> [(Controller, Outputs); 5] {
    let live = |mut controller: Controller, commands: &[Command]| {
        let mut plant = Plant::new(PlantParameters::default(), Scene::default(), history.seed);
        let mut outputs = None;
        for &command in commands {
            controller.command(command).expect("taken");
            for _ in 0..history.ticks {
                let done = controller.step(&plant.inputs());
                plant.step(&done.actuation);
                outputs = Some(done);
            }
        }
        (controller, outputs.expect("it has run"))
    };
    let new = || Controller::new([calibration::DEFAULT; 3]);
    let run = Command::Run(library::ALL[history.sequence]);
    let setpoints = Command::Setpoints(history.setpoints_kpa.map(Pressure::from_kpa));
    [
        live(new(), &[setpoints, Command::Vent]),
        live(Controller::with_self_test([calibration::DEFAULT; 3]), &[Command::Vent]),
        live(new(), &[run]),
        live(new(), &[setpoints]),
        live(new(), &[run, Command::Pause]),
    ]
}

/// What may happen in a tick after the fault.
#[derive(Clone, Debug)]
struct After {
    manifold: Reading<i32>,
    bend: Reading<i32>,
    lines: [bool; 4],
    command: Option<Command>,
}

fn after() -> impl Strategy<Value = After> {
    let reading = || {
        prop_oneof![
            1 => Just(Reading::BelowRange),
            1 => Just(Reading::AboveRange),
            4 => any::<i32>().prop_map(Reading::Valid),
            4 => (-10_i32 << 16..200 << 16).prop_map(Reading::Valid),
        ]
    };
    let command = prop_oneof![
        3 => Just(None),
        1 => (0..library::ALL.len()).prop_map(|index| Some(Command::Run(library::ALL[index]))),
        1 => any::<[i32; 3]>().prop_map(|bits| Some(Command::Setpoints(bits.map(Pressure::from_bits)))),
        1 => Just(Some(Command::Setpoints([Pressure::from_kpa(90); 3]))),
        1 => any::<[i32; 3]>().prop_map(|bits| Some(Command::Bends(bits.map(Bend::from_bits)))),
        1 => Just(Some(Command::Bends([Bend::from_deg(60); 3]))),
        1 => Just(Some(Command::Resume)),
        1 => Just(Some(Command::Pause)),
        1 => Just(Some(Command::Vent)),
        1 => Just(Some(Command::ZeroSensors)),
        1 => Just(Some(Command::AdoptIdentified)),
        1 => Just(Some(Command::Calibrate(Segment::Middle, calibration::DEFAULT))),
    ];
    (reading(), reading(), any::<[bool; 4]>(), command).prop_map(|(manifold, bend, lines, command)| After {
        manifold,
        bend,
        lines,
        command,
    })
}

impl After {
    fn inputs(&self, now: u32) -> Inputs {
        let [emergency_stop, over_pressure_switch, host_heard, overrun] = self.lines;
        Inputs {
            now: Millis(now),
            manifold: self.manifold.map(Pressure::from_bits),
            bend: self.bend.map(Bend::from_bits),
            over_pressure_switch,
            emergency_stop,
            host_heard,
            overrun,
        }
    }
}

struct Pin<'a>(&'a Cell<bool>);
impl embedded_hal::digital::ErrorType for Pin<'_> {
    type Error = Infallible;
}
impl embedded_hal::digital::OutputPin for Pin<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(false);
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
}

/// The firmware's driver with its pins: after `before` was driven, and a tick later `now`, is anything energised?
fn any_pin_energised(before: Actuation, now: Actuation) -> bool {
    let pins: [Cell<bool>; 5] = std::array::from_fn(|_| Cell::new(false));
    let coil = |index: usize| Coil::new(Pin(&pins[index]), true);
    let mut coils = Coils {
        pump: Relay::new(coil(0), Millis(5)),
        dump: Valve(coil(1)),
        segments: [Valve(coil(2)), Valve(coil(3)), Valve(coil(4))],
    };
    coils.drive(&before, Millis(0)).expect("never fails");
    coils.drive(&now, Millis(1)).expect("never fails");
    pins.iter().any(Cell::get)
}

/// Latches the faults, and holds every tick after to it. A history that ended in a fault of its own is none of these states.
fn stays_safe(controller: &Controller, last: &Outputs, faults: &[Fault], then: &[After]) -> Result<(), TestCaseError> {
    if matches!(last.mode, Mode::Faulted(_)) {
        return Ok(());
    }
    let mut controller = controller.clone();
    for &fault in faults {
        controller.report(fault);
    }
    let first = faults.iter().copied().find(|fault| fault.action() == Action::Vent);
    let mut latched = faults.iter().fold(FaultSet::EMPTY, |set, &fault| set.union(FaultSet::of(fault)));
    for (tick, after) in then.iter().enumerate() {
        let inputs = after.inputs(tick as u32);
        let outputs = controller.step(&inputs);
        let safe = outputs.actuation == Actuation::SAFE;
        // A diagnosis begins after 400 ticks at atmosphere, at the earliest.
        let vented = safe || tick > 400 && diagnoses(&inputs, &outputs);
        prop_assert!(latched.without(outputs.faults).is_empty(), "{faults:?} lost: {outputs:?}");
        latched = outputs.faults;
        if let Some(first) = first {
            prop_assert!(vented, "{faults:?}, tick {tick}: {outputs:?}");
            prop_assert_eq!(outputs.mode, Mode::Faulted(first));
            prop_assert_eq!(outputs.setpoints, [Pressure::ZERO; 3]);
        } else if outputs.faults.intersects(FaultSet::VENTING) {
            prop_assert!(vented, "{faults:?}, tick {tick}: {outputs:?}");
        }
        if safe {
            prop_assert!(!any_pin_energised(last.actuation, outputs.actuation));
        }
        if let Some(command) = after.command {
            let _ = controller.command(command);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn nothing_is_energised_in_any_faulted_state(history in history(), then in proptest::collection::vec(after(), 8)) {
        for (controller, last) in in_every_mode(&history) {
            for (index, one) in TABLE.iter().enumerate() {
                stays_safe(&controller, &last, &[one.fault], &then)?;
                for other in &TABLE[..index] {
                    stays_safe(&controller, &last, &[one.fault, other.fault], &then)?;
                    stays_safe(&controller, &last, &[other.fault, one.fault], &then)?;
                }
            }
        }
    }

    /// Long after, too: nothing but ClearFault ends a fault.
    #[test]
    fn a_latched_fault_is_left_only_by_clearing_it(
        history in history(),
        row in 0..TABLE.len(),
        then in proptest::collection::vec(after(), 3000),
    ) {
        let fault = TABLE[row].fault;
        for (controller, last) in in_every_mode(&history) {
            stays_safe(&controller, &last, &[fault], &then)?;
        }
    }
}
