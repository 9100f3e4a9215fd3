//! A controller with the simulated finger behind it, driven by bytes: commands over the link, noise on the line, sensors and
//! lines that lie, and time. Every tick and every command is held to what the controller promises.

use host_sim::plant::{Plant, PlantParameters, Scene};
use model_core::actuation::{Actuation, Passage, Segment};
use model_core::calibration;
use model_core::controller::{Controller, Inputs, Mode, Outputs, PRESSURE_LIMIT, Reading};
use model_core::protocol::{
    Decoder, Effect, LinkCommand, MAX_FRAME, Reason, Report, Request, SequenceName, Telemetry, encode, handle,
};
use model_core::sequence::library;
use model_core::supervisor::fault::{Action, Fault, FaultSet};
use model_core::units::{Bend, Pressure};

/// A session ends after so many ticks: the longest one takes some milliseconds.
const TICKS_LIMIT: u32 = 20_000;

/// Bytes read one after another; what lies behind the end is zero.
struct Script<'a>(&'a [u8]);

impl Script<'_> {
    fn ended(&self) -> bool {
        self.0.is_empty()
    }

    fn byte(&mut self) -> u8 {
        let Some((&byte, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        byte
    }

    fn number(&mut self) -> i32 {
        i32::from(i16::from_le_bytes([self.byte(), self.byte()]))
    }

    fn numbers(&mut self, scale: i32) -> [i32; 3] {
        [self.number(), self.number(), self.number()].map(|number| number.saturating_mul(scale))
    }
}

/// How far a session got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reached {
    /// Ticks of the controller.
    pub ticks: u32,
    /// Requests that came through the line.
    pub requests: u32,
    /// Those that were taken.
    pub taken: u32,
    /// Every fault that was latched.
    pub faults: FaultSet,
    /// Ticks in which the pump was on.
    pub pump_ticks: u32,
}

struct Session {
    controller: Controller,
    plant: Plant,
    decoder: Decoder,
    manifold: Option<Reading<Pressure>>,
    bend: Option<Reading<Bend>>,
    /// Bits: emergency stop, switch, late tick, silent host.
    lines: u8,
    heard: bool,
    cleared: bool,
    last: Option<Outputs>,
    reached: Reached,
}

/// Plays the session that `bytes` tell.
///
/// # Panics
/// When the controller breaks a promise.
#[must_use]
pub fn play(bytes: &[u8]) -> Reached {
    let mut script = Script(bytes);
    let start = script.byte();
    let controller = if start & 1 == 1 {
        Controller::with_self_test([calibration::DEFAULT; 3])
    } else {
        Controller::new([calibration::DEFAULT; 3])
    };
    let mut session = Session {
        controller,
        plant: Plant::new(PlantParameters::default(), Scene::default(), u64::from(start >> 1)),
        decoder: Decoder::new(),
        manifold: None,
        bend: None,
        lines: 0,
        heard: false,
        cleared: false,
        last: None,
        reached: Reached::default(),
    };
    while !script.ended() && session.reached.ticks < TICKS_LIMIT {
        session.act(&mut script);
        session.telemetry_comes_back();
    }
    session.reached
}

