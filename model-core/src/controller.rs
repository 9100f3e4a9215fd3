//! The controller: commands and sensor readings in, actuation and telemetry out, once a tick.

use crate::actuation::{Actuation, PerSegment, Segment};
use crate::bend_loop::{self, BendLoop};
use crate::identification::{self, Identification, Identified};
use crate::inverse::pressure_from_bend;
use crate::observer::{Observer, Pneumatics};
use crate::regulator::Regulator;
use crate::self_test::{SelfTest, Verdict};
use crate::sequence::player::{Player, Reference};
use crate::sequence::{Sequence, Target};
use crate::supervisor::fault::{Clearing, FaultSet};
use crate::supervisor::{Activity, Context, Supervisor};
use crate::units::{Bend, Coefficients, Millis, Pressure};

/// The highest setpoint: the end of the paper's working range.
pub use crate::sequence::MAX_PRESSURE as PRESSURE_LIMIT;
pub use crate::supervisor::fault::Fault;

/// The largest zero error of the pressure sensor that is trimmed away: the ISE30A's repeatability, 0.2 % of 1000 kPa.
pub const ZERO_LIMIT: Pressure = Pressure::from_kpa(2);

/// The largest zero error of the bend sensor that is taken off: 1 % of its 360 degrees (paper), and as much again for
/// how the finger lies.
pub const BEND_ZERO_LIMIT: Bend = Bend::from_deg(8);

/// Ticks for which the vented finger must have been within [`ZERO_LIMIT`] before its zero is trusted: the last of the
/// air has left by then.
const ZERO_TICKS: u16 = 400;

/// For so many ticks a finger that a fault has vented stays so before the diagnosis closes a valve.
const DIAGNOSIS_TICKS: u16 = 1000;
/// The same where the bend sensor cannot witness that it is empty: three chambers of twice the nominal volume behind valves of
/// 0.7 of the nominal conductance vent in 5 s, and half as much again.
const BLIND_DIAGNOSIS_TICKS: u16 = 7500;
/// A finger bent less than this in sum is empty: one chamber alone then has 4 kPa.
const STRAIGHT: Bend = Bend::from_deg(15);

/// What a sensor said this tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading<T> {
    /// A plausible value.
    Valid(T),
    /// Electrically below the sensor's range: a broken wire or no supply.
    BelowRange,
    /// Electrically above the sensor's range: a short, or more than the sensor can tell.
    AboveRange,
}

impl<T> Reading<T> {
    /// Changes a plausible value.
    #[must_use]
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> Reading<U> {
        match self {
            Self::Valid(value) => Reading::Valid(change(value)),
            Self::BelowRange => Reading::BelowRange,
            Self::AboveRange => Reading::AboveRange,
        }
    }

    /// The plausible value.
    #[must_use]
    pub fn valid(self) -> Option<T> {
        match self {
            Self::Valid(value) => Some(value),
            Self::BelowRange | Self::AboveRange => None,
        }
    }
}

/// Everything the controller sees in one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a line or an event of its own; together they are no state")]
pub struct Inputs {
    /// Time since start.
    pub now: Millis,
    /// Gauge pressure of the manifold (ISE30A, analogue).
    pub manifold: Reading<Pressure>,
    /// Bend of the whole finger (BF350): the sum of the three segments' bends.
    pub bend: Reading<Bend>,
    /// The ISE30A's switch output: true above its over-pressure threshold.
    pub over_pressure_switch: bool,
    /// True while the emergency stop is pressed or its loop is broken.
    pub emergency_stop: bool,
    /// A valid frame came from the host since the last tick. What a host drives by hand ends when it is silent.
    pub host_heard: bool,
    /// This tick came late, or a sample before it was lost.
    pub overrun: bool,
}

#[cfg(test)]
impl Inputs {
    /// A vented finger at rest, everything right.
    pub(crate) const CALM: Self = Self {
        now: Millis::ZERO,
        manifold: Reading::Valid(Pressure::ZERO),
        bend: Reading::Valid(Bend::ZERO),
        over_pressure_switch: false,
        emergency_stop: false,
        host_heard: true,
        overrun: false,
    };
}

