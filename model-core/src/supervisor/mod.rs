//! Limits, contradictions and latched faults; wins over everything else.
//!
//! ```text
//!            a condition holds for its time                 vented, at atmosphere
//!   Watching ──────────────────────────────▶ Latched (vented) ─────────────────▶ the self test names the part, once
//!      ▲                                        │ clear, and no condition holds any more
//!      └────────────────────────────────────────┘
//! ```
//!
//! Each file holds one kind of detector, pure and stepped once a tick; [`table`] says what each fault leads to.

mod balance;
mod bend;
mod electrical;
pub mod fault;
mod held;
mod link;
mod pneumatics;
mod response;
mod session;
mod signal;
pub mod table;

use crate::actuation::{Actuation, PerSegment};
use crate::controller::{Inputs, Reading, Rejection};
use crate::observer::Air;
use crate::units::{Bend, Coefficients, Pressure};
use balance::Balance;
use bend::{Residual, Verdict};
use electrical::Electrical;
use fault::{Fault, FaultSet};
use link::Link;
use pneumatics::Pneumatics;
use response::Response;
use session::Session;
use signal::Signal;

/// The manifold's limit. The working range ends at 150 kPa; the regulator never asks the manifold for more than
/// [`MANIFOLD_CEILING`](crate::regulator::MANIFOLD_CEILING), and the chambers may not pass 165 kPa. The switch, set to 163 kPa within 1 kPa, acts first; 4 kPa are left for what
/// the manifold alone rises until the pump has run down, and for the reading's errors.
pub const MANIFOLD_LIMIT: Pressure = Pressure::from_kpa(168);

/// Silence, in ticks, after which a host that drives the finger is lost.
pub const SILENCE_TICKS: u16 = 1000;

/// What the controller is about, as far as it matters here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// Vented: everything rests.
    Vented,
    /// The self test drives the valves.
    Testing,
    /// The regulator follows setpoints.
    Driving,
}

/// What the supervisor looks at in a tick beside the inputs.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// What the controller was about in the last tick.
    pub activity: Activity,
    /// A host drives by hand: setpoints that hold as long as it is there.
    pub host_drives: bool,
    /// What the sensors read at rest.
    pub pressure_zero: Pressure,
    /// The same of the bend sensor.
    pub bend_zero: Bend,
    /// The manifold's pressure, its zero taken off, filtered over 4 ms.
    pub manifold: Pressure,
    /// Estimated pressure of each chamber.
    pub chambers: &'a PerSegment<Pressure>,
    /// What the observer's model and corrections moved; none while the model is not that of this machine.
    pub air: Option<Air>,
    /// The last tick's.
    pub setpoints: &'a PerSegment<Pressure>,
    /// The last tick's.
    pub commanded: &'a Actuation,
    /// A sequence runs that is there to find the coefficients: those in use may be far off.
    pub identifies: bool,
    /// The model's.
    pub coefficients: &'a PerSegment<Coefficients>,
}

/// Faults after which nothing may be put under pressure, not even for a diagnosis: what they say must first be
/// cleared by someone.
const NO_DIAGNOSIS: FaultSet = FaultSet::EMPTY
    .with(Fault::OverPressure)
    .with(Fault::OverPressureSwitch)
    .with(Fault::PressureSensorBelowRange)
    .with(Fault::PressureSensorAboveRange)
    .with(Fault::EmergencyStop)
    .with(Fault::PressureSensorStuck)
    .with(Fault::PressureSensorNoisy)
    .with(Fault::SwitchDisagrees);

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Supervisor {
    /// The first that vents.
    latched: Option<Fault>,
    /// All, those that do not vent too.
    faults: FaultSet,
    electrical: Electrical,
    signal: Signal,
    pneumatics: Pneumatics,
    balance: Balance,
    response: Response,
    bend: Residual,
    link: Link,
    session: Session,
}