impl Session {
    fn act(&mut self, script: &mut Script) {
        let command = match script.byte() % 20 {
            0 => {
                let index = usize::from(script.byte());
                let name = library::ALL.get(index).map_or("no such", |sequence| sequence.name);
                LinkCommand::Run(SequenceName::try_from(name).unwrap_or_default())
            }
            1 => LinkCommand::Pause,
            2 => LinkCommand::Resume,
            3 => LinkCommand::Vent,
            // Within ±256 kPa.
            4 => LinkCommand::Setpoints(script.numbers(1 << 9)),
            5 => LinkCommand::ZeroSensors,
            // Within ±64 kPa.
            6 => {
                let segment = Segment::ALL[usize::from(script.byte() % 3)];
                let [k, c1, c2] = script.numbers(1 << 15);
                LinkCommand::Calibrate { segment, k, c1, c2 }
            }
            7 => LinkCommand::Identify,
            8 => LinkCommand::ClearFault,
            9 => LinkCommand::Beat,
            10 => {
                let noise: Vec<u8> = (0..script.byte() % 16).map(|_| script.byte()).collect();
                return self.receive(&noise);
            }
            11 => return (0..=script.byte()).for_each(|_| self.tick()),
            12 => return (0..20 * u32::from(script.byte())).for_each(|_| self.tick()),
            13 => {
                self.manifold = reading(script).map(|reading| reading.map(Pressure::from_bits));
                return;
            }
            14 => {
                self.bend = reading(script).map(|reading| reading.map(Bend::from_bits));
                return;
            }
            15 => {
                self.lines = script.byte();
                return;
            }
            // Within ±256 degrees.
            16 => LinkCommand::Bends(script.numbers(1 << 9)),
            17 => LinkCommand::Identification,
            18 => LinkCommand::AdoptIdentified,
            // Everything as it really is.
            _ => {
                (self.manifold, self.bend, self.lines) = (None, None, 0);
                return;
            }
        };
        // A zero first, so that noise before it costs this frame nothing.
        let mut frame = [0; MAX_FRAME];
        let length = encode(&Request { id: 7, command }, &mut frame).expect("every request fits");
        let before = self.reached.requests;
        self.receive(&[0]);
        self.receive(&frame[..length]);
        assert!(self.reached.requests > before, "a good frame after a zero was not taken");
    }

    fn receive(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if let Some(Ok(request)) = self.decoder.push::<Request>(byte) {
                self.heard = true;
                self.request(&request.command);
            }
        }
    }

    fn request(&mut self, command: &LinkCommand) {
        let before = self.controller.clone();
        let answer = handle(&mut self.controller, command);
        self.reached.requests += 1;
        let mode = self.last.map(|outputs| outputs.mode);
        match answer {
            Ok(effect) => {
                self.reached.taken += 1;
                let stores = matches!(
                    command,
                    LinkCommand::ZeroSensors | LinkCommand::Calibrate { .. } | LinkCommand::AdoptIdentified
                );
                assert_eq!(effect == Effect::SettingsChanged, stores);
                assert_eq!(effect == Effect::IdentityAsked, *command == LinkCommand::Identify);
                let starts = matches!(command, LinkCommand::Run(_) | LinkCommand::Setpoints(_) | LinkCommand::Bends(_));
                let barred = matches!(mode, Some(Mode::Faulted(_) | Mode::SelfTest)) && !self.cleared;
                assert!(!(starts && barred), "{command:?} taken in {mode:?}");
                assert!(
                    !(stores && mode.is_some_and(|mode| mode != Mode::Vented) && barred),
                    "{command:?} in {mode:?}"
                );
                self.cleared |= *command == LinkCommand::ClearFault;
            }
            Err(reason) => {
                let unconditional = matches!(
                    command,
                    LinkCommand::Vent | LinkCommand::Identify | LinkCommand::Identification | LinkCommand::Beat
                );
                assert!(!unconditional, "{command:?}: {reason:?}");
                assert_ne!(reason, Reason::StorageFailed);
                let same = format!("{before:?}") == format!("{:?}", self.controller);
                assert!(same, "{command:?} was not taken ({reason:?}) and changed something");
            }
        }
    }

    fn tick(&mut self) {
        if self.reached.ticks >= TICKS_LIMIT {
            return;
        }
        let real = self.plant.inputs();
        let line = |bit: u8| self.lines >> bit & 1 == 1;
        let inputs = Inputs {
            manifold: self.manifold.unwrap_or(real.manifold),
            bend: self.bend.unwrap_or(real.bend),
            emergency_stop: line(0),
            over_pressure_switch: line(1) || real.over_pressure_switch,
            overrun: line(2),
            host_heard: core::mem::take(&mut self.heard) && !line(3),
            ..real
        };
        let outputs = self.controller.step(&inputs);
        self.promises_hold(&inputs, &outputs);
        self.plant.step(&outputs.actuation);
        self.reached.ticks += 1;
        self.reached.pump_ticks += u32::from(outputs.actuation.pump);
        self.reached.faults = self.reached.faults.union(outputs.faults);
        self.last = Some(outputs);
        self.cleared = false;
    }

    fn promises_hold(&self, inputs: &Inputs, outputs: &Outputs) {
        let within = |setpoint: &Pressure| (Pressure::ZERO..=PRESSURE_LIMIT).contains(setpoint);
        assert!(outputs.setpoints.iter().all(within), "{outputs:?}");
        let safe = outputs.actuation == Actuation::SAFE;
        match outputs.mode {
            Mode::Vented => assert!(safe, "{outputs:?}"),
            Mode::Faulted(fault) => {
                assert!(safe || diagnoses(inputs, outputs), "{inputs:?} {outputs:?}");
                assert_eq!(outputs.setpoints, [Pressure::ZERO; 3]);
                assert!(fault.action() == Action::Vent && outputs.faults.contains(fault), "{outputs:?}");
            }
            Mode::SelfTest | Mode::Running | Mode::Holding | Mode::Paused => {
                assert!(!outputs.faults.intersects(FaultSet::VENTING), "{outputs:?}");
            }
        }
        let stopped = inputs.emergency_stop || inputs.over_pressure_switch;
        assert!(!stopped || safe && matches!(outputs.mode, Mode::Faulted(_)), "{inputs:?} {outputs:?}");
        if let Some(last) = self.last.filter(|_| !self.cleared) {
            let lost = last.faults.without(outputs.faults);
            assert!(lost.is_empty(), "{lost:?} cleared without a command");
        }
    }

    /// What the controller shows can be sent, and is what the host receives.
    fn telemetry_comes_back(&self) {
        let Some(outputs) = self.last else { return };
        let sent = Report::Telemetry(telemetry(&outputs, self.decoder.dropped()));
        let mut frame = [0; MAX_FRAME];
        let length = encode(&sent, &mut frame).expect("every report fits");
        let mut host = Decoder::new();
        let received = frame[..length].iter().find_map(|&byte| host.push::<Report>(byte));
        assert_eq!(received, Some(Ok(sent.clone())));
        let Report::Telemetry(telemetry) = sent else { return };
        assert_eq!(telemetry.mode.mode(), Some(outputs.mode));
        assert_eq!(FaultSet::from_bits(telemetry.faults), outputs.faults);
    }
}

