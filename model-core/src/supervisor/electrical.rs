//! Lines and electrical ranges: emergency stop, pressure switch, over-pressure, wire break, short, and whether switch and
//! analogue output contradict each other.

use super::MANIFOLD_LIMIT;
use super::fault::Fault;
use super::held::lasts;
use crate::controller::{Inputs, Reading};
use crate::units::Pressure;

/// How long, in ticks, a condition must hold before it is a fault. The switch and the emergency stop act at once;
/// the analogue readings may be one disturbed sample.
pub(super) const ANALOGUE_TICKS: u8 = 5;

/// A switch that is closed while the reading is below this lies, or the reading does. The switch is set to 163 kPa, and the
/// reading lags a rise of 1.3 kPa/ms (pump on the manifold alone) by 5 kPa.
const CLOSED_ABOVE: Pressure = Pressure::from_kpa(140);
/// For so long, ticks: what vents at once takes the manifold through the 23 kPa in between in that time.
const CLOSED_TICKS: u8 = 100;
/// A switch that is open while the reading is above this does not work: set to 163 kPa, with 1 kPa of repeatability (0.1 % of its
/// range), and 6 kPa for its delay, the reading's noise, zero and gain.
const OPEN_BELOW: Pressure = Pressure::from_kpa(170);

/// See the module's page.
#[derive(Clone, Debug, Default)]
pub(super) struct Electrical {
    over_pressure: u8,
    below_range: u8,
    above_range: u8,
    switch_closed: u8,
    switch_open: u8,
}

impl Electrical {
    pub(super) const fn new() -> Self {
        Self { over_pressure: 0, below_range: 0, above_range: 0, switch_closed: 0, switch_open: 0 }
    }

    /// One tick; calls `found` with every fault that is there.
    pub(super) fn watch(&mut self, inputs: &Inputs, mut found: impl FnMut(Fault)) {
        let above = |limit: Pressure| matches!(inputs.manifold, Reading::Valid(pressure) if pressure > limit);
        let below = |limit: Pressure| matches!(inputs.manifold, Reading::Valid(pressure) if pressure < limit);
        let over = lasts(&mut self.over_pressure, above(MANIFOLD_LIMIT), ANALOGUE_TICKS);
        let broken = lasts(&mut self.below_range, inputs.manifold == Reading::BelowRange, ANALOGUE_TICKS);
        let shorted = lasts(&mut self.above_range, inputs.manifold == Reading::AboveRange, ANALOGUE_TICKS);
        let closed = inputs.over_pressure_switch;
        let lies = lasts(&mut self.switch_closed, closed && below(CLOSED_ABOVE), CLOSED_TICKS);
        let silent = lasts(&mut self.switch_open, !closed && above(OPEN_BELOW), ANALOGUE_TICKS);
        let present = [
            (inputs.emergency_stop, Fault::EmergencyStop),
            (closed, Fault::OverPressureSwitch),
            (over, Fault::OverPressure),
            (broken, Fault::PressureSensorBelowRange),
            (shorted, Fault::PressureSensorAboveRange),
            (lies || silent, Fault::SwitchDisagrees),
        ];
        for (holds, fault) in present {
            if holds {
                found(fault);
            }
        }
    }

    /// Whether the inputs are right again.
    pub(super) fn is_calm(inputs: &Inputs) -> bool {
        let plausible = matches!(inputs.manifold, Reading::Valid(pressure) if pressure <= MANIFOLD_LIMIT);
        plausible && !inputs.emergency_stop && !inputs.over_pressure_switch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CALM: Inputs = Inputs::CALM;

    /// The first fault within `ticks` of these inputs, and its tick.
    fn first(ticks: usize, inputs: &Inputs) -> Option<(usize, Fault)> {
        let mut electrical = Electrical::new();
        (1..=ticks).find_map(|tick| {
            let mut found = None;
            electrical.watch(inputs, |fault| found = found.or(Some((tick, fault))));
            found
        })
    }

    #[test]
    fn each_condition_is_found_after_its_time() {
        let just_over = Reading::Valid(MANIFOLD_LIMIT + Pressure::LSB);
        for (inputs, tick, fault) in [
            (Inputs { emergency_stop: true, ..CALM }, 1, Fault::EmergencyStop),
            (Inputs { over_pressure_switch: true, ..CALM }, 1, Fault::OverPressureSwitch),
            (Inputs { manifold: just_over, ..CALM }, 5, Fault::OverPressure),
            (Inputs { manifold: Reading::BelowRange, ..CALM }, 5, Fault::PressureSensorBelowRange),
            (Inputs { manifold: Reading::AboveRange, ..CALM }, 5, Fault::PressureSensorAboveRange),
        ] {
            assert_eq!(first(1000, &inputs), Some((tick, fault)));
        }
        assert_eq!(first(1000, &CALM), None);
        assert_eq!(first(1000, &Inputs { manifold: Reading::Valid(MANIFOLD_LIMIT), ..CALM }), None);
    }

    #[test]
    fn a_switch_that_contradicts_the_reading_is_found() {
        let all = |inputs: &Inputs, ticks: usize| {
            let mut electrical = Electrical::new();
            let mut disagrees = false;
            (0..ticks).for_each(|_| electrical.watch(inputs, |fault| disagrees |= fault == Fault::SwitchDisagrees));
            disagrees
        };
        let stuck = Inputs { over_pressure_switch: true, ..CALM };
        assert!(all(&stuck, 100) && !all(&stuck, 99));
        let failed = Inputs { manifold: Reading::Valid(Pressure::from_kpa(180)), ..CALM };
        assert!(all(&failed, 5) && !all(&failed, 4));
        let right = Inputs { over_pressure_switch: true, ..failed };
        assert!(!all(&right, 1000));
    }

    #[test]
    fn one_disturbed_sample_is_no_fault() {
        let mut electrical = Electrical::new();
        for tick in 0..1000 {
            let manifold = if tick % 5 == 4 { CALM.manifold } else { Reading::AboveRange };
            electrical.watch(&Inputs { manifold, ..CALM }, |fault| panic!("{fault:?}"));
        }
    }
}