/// What a user or a host asks for.
#[derive(Clone, Copy, Debug)]
pub enum Command {
    /// Runs a sequence from its start.
    Run(&'static Sequence),
    /// Goes to these gauge pressures at once, and holds them.
    Setpoints(PerSegment<Pressure>),
    /// Goes to these bends of the segments at once, and holds them; 0..=110 degrees each.
    Bends(PerSegment<Bend>),
    /// Vents the finger and ends whatever runs.
    Vent,
    /// Holds the running sequence where it is: its time stands still, its setpoints are kept.
    Pause,
    /// Goes on after a pause.
    Resume,
    /// Takes what the sensors read now as zero; only vented, and only within [`ZERO_LIMIT`] and [`BEND_ZERO_LIMIT`].
    ZeroSensors,
    /// Uses these coefficients for this segment; only vented.
    Calibrate(Segment, Coefficients),
    /// Uses the coefficients identified, of every segment that has some to offer; only vented.
    AdoptIdentified,
    /// Clears a latched fault whose cause is gone.
    ClearFault,
}

/// Why a command was not taken; nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// A fault is latched: clear it first.
    Faulted,
    /// A setpoint lies outside 0..=150 kPa or 0..=110 degrees.
    SetpointOutOfLimits,
    /// The fault's cause is still there.
    CauseStillPresent,
    /// No fault is latched.
    NoFault,
    /// No sequence runs.
    NotRunning,
    /// No sequence is paused.
    NotPaused,
    /// The finger is not vented.
    NotVented,
    /// A sensor is too far off its zero, or fails.
    ZeroOutOfLimits,
    /// The power-on self test runs; wait for its end.
    SelfTesting,
    /// No segment has identified coefficients to offer: run the sequence `calibrate` first.
    NothingIdentified,
}

/// What the controller is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Vented and waiting.
    Vented,
    /// The power-on self test runs.
    SelfTest,
    /// Running a sequence.
    Running,
    /// Holding setpoints given by hand.
    Holding,
    /// A sequence is paused.
    Paused,
    /// A fault is latched; vented.
    Faulted(Fault),
}

/// One tick's results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outputs {
    /// To the pins.
    pub actuation: Actuation,
    /// What the controller is doing.
    pub mode: Mode,
    /// Every fault that is latched, those that do not vent too.
    pub faults: FaultSet,
    /// The reference each chamber should have now (ramps included); zero when vented.
    pub setpoints: PerSegment<Pressure>,
    /// The estimated gauge pressure of each chamber.
    pub estimates: PerSegment<Pressure>,
    /// Index of the running step within the sequence; zero otherwise.
    pub step: u16,
    /// Which repeat of the sequence runs, from zero.
    pub repeat: u16,
    /// True while the reference rests at a step's target (its hold time), false during ramps, pauses and when vented.
    pub holding: bool,
    /// The manifold's pressure, its zero taken off.
    pub manifold: Reading<Pressure>,
    /// The finger's bend, its zero taken off.
    pub bend: Reading<Bend>,
}

/// The whole of the controller's state; the crate's page shows its use.
///
/// A command is taken or refused at once, and what it changes is seen in the next step:
///
/// ```
/// use model_core::calibration;
/// use model_core::controller::{Command, Controller, Rejection};
/// use model_core::units::Pressure;
///
/// let mut controller = Controller::new([calibration::DEFAULT; 3]);
/// let too_much = [Pressure::from_kpa(151), Pressure::ZERO, Pressure::ZERO];
/// assert_eq!(controller.command(Command::Setpoints(too_much)), Err(Rejection::SetpointOutOfLimits));
/// assert_eq!(controller.command(Command::Pause), Err(Rejection::NotRunning));
/// assert_eq!(controller.command(Command::Vent), Ok(()));
/// ```
#[derive(Clone, Debug)]
pub struct Controller {
    coefficients: PerSegment<Coefficients>,
    reference: Source,
    /// The sequence's reference of the last tick.
    last: Reference,
    observer: Observer,
    /// The self test has measured the machine for the observer.
    measured: bool,
    regulator: Regulator,
    supervisor: Supervisor,
    inputs: Option<Inputs>,
    /// What the sensor reads at atmosphere, and for how many ticks the vented finger has been near it.
    zero: Pressure,
    rested: u16,
    /// What the bend sensor reads at rest.
    bend_zero: Bend,
    /// While it runs, and while its failure is latched.
    self_test: Option<SelfTest>,
    bend_loop: BendLoop,
    identification: Identification,
    /// Looks for the part that failed while a fault is latched: not yet, now, or done.
    diagnosis: Diagnosis,
    /// What the last tick was about and drove.
    activity: Activity,
    commanded: Actuation,
    setpoints: PerSegment<Pressure>,
}