/// Whether what is energised while a fault is latched is what the diagnosis after venting may do: only after a fault that the
/// self test can name, never while or after stop, switch or pressure sensor speak against it, the pump only with every
/// passage closed.
#[must_use]
pub fn diagnoses(inputs: &Inputs, outputs: &Outputs) -> bool {
    let against = [
        Fault::OverPressure,
        Fault::OverPressureSwitch,
        Fault::PressureSensorBelowRange,
        Fault::PressureSensorAboveRange,
        Fault::EmergencyStop,
        Fault::PressureSensorNoisy,
        Fault::SwitchDisagrees,
    ];
    let Actuation { pump, dump, segments } = outputs.actuation;
    let closed = dump == Passage::Closed && segments == [Passage::Closed; 3];
    outputs.faults.intersects(FaultSet::TESTED)
        && !against.into_iter().any(|fault| outputs.faults.contains(fault))
        && inputs.manifold.valid().is_some()
        && (!pump || closed)
}

/// None, a value within ±512 of its unit, or out of range.
fn reading(script: &mut Script) -> Option<Reading<i32>> {
    match script.byte() % 6 {
        0 => None,
        1 => Some(Reading::BelowRange),
        2 => Some(Reading::AboveRange),
        3 => Some(Reading::Valid(script.number().saturating_mul(1 << 16))),
        _ => Some(Reading::Valid(script.number().saturating_mul(1 << 10))),
    }
}

fn telemetry(outputs: &Outputs, dropped_frames: u16) -> Telemetry {
    Telemetry {
        fingertip_um: [i32::MIN; 2],
        fingertip_millideg: i32::MAX,
        dropped_frames,
        tick_cycles: u32::MAX,
        worst_tick_cycles: u32::MAX,
        ..Telemetry::of(outputs)
    }
}