impl Default for Supervisor {
    fn default() -> Self {
        Self::new()
    }
}

impl Supervisor {
    /// Nothing latched.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            latched: None,
            faults: FaultSet::EMPTY,
            electrical: Electrical::new(),
            signal: Signal::new(),
            pneumatics: Pneumatics::new(),
            balance: Balance::new(),
            response: Response::new(),
            bend: Residual::new(),
            link: Link::new(),
            session: Session::new(),
        }
    }

    /// Looks at this tick's inputs; returns the latched fault, the first that came of those that vent.
    pub fn watch(&mut self, inputs: &Inputs, context: &Context) -> Option<Fault> {
        let (faults, latched) = (&mut self.faults, &mut self.latched);
        self.electrical.watch(inputs, |fault| latch(faults, latched, fault));
        if let Reading::Valid(reading) = inputs.manifold {
            let shown = self.signal.watch(reading - context.pressure_zero);
            if shown.too_fast {
                self.latch(Fault::PressureRate);
            }
            if shown.noisy {
                self.latch(Fault::PressureSensorNoisy);
            }
            self.compare(context);
        }
        self.look_at_bend(inputs, context);
        if self.link.host_is_lost(inputs.host_heard, context.host_drives) {
            self.latch(Fault::LinkLost);
        }
        if self.link.ticks_are_late(inputs.overrun) {
            self.latch(Fault::TickOverrun);
        }
        if let Some(fault) = self.session.watch(context.activity == Activity::Driving, context.setpoints) {
            self.latch(fault);
        }
        self.latched
    }

    /// Air against commands; the self test looks for itself.
    fn compare(&mut self, context: &Context) {
        if context.activity == Activity::Testing {
            self.pneumatics = Pneumatics::new();
            self.balance = Balance::new();
            self.response = Response::new();
            return;
        }
        let look = pneumatics::Look {
            manifold: context.manifold,
            chambers: context.chambers,
            setpoints: context.setpoints,
            commanded: context.commanded,
            stands_still: self.signal.stands_still(),
        };
        if let Some(fault) = self.pneumatics.watch(&look) {
            self.latch(fault);
        }
        let Some(air) = context.air else { return };
        if self.balance.misses_air(air) {
            self.latch(Fault::LeakBurst);
        }
        if context.activity == Activity::Driving && self.response.contradicts(air) {
            self.latch(Fault::AirDisagrees);
        }
    }

    fn look_at_bend(&mut self, inputs: &Inputs, context: &Context) {
        let reading = inputs.bend.valid().map(|bend| bend - context.bend_zero);
        let chambers = bend::Chambers {
            pressures: context.chambers,
            coefficients: context.coefficients,
            identifies: context.identifies,
            open: context.activity == Activity::Driving && *context.commanded == Actuation::SAFE,
        };
        match self.bend.watch(reading, &chambers) {
            Verdict::SensorFailed => self.latch(Fault::BendSensorFailed),
            // The self test opens valves onto chambers whose estimates do not know of it.
            Verdict::Disagrees
                if context.activity != Activity::Testing && !self.faults.contains(Fault::BendSensorFailed) =>
            {
                self.latch(Fault::BendDisagrees);
            }
            Verdict::Disagrees | Verdict::Agrees => {}
        }
    }

    /// The latched fault that vents, the first that came.
    #[must_use]
    pub const fn fault(&self) -> Option<Fault> {
        self.latched
    }

    /// All latched faults.
    #[must_use]
    pub const fn faults(&self) -> FaultSet {
        self.faults
    }

    /// Whether the self test may now look for the part that failed.
    #[must_use]
    pub const fn may_diagnose(&self) -> bool {
        self.faults.intersects(FaultSet::TESTED) && !self.faults.intersects(NO_DIAGNOSIS)
    }

    /// Latches a fault; of those that vent the first stays the one that is told.
    pub const fn latch(&mut self, fault: Fault) {
        latch(&mut self.faults, &mut self.latched, fault);
    }

    /// Clears the latched faults, if nothing that would latch one is present in `inputs` any more. Returns what was
    /// cleared; the session goes on unless its own limit was reached.
    ///
    /// # Errors
    /// [`Rejection::NoFault`] or [`Rejection::CauseStillPresent`].
    pub fn clear(&mut self, inputs: &Inputs) -> Result<FaultSet, Rejection> {
        if self.faults.is_empty() {
            return Err(Rejection::NoFault);
        }
        let has = |fault| self.faults.contains(fault);
        let present = !Electrical::is_calm(inputs)
            || has(Fault::PressureSensorNoisy) && self.signal.is_noisy()
            || has(Fault::BendDisagrees) && !self.bend.is_calm()
            || has(Fault::BendSensorFailed) && inputs.bend.valid().is_none()
            || has(Fault::TickOverrun) && !self.link.is_calm();
        if present {
            return Err(Rejection::CauseStillPresent);
        }
        let session_ended = has(Fault::SessionTime) || has(Fault::SessionCycles);
        let session = if session_ended { Session::new() } else { self.session.clone() };
        let cleared = self.faults;
        *self = Self { session, ..Self::new() };
        Ok(cleared)
    }
}

