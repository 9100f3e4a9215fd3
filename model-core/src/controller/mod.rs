//! The controller: commands and sensor readings in, actuation and telemetry out, once a tick.

mod commands;
mod diagnosis;
mod interface;

pub use interface::Command;
pub use interface::Inputs;
pub use interface::Mode;
pub use interface::Outputs;
pub use interface::Reading;
pub use interface::Rejection;

use crate::actuation::{Actuation, PerSegment};
use crate::bend_loop::{self, BendLoop};
use crate::identification::{self, Identification, Identified};
use crate::inverse::pressure_from_bend;
use crate::observer::{Observer, Pneumatics};
use crate::regulator::Regulator;
use crate::self_test::SelfTest;
use crate::sequence::Target;
use crate::sequence::player::{Player, Reference};
use crate::supervisor::fault::FaultSet;
use crate::supervisor::{Activity, Context, Supervisor};
use crate::units::{Bend, Coefficients, Pressure};
use diagnosis::Diagnosis;

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
    use crate::actuation::Segment;
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
