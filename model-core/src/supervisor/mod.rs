//! Limits and latched faults; wins over everything else.
//!
//! ```text
//!            a condition holds for its time
//!   Watching ──────────────────────────────▶ Latched (vented)
//!      ▲                                        │ clear, and no condition holds any more
//!      └────────────────────────────────────────┘
//! ```

pub mod fault;
pub mod table;

use crate::controller::{Inputs, Reading, Rejection};
use crate::units::Pressure;
use fault::{Fault, FaultSet};

/// The manifold's limit. The working range ends at 150 kPa; the regulator never asks the manifold for more than
/// 160 kPa, and the chambers may not pass 165 kPa.
pub const MANIFOLD_LIMIT: Pressure = Pressure::from_kpa(172);

/// How long, in ticks, a condition must hold before it is a fault. The switch and the emergency stop act at once;
/// the analogue readings may be one disturbed sample.
const ANALOGUE_TICKS: u8 = 5;

/// See the module's page.
#[derive(Clone, Debug, Default)]
pub struct Supervisor {
    /// The first that vents.
    latched: Option<Fault>,
    /// All, those that do not vent too.
    faults: FaultSet,
    over_pressure: u8,
    below_range: u8,
    above_range: u8,
}

impl Supervisor {
    /// Nothing latched.
    #[must_use]
    pub const fn new() -> Self {
        Self { latched: None, faults: FaultSet::EMPTY, over_pressure: 0, below_range: 0, above_range: 0 }
    }

    /// Looks at this tick's inputs; returns the latched fault, the first that came.
    pub fn watch(&mut self, inputs: &Inputs) -> Option<Fault> {
        let count = |ticks: &mut u8, condition: bool| {
            *ticks = if condition { ticks.saturating_add(1) } else { 0 };
            *ticks >= ANALOGUE_TICKS
        };
        let over = matches!(inputs.manifold, Reading::Valid(pressure) if pressure > MANIFOLD_LIMIT);
        let over = count(&mut self.over_pressure, over);
        let below = count(&mut self.below_range, inputs.manifold == Reading::BelowRange);
        let above = count(&mut self.above_range, inputs.manifold == Reading::AboveRange);
        let present = [
            (inputs.emergency_stop, Fault::EmergencyStop),
            (inputs.over_pressure_switch, Fault::OverPressureSwitch),
            (over, Fault::OverPressure),
            (below, Fault::PressureSensorBelowRange),
            (above, Fault::PressureSensorAboveRange),
        ];
        for (holds, fault) in present {
            if holds {
                self.latch(fault);
            }
        }
        self.latched
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

    /// Latches a fault; of those that vent the first stays the one that is told.
    pub const fn latch(&mut self, fault: Fault) {
        self.faults.insert(fault);
        if self.latched.is_none() && FaultSet::of(fault).intersects(FaultSet::VENTING) {
            self.latched = Some(fault);
        }
    }

    /// Clears the latched fault, if nothing that would latch one is present in `inputs` any more.
    ///
    /// # Errors
    /// [`Rejection::NoFault`] or [`Rejection::CauseStillPresent`].
    pub fn clear(&mut self, inputs: &Inputs) -> Result<(), Rejection> {
        if self.faults.is_empty() {
            return Err(Rejection::NoFault);
        }
        let plausible = matches!(inputs.manifold, Reading::Valid(pressure) if pressure <= MANIFOLD_LIMIT);
        if inputs.emergency_stop || inputs.over_pressure_switch || !plausible {
            return Err(Rejection::CauseStillPresent);
        }
        *self = Self::new();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CALM: Inputs = Inputs::CALM;

    fn after(ticks: usize, inputs: &Inputs) -> Option<Fault> {
        let mut supervisor = Supervisor::new();
        for _ in 0..ticks {
            supervisor.watch(inputs);
        }
        supervisor.fault()
    }

    #[test]
    fn each_condition_latches_after_its_time() {
        let just_over = Reading::Valid(MANIFOLD_LIMIT + Pressure::LSB);
        for (inputs, ticks, fault) in [
            (Inputs { emergency_stop: true, ..CALM }, 1, Fault::EmergencyStop),
            (Inputs { over_pressure_switch: true, ..CALM }, 1, Fault::OverPressureSwitch),
            (Inputs { manifold: just_over, ..CALM }, 5, Fault::OverPressure),
            (Inputs { manifold: Reading::BelowRange, ..CALM }, 5, Fault::PressureSensorBelowRange),
            (Inputs { manifold: Reading::AboveRange, ..CALM }, 5, Fault::PressureSensorAboveRange),
        ] {
            assert_eq!(after(ticks - 1, &inputs), None, "{fault:?} too early");
            assert_eq!(after(ticks, &inputs), Some(fault));
        }
        assert_eq!(after(1000, &CALM), None);
        assert_eq!(after(1000, &Inputs { manifold: Reading::Valid(MANIFOLD_LIMIT), ..CALM }), None);
    }

    #[test]
    fn a_fault_stays_until_cleared_and_its_cause_is_gone() {
        let mut supervisor = Supervisor::new();
        assert_eq!(supervisor.clear(&CALM), Err(Rejection::NoFault));
        let pressed = Inputs { emergency_stop: true, ..CALM };
        supervisor.watch(&pressed);
        supervisor.watch(&CALM);
        assert_eq!(supervisor.fault(), Some(Fault::EmergencyStop));
        assert_eq!(supervisor.clear(&pressed), Err(Rejection::CauseStillPresent));
        assert_eq!(supervisor.clear(&CALM), Ok(()));
        assert_eq!(supervisor.watch(&CALM), None);
    }

    #[test]
    fn one_disturbed_sample_is_no_fault() {
        let mut supervisor = Supervisor::new();
        for tick in 0..1000 {
            let manifold = if tick % 5 == 4 { CALM.manifold } else { Reading::AboveRange };
            supervisor.watch(&Inputs { manifold, ..CALM });
        }
        assert_eq!(supervisor.fault(), None);
    }
}
