//! From a host's request to the controller's command: everything between a decoded frame and its answer that needs no
//! hardware.

use super::message::{LinkCommand, Reason};
use crate::controller::{Command, Controller};
use crate::sequence::library;
use crate::units::{Bend, Coefficients, Pressure};
use fixed::types::I8F24;

/// What the firmware has left to do for a request that was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Answer.
    Nothing,
    /// Store the settings, then answer.
    SettingsChanged,
    /// Answer with [`Identity`](super::message::Identity).
    IdentityAsked,
    /// Answer with [`Report::Identification`](super::message::Report::Identification).
    IdentificationAsked,
}

/// Gives what a host asks for to the controller.
///
/// # Errors
/// Says why it was not taken; nothing changes then.
pub fn handle(controller: &mut Controller, command: &LinkCommand) -> Result<Effect, Reason> {
    let command = match command {
        LinkCommand::Identify => return Ok(Effect::IdentityAsked),
        LinkCommand::Identification => return Ok(Effect::IdentificationAsked),
        LinkCommand::AdoptIdentified => Command::AdoptIdentified,
        LinkCommand::Beat => return Ok(Effect::Nothing),
        LinkCommand::Run(name) => Command::Run(library::find(name).ok_or(Reason::UnknownSequence)?),
        LinkCommand::Pause => Command::Pause,
        LinkCommand::Resume => Command::Resume,
        LinkCommand::Vent => Command::Vent,
        LinkCommand::Setpoints(bits) => Command::Setpoints(bits.map(Pressure::from_bits)),
        LinkCommand::ZeroSensors => Command::ZeroSensors,
        LinkCommand::Bends(bits) => Command::Bends(bits.map(Bend::from_bits)),
        LinkCommand::Calibrate { segment, k, c1, c2 } => {
            let [k, c1, c2] = [*k, *c1, *c2].map(I8F24::from_bits);
            Command::Calibrate(*segment, Coefficients::new(k, c1, c2).map_err(|_| Reason::CoefficientOutOfLimits)?)
        }
        LinkCommand::ClearFault => Command::ClearFault,
    };
    let changes_settings = matches!(command, Command::ZeroSensors | Command::Calibrate(..) | Command::AdoptIdentified);
    controller.command(command)?;
    Ok(if changes_settings { Effect::SettingsChanged } else { Effect::Nothing })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuation::Segment;
    use crate::calibration;
    use crate::controller::Inputs;
    use crate::protocol::SequenceName;

    #[test]
    fn what_is_left_to_do_is_told() {
        let mut controller = Controller::new([calibration::DEFAULT; 3]);
        controller.step(&Inputs::CALM);
        let unknown = LinkCommand::Run(SequenceName::try_from("none").expect("short"));
        let Ok(coefficients) = Coefficients::from_f64_kpa(0.0, 13.0, 0.3) else { panic!("admitted") };
        let [k, c1, c2] = [coefficients.k(), coefficients.c1(), coefficients.c2()].map(I8F24::to_bits);
        for (command, expected) in [
            (LinkCommand::Identify, Ok(Effect::IdentityAsked)),
            (LinkCommand::Identification, Ok(Effect::IdentificationAsked)),
            (LinkCommand::AdoptIdentified, Err(Reason::NothingIdentified)),
            (LinkCommand::Beat, Ok(Effect::Nothing)),
            (unknown, Err(Reason::UnknownSequence)),
            (LinkCommand::ZeroSensors, Ok(Effect::SettingsChanged)),
            (LinkCommand::Calibrate { segment: Segment::Middle, k, c1, c2 }, Ok(Effect::SettingsChanged)),
            (LinkCommand::Calibrate { segment: Segment::Middle, k: -1, c1, c2 }, Err(Reason::CoefficientOutOfLimits)),
            (LinkCommand::Pause, Err(Reason::NotRunning)),
            (LinkCommand::ClearFault, Err(Reason::NoFault)),
            (LinkCommand::Setpoints([0, 0, -1]), Err(Reason::SetpointOutOfLimits)),
            (LinkCommand::Setpoints([150 << 16; 3]), Ok(Effect::Nothing)),
            (LinkCommand::ZeroSensors, Err(Reason::NotVented)),
            (LinkCommand::Vent, Ok(Effect::Nothing)),
        ] {
            assert_eq!(handle(&mut controller, &command), expected, "{command:?}");
        }
        assert_eq!(controller.coefficients(), [calibration::DEFAULT, coefficients, calibration::DEFAULT]);
    }
}