/// The self test's phases under a latched fault.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is no heap to put it on, and one controller")]
enum Diagnosis {
    /// Vented by the fault for so many ticks: not yet.
    Venting(u16),
    Runs(SelfTest),
    Done,
}

/// Where the setpoints come from.
#[derive(Clone, Debug)]
enum Source {
    Vented,
    Manual(Target),
    Sequence(Player),
    Paused(Player, Reference),
}

impl Controller {
    /// Starts vented, with the nominal pneumatics.
    #[must_use]
    pub const fn new(coefficients: PerSegment<Coefficients>) -> Self {
        Self::with_pneumatics(coefficients, Pneumatics::NOMINAL)
    }

    /// Starts vented, with other pneumatics.
    #[must_use]
    pub const fn with_pneumatics(coefficients: PerSegment<Coefficients>, pneumatics: Pneumatics) -> Self {
        Self {
            coefficients,
            reference: Source::Vented,
            last: Reference { target: Target::REST, step: 0, repeat: 0, holding: false, finished: false },
            observer: Observer::new(pneumatics),
            measured: false,
            regulator: Regulator::new(),
            supervisor: Supervisor::new(),
            inputs: None,
            zero: Pressure::ZERO,
            rested: 0,
            bend_zero: Bend::ZERO,
            self_test: None,
            diagnosis: Diagnosis::Venting(0),
            activity: Activity::Vented,
            commanded: Actuation::SAFE,
            setpoints: [Pressure::ZERO; 3],
            bend_loop: BendLoop::new(),
            identification: Identification::new(coefficients),
        }
    }

    /// Starts with the power-on self test, and is vented and ready when that has passed.
    #[must_use]
    pub const fn with_self_test(coefficients: PerSegment<Coefficients>) -> Self {
        let mut controller = Self::new(coefficients);
        controller.self_test = Some(SelfTest::new());
        controller
    }

    /// The calibration in use.
    #[must_use]
    pub const fn coefficients(&self) -> PerSegment<Coefficients> {
        self.coefficients
    }

    /// What the pressure sensor reads at atmosphere.
    #[must_use]
    pub const fn pressure_zero(&self) -> Pressure {
        self.zero
    }

    /// What the bend sensor reads at rest.
    #[must_use]
    pub const fn bend_zero(&self) -> Bend {
        self.bend_zero
    }

    /// What has been identified of each segment since its coefficients were taken into use.
    #[must_use]
    pub fn identified(&self) -> PerSegment<Identified> {
        self.identification.identified()
    }

    /// The trim of bends by the bend sensor.
    #[must_use]
    pub const fn bend_loop(&self) -> &BendLoop {
        &self.bend_loop
    }

    /// Takes back zeros that were stored. One beyond its limit is no zero and is left at nothing.
    pub fn restore_zeros(&mut self, pressure: Pressure, bend: Bend) {
        self.zero = if pressure.abs() <= ZERO_LIMIT { pressure } else { Pressure::ZERO };
        self.bend_zero = if bend.abs() <= BEND_ZERO_LIMIT { bend } else { Bend::ZERO };
    }

    /// Latches a fault that the start-up code knows of: a restart by the watchdog, a power dip, damaged settings.
    pub const fn report(&mut self, fault: Fault) {
        self.supervisor.latch(fault);
    }

