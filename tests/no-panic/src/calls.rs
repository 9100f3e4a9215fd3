//! Every public function of model-core, called with values that the compiler knows nothing of.
//!
//! Functions are named by path (`Type::method`, `module::function`, `<Type as Trait>::method`): the host test
//! `public_functions` reads the paths in this file and fails when one of model-core's functions is missing. Each group is a
//! function of its own, so that the check's report says where it came from.

use core::hint::black_box;
use core::ops::{Add, Sub};
use fixed::types::{I8F24, I16F16};
use model_core::actuation::{Actuation, Passage, Segment};
use model_core::bend_loop::BendLoop;
use model_core::calibration;
use model_core::controller::{Command, Controller, Fault, Inputs, Mode, Reading, Rejection};
use model_core::division;
use model_core::force::{self, DrivingForce};
use model_core::identification::Identified;
use model_core::inverse::{self, Tabulated};
use model_core::kinematics::{self, Chain, Point, Unreachable};
use model_core::observer::{Air, DeadTicks, Observer, Pneumatics};
use model_core::protocol::frame::{self, Decoder, MAX_FRAME};
use model_core::protocol::handler;
use model_core::protocol::message::{self, IdentifiedSegment, LinkCommand, LinkMode, Reason, Request};
use model_core::regulator::Regulator;
use model_core::self_test::{Part, SelfTest};
use model_core::sequence::player::Player;
use model_core::sequence::{Sequence, Step, Target, library};
use model_core::supervisor::fault::{FaultSet, Priority};
use model_core::supervisor::{Activity, Context, Supervisor};
use model_core::units::{Bend, Coefficients, Force, Length, Millis, Pressure};

/// A value of which the compiler knows only the type: nothing that depends on it is folded away.
pub fn any<T>(sample: T) -> T {
    black_box(sample)
}

/// Takes a result, so that what made it is not dropped.
pub fn consume<T>(result: T) {
    black_box(result);
}

/// A pressure for each segment.
pub const PRESSURES: [Pressure; 3] = [Pressure::ZERO; 3];
/// Inputs of a tick.
pub const INPUTS: Inputs = Inputs {
    now: Millis::ZERO,
    manifold: Reading::Valid(Pressure::ZERO),
    bend: Reading::Valid(Bend::ZERO),
    over_pressure_switch: false,
    emergency_stop: false,
    host_heard: true,
    overrun: false,
};
/// What a segment's points say.
pub const IDENTIFIED: Identified = Identified {
    coefficients: calibration::DEFAULT,
    residual_pressure: Pressure::ZERO,
    residual_bend: Bend::ZERO,
    points: 0,
    ready: false,
};
/// What the supervisor looks at beside.
pub const CONTEXT: Context = Context {
    activity: Activity::Driving,
    host_drives: true,
    identifies: false,
    pressure_zero: Pressure::ZERO,
    bend_zero: Bend::ZERO,
    manifold: Pressure::ZERO,
    chambers: &PRESSURES,
    air: Some(Air::STILL),
    setpoints: &PRESSURES,
    commanded: &Actuation::SAFE,
    coefficients: &[calibration::DEFAULT; 3],
};
/// Everything.
pub fn all() {
    actuation();
    controller();
    control_commands();
    division();
    faults();
    force();
    frames();
    inverse();
    kinematics();
    messages();
    observer();
    pneumatics();
    regulator();
    requests();
    self_test();
    sequences();
    players();
    supervisor();
    pressures();
    bends();
    lengths();
    forces();
    times();
    coefficients();
}

/// One deliberate panic, an index that the compiler cannot know: the check has to find it.
#[cfg(feature = "positive-control")]
#[inline(never)]
pub fn positive_control() {
    consume(any(&PRESSURES)[any(0_usize)]);
}

#[inline(never)]
fn actuation() {
    consume(Segment::name(any(Segment::Middle)));
    consume(<Actuation as Default>::default());
    consume(<Passage as Default>::default());
}

fn any_controller() -> Controller {
    any(Controller::new(any([calibration::DEFAULT; 3])))
}

