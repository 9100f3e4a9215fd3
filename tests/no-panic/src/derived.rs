//! What model-core's types derive, called like the functions in `calls`.
//!
//! The host test `public_functions` reads which types a function here is called for, and compares with the derives.

use crate::calls::{IDENTIFIED, INPUTS, SEQUENCE, STEPS, any, consume};
use core::hash::{Hash, Hasher};
use heapless::String;
use model_core::actuation::{Actuation, Passage, Segment};
use model_core::bend_loop::BendLoop;
use model_core::calibration;
use model_core::controller::{Command, Controller, Fault, Inputs, Mode, Outputs, Reading, Rejection};
use model_core::force::DrivingForce;
use model_core::identification::Identified;
use model_core::inverse::Tabulated;
use model_core::kinematics::{Chain, ChainError, Fingertip, Limit, Point, Unreachable};
use model_core::observer::{Ahead, Air, DeadTicks, Observer, Pneumatics};
use model_core::protocol::frame::{self, Decoder, FrameError, MAX_FRAME};
use model_core::protocol::handler::Effect;
use model_core::protocol::message::{
    IdentifiedSegment, Identity, LinkCommand, LinkMode, Reason, Report, Request, ResetCause, SequenceName, Telemetry,
};
use model_core::regulator::Regulator;
use model_core::self_test::{Part, SelfTest, Verdict};
use model_core::sequence::player::{Player, Reference};
use model_core::sequence::{Sequence, SequenceError, Step, Target};
use model_core::supervisor::fault::{Action, Clearing, FaultSet, Priority, Row};
use model_core::supervisor::{Activity, Context, Supervisor};
use model_core::units::{Bend, CoefficientError, Coefficients, Force, Length, Millis, Pressure};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// `Clone`.
#[inline(never)]
fn cloned<T: Clone>(value: &T) {
    consume(any(value).clone());
}

/// `PartialEq`.
#[inline(never)]
fn compared<T: PartialEq>(value: &T) {
    consume(any(value) == any(value));
}

/// `PartialOrd` and `Ord`.
#[inline(never)]
fn ordered<T: Ord>(value: &T) {
    consume(any(value).partial_cmp(any(value)));
    consume(any(value).cmp(any(value)));
}

/// `Hash`, with a hasher that only sums.
#[inline(never)]
fn hashed<T: Hash>(value: &T) {
    let mut sum = Sum(0);
    any(value).hash(&mut sum);
    consume(sum.finish());
}

struct Sum(u64);

impl Hasher for Sum {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = self.0.wrapping_add(u64::from(byte));
        }
    }
}

/// `Serialize` and `Deserialize`, in a frame sent and a frame received.
#[inline(never)]
fn coded<M: Serialize + DeserializeOwned>(message: &M) {
    let mut buffer = any([0; MAX_FRAME]);
    consume(frame::encode(message, any(buffer.as_mut_slice())));
    consume(buffer);
    let mut decoder = any(Decoder::new());
    consume(Decoder::push::<M>(&mut decoder, any(0)));
    consume(decoder);
}

/// Everything.
pub fn all() {
    actuation();
    controller();
    states();
    messages();
    sequences();
    kinematics();
    units();
}

/// What nearly every type derives.
fn plain<T: Clone + PartialEq>(value: &T) {
    cloned(value);
    compared(value);
}

fn actuation() {
    message::<Segment>(&Segment::Middle);
    ordered::<Segment>(&Segment::Middle);
    plain::<Passage>(&Passage::Open);
    plain::<Actuation>(&Actuation::SAFE);
}

fn controller() {
    plain::<Reading<Pressure>>(&INPUTS.manifold);
    plain::<Inputs>(&INPUTS);
    cloned::<Command>(&Command::Run(&SEQUENCE));
    plain::<Rejection>(&Rejection::Faulted);
    plain::<Fault>(&Fault::OverPressure);
    plain::<FaultSet>(&FaultSet::VENTING);
    plain::<Priority>(&Priority::Low);
    ordered::<Priority>(&Priority::Low);
    plain::<Action>(&Action::Vent);
    plain::<Activity>(&Activity::Driving);
    cloned::<Context>(&crate::calls::CONTEXT);
    plain::<Clearing>(&Clearing::Command);
    cloned::<Row>(&model_core::supervisor::table::TABLE[0]);
    plain::<Mode>(&Mode::Vented);
    plain::<Effect>(&Effect::Nothing);
    plain::<Outputs>(&any(Controller::new([calibration::DEFAULT; 3])).step(&any(INPUTS)));
}

