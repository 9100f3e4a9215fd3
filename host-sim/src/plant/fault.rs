//! Faults to inject.

use model_core::actuation::{Passage, Segment};
use model_core::units::Millis;

/// What breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// The pressure sensor's wire breaks: its input falls to 0 V.
    PressureSensorOpen,
    /// The pressure sensor's input is shorted to the supply: full scale.
    PressureSensorShort,
    /// The pressure sensor's analogue output stays where it is.
    PressureSensorFrozen,
    /// The strain gauge's wire breaks.
    BendSensorOpen,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The pump's relay contact is welded: it runs whatever is commanded.
    PumpStuckOn,
    /// The pump does not run.
    PumpDead,
    /// A segment's valve stays at this passage.
    SegmentValveStuck(Segment, Passage),
    /// The dump valve stays at this passage.
    DumpStuck(Passage),
    /// A chamber leaks to the atmosphere.
    ChamberLeak {
        /// Which chamber.
        segment: Segment,
        /// Sonic conductance of the hole, NL/(s bar), at least 0; b as the segment valves.
        conductance_nl_per_s_bar: f64,
    },
}

/// A fault and when it is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InjectedFault {
    /// What breaks.
    pub kind: FaultKind,
    /// First tick (ms since start) with it.
    pub from: Millis,
    /// First tick without it again; `None`: it stays.
    pub until: Option<Millis>,
}

impl InjectedFault {
    /// A fault that stays from `from_ms` on.
    #[must_use]
    pub const fn lasting(kind: FaultKind, from_ms: u32) -> Self {
        Self { kind, from: Millis(from_ms), until: None }
    }

    /// A fault that is there in `from_ms..until_ms`.
    #[must_use]
    pub const fn passing(kind: FaultKind, from_ms: u32, until_ms: u32) -> Self {
        Self { kind, from: Millis(from_ms), until: Some(Millis(until_ms)) }
    }

    /// Whether it is there.
    #[must_use]
    pub fn is_active(&self, now: Millis) -> bool {
        now >= self.from && self.until.is_none_or(|until| now < until)
    }
}

/// How the pressure sensor's signal is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SignalFault {
    Open,
    Short,
    Frozen,
}

/// All faults of one moment, sorted by the part they break. Of several on one part the last listed counts; leaks on
/// one chamber too.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ActiveFaults {
    pub pressure_signal: Option<SignalFault>,
    pub bend_open: bool,
    pub emergency_stop: bool,
    pub pump: Option<bool>,
    pub segments: [Option<Passage>; 3],
    pub dump: Option<Passage>,
    pub leaks_nl_per_s_bar: [f64; 3],
}

impl ActiveFaults {
    pub(super) fn at(faults: &[InjectedFault], now: Millis) -> Self {
        let mut active = Self::default();
        for fault in faults.iter().filter(|fault| fault.is_active(now)) {
            match fault.kind {
                FaultKind::PressureSensorOpen => active.pressure_signal = Some(SignalFault::Open),
                FaultKind::PressureSensorShort => active.pressure_signal = Some(SignalFault::Short),
                FaultKind::PressureSensorFrozen => active.pressure_signal = Some(SignalFault::Frozen),
                FaultKind::BendSensorOpen => active.bend_open = true,
                FaultKind::EmergencyStop => active.emergency_stop = true,
                FaultKind::PumpStuckOn => active.pump = Some(true),
                FaultKind::PumpDead => active.pump = Some(false),
                FaultKind::SegmentValveStuck(segment, passage) => active.segments[segment as usize] = Some(passage),
                FaultKind::DumpStuck(passage) => active.dump = Some(passage),
                FaultKind::ChamberLeak { segment, conductance_nl_per_s_bar } => {
                    active.leaks_nl_per_s_bar[segment as usize] = conductance_nl_per_s_bar;
                }
            }
        }
        active
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_is_there_from_its_first_tick_to_the_one_before_its_end() {
        let passing = InjectedFault::passing(FaultKind::EmergencyStop, 5, 7);
        let active: Vec<u32> = (0..10).filter(|&ms| passing.is_active(Millis(ms))).collect();
        assert_eq!(active, [5, 6]);
        let lasting = InjectedFault::lasting(FaultKind::EmergencyStop, 5);
        assert!(!lasting.is_active(Millis(4)) && lasting.is_active(Millis(5)) && lasting.is_active(Millis(u32::MAX)));
    }
}