#[inline(never)]
fn controller() {
    let mut controller = any_controller();
    consume(Controller::with_self_test(any([calibration::DEFAULT; 3])));
    consume(Controller::with_pneumatics(any([calibration::DEFAULT; 3]), any(Pneumatics::NOMINAL)));
    consume(Controller::coefficients(&controller));
    consume(Controller::pressure_zero(&controller));
    consume(Controller::bend_zero(&controller));
    consume(Controller::identified(&controller));
    consume(BendLoop::trims(Controller::bend_loop(&controller)));
    consume(BendLoop::falls_back(Controller::bend_loop(&controller)));
    Controller::restore_zeros(&mut controller, any(Pressure::ZERO), any(Bend::ZERO));
    let mut controller = any(controller);
    Controller::report(&mut controller, any(Fault::TaskHang));
    let mut controller = any(controller);
    consume(Controller::step(&mut controller, &any(INPUTS)));
    consume(controller);
    consume(Reading::map(any(INPUTS.manifold), any::<fn(Pressure) -> i32>(Pressure::to_bits)));
    consume(Reading::valid(any(INPUTS.manifold)));
}

#[inline(never)]
fn control_commands() {
    let mut controller = any_controller();
    // One that may be any, and each for itself.
    for command in any([
        Command::Run(any(&SEQUENCE)),
        Command::Setpoints(PRESSURES),
        Command::Vent,
        Command::Pause,
        Command::Resume,
        Command::ZeroSensors,
        Command::Calibrate(Segment::Distal, calibration::DEFAULT),
        Command::Bends([Bend::ZERO; 3]),
        Command::AdoptIdentified,
        Command::ClearFault,
    ]) {
        consume(Controller::command(&mut controller, command));
        controller = any(controller);
    }
}

#[inline(never)]
fn division() {
    consume(division::divide(any(I16F16::ONE), any(I16F16::ONE)));
}

#[inline(never)]
fn faults() {
    consume(Fault::from_code(any(0)));
    consume(Fault::code(any(Fault::OverPressure)));
    consume(Fault::priority(any(Fault::OverPressure)));
    consume(Fault::action(any(Fault::OverPressure)));
    consume(Fault::clearing(any(Fault::OverPressure)));
    consume(Priority::name(any(Priority::Low)));
    let mut set = any(FaultSet::of(any(Fault::OverPressure)));
    FaultSet::insert(&mut set, any(Fault::OverPressure));
    let set = any(set);
    consume(FaultSet::from_bits(any(FaultSet::bits(set))));
    consume(FaultSet::with(set, any(Fault::OverPressure)));
    consume(FaultSet::contains(set, any(Fault::OverPressure)));
    consume(FaultSet::intersects(set, any(FaultSet::VENTING)));
    consume(FaultSet::union(set, any(FaultSet::VENTING)));
    consume(FaultSet::without(set, any(FaultSet::VENTING)));
    consume(FaultSet::is_empty(set));
    consume(FaultSet::priority(set));
    for fault in FaultSet::iter(set) {
        consume(fault);
    }
    for code in FaultSet::codes(set) {
        consume(code);
    }
    consume(<FaultSet as Default>::default());
}

#[inline(never)]
fn frames() {
    consume(frame::checksum(any(&[0_u8; 4][..])));
    consume(<Decoder as Default>::default());
    let mut decoder = any(Decoder::new());
    consume(Decoder::push::<Request>(&mut decoder, any(0)));
    consume(Decoder::dropped(&any(decoder)));
    let mut buffer = any([0; MAX_FRAME]);
    consume(frame::encode(&any(LinkMode::Vented), any(buffer.as_mut_slice())));
    consume(buffer);
}

#[inline(never)]
fn requests() {
    let mut controller = any_controller();
    consume(handler::handle(&mut controller, &any(LinkCommand::Pause)));
    consume(controller);
}

#[inline(never)]
fn inverse() {
    consume(inverse::bend_from_pressure(&any(calibration::DEFAULT), any(Pressure::ZERO)));
    consume(inverse::pressure_from_bend(&any(calibration::DEFAULT), any(Bend::ZERO)));
    let tabulated = any(Tabulated::new(&any(calibration::DEFAULT)));
    consume(Tabulated::bend_from_pressure(&tabulated, any(Pressure::ZERO)));
    consume(Tabulated::pressure_from_bend(&tabulated, any(Bend::ZERO)));
}

#[inline(never)]
fn messages() {
    consume(<Reason as From<Rejection>>::from(any(Rejection::Faulted)));
    consume(<LinkMode as From<Mode>>::from(any(Mode::Vented)));
    consume(<IdentifiedSegment as From<Identified>>::from(any(IDENTIFIED)));
    consume(LinkMode::mode(any(LinkMode::Vented)));
    consume(message::outputs_of(&any(Actuation::SAFE)));
    consume(message::Telemetry::of(&any(Controller::new([calibration::DEFAULT; 3])).step(&any(INPUTS))));
    consume(message::actuation_of(any(0)));
}

