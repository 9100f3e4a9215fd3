//! What the controller does when it is asked.

use super::{BEND_ZERO_LIMIT, Command, Controller, Diagnosis, Inputs, Reading, Rejection, Source, ZERO_LIMIT};
use crate::actuation::Segment;
use crate::self_test::SelfTest;
use crate::sequence::Target;
use crate::sequence::player::Player;
use crate::supervisor::fault::Clearing;
use crate::units::Coefficients;

impl Controller {
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
}