    /// Takes a command.
    ///
    /// # Errors
    /// Says why the command was not taken; nothing changes then. Venting is always taken.
    pub fn command(&mut self, command: Command) -> Result<(), Rejection> {
        let next = match command {
            Command::Vent => Source::Vented,
            Command::ClearFault => {
                let inputs = self.inputs.ok_or(Rejection::NoFault)?;
                let cleared = self.supervisor.clear(&inputs)?;
                self.diagnosis = Diagnosis::Venting(0);
                if cleared.iter().any(|fault| fault.clearing() == Clearing::CommandThenSelfTest) {
                    self.self_test = Some(SelfTest::new());
                }
                return Ok(());
            }
            Command::ZeroSensors => return self.zero_sensors(),
            Command::Calibrate(segment, coefficients) => {
                self.require_vented()?;
                self.calibrate(segment, coefficients);
                return Ok(());
            }
            Command::AdoptIdentified => return self.adopt_identified(),
            Command::Pause => {
                let Source::Sequence(player) = &self.reference else { return Err(Rejection::NotRunning) };
                Source::Paused(player.clone(), self.last)
            }
            Command::Resume => {
                let Source::Paused(player, _) = &self.reference else { return Err(Rejection::NotPaused) };
                Source::Sequence(player.clone())
            }
            Command::Run(_) | Command::Setpoints(_) | Command::Bends(_) if self.supervisor.fault().is_some() => {
                return Err(Rejection::Faulted);
            }
            Command::Run(_) | Command::Setpoints(_) | Command::Bends(_) if self.self_test.is_some() => {
                return Err(Rejection::SelfTesting);
            }
            Command::Run(sequence) => Source::Sequence(Player::start(sequence)),
            Command::Setpoints(setpoints) => Self::manual(Target::Pressure(setpoints))?,
            Command::Bends(bends) => Self::manual(Target::Bend(bends))?,
        };
        self.reference = next;
        Ok(())
    }

    fn calibrate(&mut self, segment: Segment, coefficients: Coefficients) {
        let [proximal, middle, distal] = &mut self.coefficients;
        *match segment {
            Segment::Proximal => proximal,
            Segment::Middle => middle,
            Segment::Distal => distal,
        } = coefficients;
        self.identification.restart(segment as usize, coefficients);
    }

    fn adopt_identified(&mut self) -> Result<(), Rejection> {
        self.require_vented()?;
        let mut taken = Err(Rejection::NothingIdentified);
        for (segment, identified) in Segment::ALL.into_iter().zip(self.identified()) {
            if identified.ready {
                self.calibrate(segment, identified.coefficients);
                taken = Ok(());
            }
        }
        taken
    }

    fn manual(target: Target) -> Result<Source, Rejection> {
        if target.within_limits() { Ok(Source::Manual(target)) } else { Err(Rejection::SetpointOutOfLimits) }
    }

    fn require_vented(&self) -> Result<(), Rejection> {
        match (&self.reference, self.supervisor.fault()) {
            (_, Some(_)) => Err(Rejection::Faulted),
            _ if self.self_test.is_some() => Err(Rejection::SelfTesting),
            (Source::Vented, None) => Ok(()),
            _ => Err(Rejection::NotVented),
        }
    }

    fn zero_sensors(&mut self) -> Result<(), Rejection> {
        self.require_vented()?;
        let Some(Inputs { manifold: Reading::Valid(pressure), bend: Reading::Valid(bend), .. }) = self.inputs else {
            return Err(Rejection::ZeroOutOfLimits);
        };
        if pressure.abs() > ZERO_LIMIT || bend.abs() > BEND_ZERO_LIMIT {
            return Err(Rejection::ZeroOutOfLimits);
        }
        (self.zero, self.bend_zero) = (pressure, bend);
        Ok(())
    }