#[inline(never)]
fn observer() {
    let mut observer = any(Observer::new(any(Pneumatics::NOMINAL)));
    Observer::measure(&mut observer, any(Pressure::ZERO));
    let mut observer = any(observer);
    Observer::commanded(&mut observer, &any(Actuation::SAFE));
    let observer = any(observer);
    consume(Observer::air_rests(&observer));
    consume(Observer::chambers(&observer));
    consume(Observer::flows(&observer));
    consume(Observer::manifold(&observer));
    consume(Observer::ahead(&observer));
    consume(Observer::innovation(&observer));
    consume(Observer::air(&observer));
    consume(Observer::pump_ticks_pending(&observer));
    consume(Observer::dump_ticks_pending(&observer));
    consume(Observer::pneumatics(&observer));
    consume(Observer::level(&observer, any([false; 3])));
    consume(Observer::volumes(&observer));
    consume(Observer::volume(&observer, any([false; 3])));
}

#[inline(never)]
fn pneumatics() {
    let pneumatics = any(Pneumatics::NOMINAL);
    consume(DeadTicks::new(any(0)));
    consume(DeadTicks::get(pneumatics.dead_ticks));
    consume(Pneumatics::pump_flow(&pneumatics, any(Pressure::ZERO)));
    consume(Pneumatics::growth(&pneumatics, any(Pressure::ZERO)));
    consume(Pneumatics::valve_flow(&pneumatics, any(I16F16::ZERO), any(Pressure::ZERO), any(Pressure::ZERO)));
}

#[inline(never)]
fn regulator() {
    let mut regulator = any(<Regulator as Default>::default());
    let mut observer = any(Observer::new(Pneumatics::NOMINAL));
    consume(Regulator::step(&mut regulator, any(PRESSURES), &mut observer));
    consume(observer);
    let mut regulator = any(regulator);
    consume(Regulator::vent(&mut regulator));
    consume(regulator);
    consume(Regulator::new());
}

#[inline(never)]
fn self_test() {
    let mut test = any(SelfTest::new());
    consume(SelfTest::step(&mut test, &any(INPUTS)));
    consume(SelfTest::named(&any(test.clone()), any(Part::Pump)));
    consume(SelfTest::measured(&any(test.clone())));
    consume(test);
    consume(<SelfTest as Default>::default());
    consume(Part::code(any(Part::Pump)));
}

/// Two steps.
pub const STEPS: [Step; 2] = [Step::kpa([30; 3]), Step::kpa([0; 3])];
/// A sequence of them.
pub static SEQUENCE: Sequence = Sequence::new("sample", "A sample", &STEPS, 1);

#[inline(never)]
fn sequences() {
    let step = any(Step::kpa(any([0; 3])));
    consume(Step::deg(any([0; 3])));
    consume(Step::ramp_ms(step, any(0)));
    consume(Step::hold_ms(step, any(0)));
    consume(Sequence::check(any("sample"), any("A sample"), any(&STEPS[..]), any(1)));
    consume(Sequence::steps(any(&SEQUENCE)));
    consume(Sequence::repeats(any(&SEQUENCE)));
    consume(Sequence::duration(any(&SEQUENCE)));
    consume(Sequence::for_identification(any(SEQUENCE)));
    consume(Sequence::identifies(any(&SEQUENCE)));
    consume(library::find(any("sample")));
    consume(Target::at_rest(&any(Target::REST)));
    consume(Target::within_limits(&any(Target::REST)));
}

#[inline(never)]
fn players() {
    let mut player = any(Player::start(any(&SEQUENCE)));
    consume(Player::sequence(&player));
    consume(Player::advance(&mut player));
    consume(player);
}

#[inline(never)]
fn supervisor() {
    let mut supervisor = any(Supervisor::new());
    let context = any(CONTEXT);
    consume(Supervisor::watch(&mut supervisor, &any(INPUTS), &context));
    let mut supervisor = any(supervisor);
    Supervisor::latch(&mut supervisor, any(Fault::OverPressure));
    let mut supervisor = any(supervisor);
    consume(Supervisor::clear(&mut supervisor, &any(INPUTS)));
    consume(Supervisor::faults(&supervisor));
    consume(Supervisor::may_diagnose(&supervisor));
    consume(Supervisor::fault(&any(supervisor)));
    consume(<Supervisor as Default>::default());
}