fn states() {
    let controller = Controller::new([calibration::DEFAULT; 3]);
    cloned::<Controller>(&controller);
    cloned::<Tabulated>(&Tabulated::new(&calibration::DEFAULT));
    cloned::<BendLoop>(controller.bend_loop());
    plain::<Identified>(&IDENTIFIED);
    let observer = Observer::new(Pneumatics::NOMINAL);
    cloned::<Observer>(&observer);
    plain::<Ahead>(&observer.ahead());
    plain::<Air>(&observer.air());
    plain::<DeadTicks>(&DeadTicks::MAX);
    plain::<Pneumatics>(&Pneumatics::NOMINAL);
    let regulator = Regulator::new();
    cloned::<Regulator>(&regulator);
    let test = SelfTest::new();
    cloned::<SelfTest>(&test);
    plain::<Part>(&Part::Pump);
    plain::<Verdict>(&Verdict::Passed);
    let supervisor = Supervisor::new();
    cloned::<Supervisor>(&supervisor);
    let decoder = Decoder::new();
    cloned::<Decoder>(&decoder);
    plain::<FrameError>(&FrameError::Crc);
}

fn messages() {
    message::<LinkCommand>(&LinkCommand::Run(SequenceName::new()));
    message::<Request>(&Request { id: 0, command: LinkCommand::Identify });
    message::<Report>(&Report::Ack { id: 0 });
    message::<Identity>(&identity());
    message::<IdentifiedSegment>(&IDENTIFIED.into());
    message::<ResetCause>(&ResetCause::Pin);
    message::<Reason>(&Reason::Faulted);
    message::<LinkMode>(&LinkMode::Vented);
    message::<Telemetry>(&TELEMETRY);
}

/// What every message derives.
fn message<M: Clone + PartialEq + Serialize + DeserializeOwned>(value: &M) {
    plain(value);
    coded(value);
}

fn sequences() {
    let [step, _] = STEPS;
    plain::<Step>(&step);
    plain::<Target>(&step.target);
    plain::<Sequence>(&SEQUENCE);
    plain::<SequenceError>(&SequenceError::Name);
    let player = Player::start(&SEQUENCE);
    cloned::<Player>(&player);
    plain::<Reference>(&Reference { target: step.target, step: 0, repeat: 0, holding: false, finished: false });
}

fn kinematics() {
    plain::<DrivingForce>(&DrivingForce::FINGER);
    plain::<Chain>(&Chain::PAPER);
    plain::<ChainError>(&ChainError::Negative(Length::ZERO));
    plain::<Point>(&Point { x: Length::ZERO, y: Length::ZERO });
    let bends = [Bend::ZERO; 3];
    plain::<Fingertip>(&model_core::kinematics::fingertip(&Chain::PAPER, &bends));
    plain::<Limit>(&Limit::Bent);
    plain::<Unreachable>(&Unreachable { distance: Length::ZERO, nearest: bends });
}

fn units() {
    plain::<Pressure>(&Pressure::ZERO);
    ordered::<Pressure>(&Pressure::ZERO);
    hashed::<Pressure>(&Pressure::ZERO);
    plain::<Bend>(&Bend::ZERO);
    ordered::<Bend>(&Bend::ZERO);
    hashed::<Bend>(&Bend::ZERO);
    plain::<Length>(&Length::ZERO);
    ordered::<Length>(&Length::ZERO);
    hashed::<Length>(&Length::ZERO);
    plain::<Force>(&Force::ZERO);
    ordered::<Force>(&Force::ZERO);
    hashed::<Force>(&Force::ZERO);
    plain::<Millis>(&Millis::ZERO);
    ordered::<Millis>(&Millis::ZERO);
    hashed::<Millis>(&Millis::ZERO);
    plain::<Coefficients>(&calibration::DEFAULT);
    plain::<CoefficientError>(&CoefficientError::K);
}

fn identity() -> Identity {
    Identity {
        id: 0,
        protocol: 0,
        firmware: any(String::new()),
        serial: [0; 3],
        reset_cause: ResetCause::Pin,
        coefficients: [[0; 3]; 3],
        pressure_zero: 0,
        bend_zero: 0,
        sequences: 0,
    }
}

const TELEMETRY: Telemetry = Telemetry {
    tick: 0,
    mode: LinkMode::Vented,
    faults: 0,
    priority: 0,
    setpoints: [0; 3],
    estimates: [0; 3],
    manifold: None,
    bend: None,
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