    /// One tick of one millisecond.
    pub fn step(&mut self, inputs: &Inputs) -> Outputs {
        self.inputs = Some(*inputs);
        if let Reading::Valid(manifold) = inputs.manifold {
            self.observer.measure(manifold - self.zero);
        }
        let chambers = self.observer.chambers();
        let fault = self.supervisor.watch(
            inputs,
            &Context {
                activity: self.activity,
                host_drives: matches!(self.reference, Source::Manual(_)),
                pressure_zero: self.zero,
                bend_zero: self.bend_zero,
                manifold: self.observer.manifold(),
                chambers: &chambers,
                air: self.measured.then(|| self.observer.air()),
                setpoints: &self.setpoints,
                commanded: &self.commanded,
                identifies: self.identifies(),
                coefficients: &self.coefficients,
            },
        );
        if fault.is_some() {
            // A sequence never goes on by itself after a fault.
            self.reference = Source::Vented;
        }
        let mut outputs = self.refer();
        let (fault, testing) = self.test(inputs, fault);
        if testing.is_some() {
            outputs.mode = Mode::SelfTest;
        }
        self.activity = if testing.is_some() { Activity::Testing } else { Activity::Vented };
        outputs.actuation = match (fault, outputs.mode) {
            (Some(fault), _) => {
                outputs.mode = Mode::Faulted(fault);
                let safe = self.regulator.vent();
                self.diagnose(inputs).unwrap_or(safe)
            }
            (None, Mode::SelfTest) => {
                self.regulator.vent();
                testing.unwrap_or(Actuation::SAFE)
            }
            (None, Mode::Running | Mode::Holding | Mode::Paused) => {
                self.activity = Activity::Driving;
                self.regulator.step(outputs.setpoints, &mut self.observer)
            }
            (None, _) => self.regulator.vent(),
        };
        self.observer.commanded(&outputs.actuation);
        (self.commanded, self.setpoints) = (outputs.actuation, outputs.setpoints);
        self.follow_zero(inputs.manifold, outputs.actuation);
        outputs.faults = self.supervisor.faults();
        outputs.estimates = self.observer.chambers();
        outputs.manifold = inputs.manifold.map(|pressure| pressure - self.zero);
        outputs.bend = inputs.bend.map(|bend| bend - self.bend_zero);
        self.follow_bend(&outputs);
        outputs
    }

    /// A sequence runs, or is paused, for which the coefficients may be far off.
    fn identifies(&self) -> bool {
        let (Source::Sequence(player) | Source::Paused(player, _)) = &self.reference else { return false };
        player.sequence().identifies()
    }

    /// The outer loop on bend, and the identification in the ticks that it leaves.
    fn follow_bend(&mut self, outputs: &Outputs) {
        let failed = outputs.faults.contains(Fault::BendSensorFailed);
        let bend = outputs.bend.valid().filter(|_| !failed);
        let air_rests = self.observer.air_rests();
        let estimates = outputs.estimates;
        let bends = match &self.reference {
            Source::Manual(Target::Bend(bends)) => Some(*bends),
            Source::Sequence(_) | Source::Paused(..) => match self.last.target {
                Target::Bend(bends) => Some(bends),
                Target::Pressure(_) => None,
            },
            Source::Manual(Target::Pressure(_)) | Source::Vented => None,
        };
        let setpoints = outputs.setpoints;
        let seen = bend_loop::Observation { bends, setpoints, estimates, bend, air_rests };
        let idle = self.bend_loop.step(&seen, &self.coefficients);
        self.identification.observe(&identification::Observation { setpoints, estimates, bend, air_rests });
        if idle {
            self.identification.work(&self.coefficients);
        }
    }