#[inline(never)]
fn pressures() {
    let (one, other) = any((Pressure::ZERO, Pressure::ZERO));
    consume(Pressure::from_kpa(any(0)));
    consume(Pressure::from_milli_kpa(any(0)));
    consume(Pressure::from_bits(any(0)));
    consume(Pressure::to_bits(one));
    consume(Pressure::to_fixed(one));
    consume(Pressure::from_fixed(any(I16F16::ZERO)));
    consume(Pressure::abs(one));
    consume(Pressure::scaled(one, any(I16F16::ONE)));
    consume(Pressure::midpoint(one, other));
    consume(Pressure::low_passed(one, other, any(3)));
    consume(<Pressure as Add>::add(one, other));
    consume(<Pressure as Sub>::sub(one, other));
    consume(<Pressure as Default>::default());
}

#[inline(never)]
fn bends() {
    let (one, other) = any((Bend::ZERO, Bend::ZERO));
    consume(Bend::from_deg(any(0)));
    consume(Bend::from_milli_deg(any(0)));
    consume(Bend::from_bits(any(0)));
    consume(Bend::to_bits(one));
    consume(Bend::to_fixed(one));
    consume(Bend::from_fixed(any(I16F16::ZERO)));
    consume(Bend::abs(one));
    consume(Bend::scaled(one, any(I16F16::ONE)));
    consume(Bend::midpoint(one, other));
    consume(Bend::low_passed(one, other, any(3)));
    consume(<Bend as Add>::add(one, other));
    consume(<Bend as Sub>::sub(one, other));
    consume(<Bend as Default>::default());
}

#[inline(never)]
fn lengths() {
    let (one, other) = any((Length::ZERO, Length::ZERO));
    consume(Length::from_mm(any(0)));
    consume(Length::from_um(any(0)));
    consume(Length::from_bits(any(0)));
    consume(Length::to_bits(one));
    consume(Length::to_fixed(one));
    consume(Length::from_fixed(any(I16F16::ZERO)));
    consume(Length::abs(one));
    consume(Length::scaled(one, any(I16F16::ONE)));
    consume(Length::midpoint(one, other));
    consume(Length::low_passed(one, other, any(3)));
    consume(<Length as Add>::add(one, other));
    consume(<Length as Sub>::sub(one, other));
    consume(<Length as Default>::default());
}

#[inline(never)]
fn forces() {
    let (one, other) = any((Force::ZERO, Force::ZERO));
    consume(Force::from_newtons(any(0)));
    consume(Force::from_milli_newtons(any(0)));
    consume(Force::from_bits(any(0)));
    consume(Force::to_bits(one));
    consume(Force::to_fixed(one));
    consume(Force::from_fixed(any(I16F16::ZERO)));
    consume(Force::abs(one));
    consume(Force::scaled(one, any(I16F16::ONE)));
    consume(Force::midpoint(one, other));
    consume(Force::low_passed(one, other, any(3)));
    consume(<Force as Add>::add(one, other));
    consume(<Force as Sub>::sub(one, other));
    consume(<Force as Default>::default());
}

#[inline(never)]
fn force() {
    consume(DrivingForce::at(any(&DrivingForce::FINGER), any(Pressure::ZERO)));
    consume(force::finger_force(any(&PRESSURES)));
}

#[inline(never)]
fn kinematics() {
    let chain = any(Chain::PAPER);
    consume(Chain::new(any(Length::ZERO), any([Length::ZERO; 3]), any([Length::ZERO; 3])));
    consume(Chain::base(&chain));
    consume(Chain::arcs(&chain));
    consume(Chain::links(&chain));
    consume(<Point as Default>::default());
    consume(<kinematics::Fingertip as Default>::default());
    let bends = any([Bend::ZERO; 3]);
    consume(kinematics::fingertip(&chain, &bends));
    consume(kinematics::bends(&chain, any(Point { x: Length::ZERO, y: Length::ZERO }), &bends));
    let missed = any(Unreachable { distance: Length::ZERO, nearest: [Bend::ZERO; 3] });
    consume(Unreachable::limits(&missed));
}

#[inline(never)]
fn times() {
    let (one, other) = any((Millis::ZERO, Millis::ZERO));
    consume(Millis::since(one, other));
    consume(<Millis as Add>::add(one, other));
    consume(<Millis as Default>::default());
}

#[inline(never)]
fn coefficients() {
    consume(Coefficients::new(any(I8F24::ZERO), any(I8F24::ZERO), any(I8F24::ZERO)));
    let coefficients = any(calibration::DEFAULT);
    consume(Coefficients::k(coefficients));
    consume(Coefficients::c1(coefficients));
    consume(Coefficients::c2(coefficients));
}