/// Puts a fault into the set, and before all others if it is the first that vents.
const fn latch(faults: &mut FaultSet, latched: &mut Option<Fault>, fault: Fault) {
    faults.insert(fault);
    if latched.is_none() && FaultSet::of(fault).intersects(FaultSet::VENTING) {
        *latched = Some(fault);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration;

    const CALM: Inputs = Inputs::CALM;
    const CONTEXT: Context = Context {
        activity: Activity::Vented,
        host_drives: false,
        pressure_zero: Pressure::ZERO,
        bend_zero: Bend::ZERO,
        manifold: Pressure::ZERO,
        chambers: &[Pressure::ZERO; 3],
        air: Some(Air::STILL),
        setpoints: &[Pressure::ZERO; 3],
        commanded: &Actuation::SAFE,
        identifies: false,
        coefficients: &[calibration::DEFAULT; 3],
    };

    #[test]
    fn a_fault_stays_until_cleared_and_its_cause_is_gone() {
        let mut supervisor = Supervisor::new();
        assert_eq!(supervisor.clear(&CALM), Err(Rejection::NoFault));
        let pressed = Inputs { emergency_stop: true, ..CALM };
        supervisor.watch(&pressed, &CONTEXT);
        supervisor.watch(&CALM, &CONTEXT);
        assert_eq!(supervisor.fault(), Some(Fault::EmergencyStop));
        assert!(!supervisor.may_diagnose());
        assert_eq!(supervisor.clear(&pressed), Err(Rejection::CauseStillPresent));
        assert_eq!(supervisor.clear(&CALM), Ok(FaultSet::of(Fault::EmergencyStop)));
        assert_eq!(supervisor.watch(&CALM, &CONTEXT), None);
    }

    #[test]
    fn all_faults_are_kept_and_the_first_that_vents_is_told() {
        let mut supervisor = Supervisor::new();
        supervisor.latch(Fault::BendSensorFailed);
        assert_eq!(supervisor.fault(), None);
        supervisor.latch(Fault::LeakBurst);
        supervisor.latch(Fault::DumpStuckOpen);
        assert_eq!(supervisor.fault(), Some(Fault::LeakBurst));
        assert_eq!(supervisor.faults().iter().count(), 3);
        assert!(supervisor.may_diagnose());
    }

    #[test]
    fn nothing_is_found_on_a_finger_that_rests() {
        let mut supervisor = Supervisor::new();
        for _ in 0..20_000 {
            supervisor.watch(&CALM, &CONTEXT);
        }
        assert!(supervisor.faults().is_empty(), "{:?}", supervisor.faults().iter().collect::<Vec<_>>());
    }
}