    /// Looks for the part that failed, once for each latched fault: the finger vents, and the self test's phases name what
    /// does not respond. Nothing when that is not, or no longer, allowed.
    fn diagnose(&mut self, inputs: &Inputs) -> Option<Actuation> {
        if !self.supervisor.may_diagnose() || self.self_test.is_some() {
            self.diagnosis = Diagnosis::Done;
            return None;
        }
        if let Diagnosis::Venting(ticks) = self.diagnosis {
            if ticks < DIAGNOSIS_TICKS || !self.is_straight(inputs) && ticks < BLIND_DIAGNOSIS_TICKS {
                self.diagnosis = Diagnosis::Venting(ticks.saturating_add(1));
                return None;
            }
            self.diagnosis = Diagnosis::Runs(SelfTest::new());
        }
        let Diagnosis::Runs(test) = &mut self.diagnosis else { return None };
        match test.step(inputs) {
            Verdict::Testing(actuation) => {
                if actuation != Actuation::SAFE {
                    self.activity = Activity::Testing;
                }
                return Some(actuation);
            }
            Verdict::Passed => {}
            Verdict::Failed(part) => {
                let named = test.named(part);
                self.supervisor.latch(named);
            }
        }
        self.diagnosis = Diagnosis::Done;
        None
    }

    /// The bend sensor works and says that the finger is straight: no chamber holds more than some kPa. That is another
    /// witness than the pressure sensor, which may be what failed.
    fn is_straight(&self, inputs: &Inputs) -> bool {
        let works = !self.supervisor.faults().contains(Fault::BendSensorFailed);
        let straight = |bend: Bend| (bend - self.bend_zero).abs() <= STRAIGHT;
        works && inputs.bend.valid().is_some_and(straight)
    }

    /// The self test's tick, while there is one: a failure is latched as a fault, and whatever fault there is starts the
    /// test over once it is cleared.
    fn test(&mut self, inputs: &Inputs, fault: Option<Fault>) -> (Option<Fault>, Option<Actuation>) {
        let Some(test) = &mut self.self_test else { return (fault, None) };
        if fault.is_some() {
            *test = SelfTest::new();
            return (fault, None);
        }
        match test.step(inputs) {
            Verdict::Testing(actuation) => (None, Some(actuation)),
            Verdict::Passed => {
                // Vented, as a new observer takes it to be.
                self.observer = Observer::new(test.measured());
                self.measured = true;
                self.self_test = None;
                (None, None)
            }
            Verdict::Failed(part) => {
                let named = test.named(part);
                *test = SelfTest::new();
                self.supervisor.latch(Fault::SelfTest(part));
                self.supervisor.latch(named);
                (self.supervisor.fault(), None)
            }
        }
    }

    /// Trims the sensor's zero while the finger is vented and has been at atmosphere for long enough. Only
    /// [`ZERO_LIMIT`] can be trimmed: more is no zero error.
    fn follow_zero(&mut self, manifold: Reading<Pressure>, actuation: Actuation) {
        match manifold {
            Reading::Valid(reading) if actuation == Actuation::SAFE && reading.abs() <= ZERO_LIMIT => {
                self.rested = self.rested.saturating_add(1);
                if self.rested > ZERO_TICKS {
                    self.zero = self.zero.low_passed(reading, 7);
                }
            }
            _ => self.rested = 0,
        }
    }

    /// This tick's mode and setpoints.
    fn refer(&mut self) -> Outputs {
        let mut outputs = Outputs {
            actuation: Actuation::SAFE,
            mode: Mode::Vented,
            faults: FaultSet::EMPTY,
            setpoints: [Pressure::ZERO; 3],
            estimates: [Pressure::ZERO; 3],
            step: 0,
            repeat: 0,
            holding: false,
            manifold: Reading::BelowRange,
            bend: Reading::BelowRange,
        };
        match &mut self.reference {
            Source::Vented => {}
            Source::Manual(target) => {
                (outputs.mode, outputs.holding) = (Mode::Holding, true);
                outputs.setpoints = pressures(&self.coefficients, &self.bend_loop, target);
            }
            Source::Paused(_, last) => {
                outputs.mode = Mode::Paused;
                outputs.setpoints = pressures(&self.coefficients, &self.bend_loop, &last.target);
                (outputs.step, outputs.repeat) = (last.step, last.repeat);
            }
            Source::Sequence(player) => {
                let reference = player.advance();
                self.last = reference;
                if reference.finished {
                    self.reference = Source::Vented;
                    return outputs;
                }
                outputs = Outputs {
                    mode: Mode::Running,
                    setpoints: pressures(&self.coefficients, &self.bend_loop, &reference.target),
                    step: reference.step,
                    repeat: reference.repeat,
                    holding: reference.holding,
                    ..outputs
                };
            }
        }
        outputs
    }
}

/// The gauge pressures that a target asks for.
fn pressures(coefficients: &PerSegment<Coefficients>, bend_loop: &BendLoop, target: &Target) -> PerSegment<Pressure> {
    match *target {
        Target::Pressure(setpoints) => setpoints,
        Target::Bend(bends) => {
            let [p, m, d] = bend_loop.trimmed(bends);
            let [of_p, of_m, of_d] = coefficients;
            [(of_p, p), (of_m, m), (of_d, d)]
                .map(|(own, bend)| pressure_from_bend(own, bend).clamp(Pressure::ZERO, PRESSURE_LIMIT))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration;
    use crate::sequence::library;

    const CALM: Inputs = Inputs::CALM;

    fn run(controller: &mut Controller, ticks: u32) -> Outputs {
        (1..ticks).for_each(|_| {
            controller.step(&CALM);
        });
        controller.step(&CALM)
    }

    #[test]
    fn a_pause_keeps_setpoints_and_time() {
        let mut controller = Controller::new([calibration::DEFAULT; 3]);
        assert_eq!(controller.command(Command::Pause), Err(Rejection::NotRunning));
        let sequence = library::find("all").expect("built in");
        controller.command(Command::Run(sequence)).expect("taken");
        let mut through = controller.clone();
        // Calm readings belie a running pump: what is asked here is over before that is found out.
        let before = run(&mut controller, 40);
        assert_eq!(controller.command(Command::Resume), Err(Rejection::NotPaused));
        controller.command(Command::Pause).expect("running");
        let paused = run(&mut controller, 30);
        assert_eq!((paused.mode, paused.setpoints, paused.step), (Mode::Paused, before.setpoints, before.step));
        controller.command(Command::Resume).expect("paused");
        // As if there had been no pause.
        run(&mut through, 40);
        assert_eq!(run(&mut controller, 1).setpoints, run(&mut through, 1).setpoints);
        // A fault ends a pause too.
        controller.command(Command::Pause).expect("running");
        controller.step(&Inputs { emergency_stop: true, ..CALM });
        assert_eq!(controller.command(Command::Resume), Err(Rejection::NotPaused));
    }

    #[test]
    fn zeros_are_taken_vented_and_within_their_limits() {
        let mut controller = Controller::new([calibration::DEFAULT; 3]);
        assert_eq!(controller.command(Command::ZeroSensors), Err(Rejection::ZeroOutOfLimits));
        let off = Inputs {
            manifold: Reading::Valid(Pressure::from_milli_kpa(1500)),
            bend: Reading::Valid(Bend::from_deg(-3)),
            ..CALM
        };
        controller.step(&off);
        controller.command(Command::ZeroSensors).expect("within the limits");
        let outputs = controller.step(&off);
        assert_eq!(outputs.manifold, Reading::Valid(Pressure::ZERO));
        assert_eq!(outputs.bend, Reading::Valid(Bend::ZERO));
        for beyond in [
            Inputs { manifold: Reading::Valid(Pressure::from_milli_kpa(2001)), ..CALM },
            Inputs { bend: Reading::Valid(Bend::from_milli_deg(8001)), ..CALM },
            Inputs { bend: Reading::BelowRange, ..CALM },
        ] {
            controller.step(&beyond);
            assert_eq!(controller.command(Command::ZeroSensors), Err(Rejection::ZeroOutOfLimits));
        }
        controller.step(&CALM);
        controller.command(Command::Setpoints([Pressure::from_kpa(10); 3])).expect("taken");
        assert_eq!(controller.command(Command::ZeroSensors), Err(Rejection::NotVented));
        assert_eq!(
            controller.command(Command::Calibrate(Segment::Distal, calibration::DEFAULT)),
            Err(Rejection::NotVented)
        );
    }
}
