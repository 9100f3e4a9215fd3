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
    /// The pressure sensor's analogue output stays where it is; the converter's own noise stays too.
    PressureSensorFrozen,
    /// The pressure sensor's noise is that many times as large, at least 1.
    PressureSensorNoisy {
        /// The factor.
        times: f64,
    },
    /// The pressure switch's output stays at this, whatever the pressure: true is closed, above its threshold.
    PressureSwitchStuck(bool),
    /// The strain gauge's wire breaks.
    BendSensorOpen,
    /// The bend sensor's input is shorted to the supply: full scale.
    BendSensorShort,
    /// The bend sensor's amplifier stays where it is; the converter's own noise stays too.
    BendSensorFrozen,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The pump's relay contact is welded: it runs whatever is commanded.
    PumpStuckOn,
    /// The pump does not run.
    PumpDead,
    /// The pump gives less than it should at every pressure: a torn diaphragm, a blocked inlet.
    PumpWeak {
        /// What is left of its flow, 0..=1.
        share: f64,
    },
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
    /// A hole in the manifold, or a dump valve that does not seal. Beside the open dump valve it is not counted.
    ManifoldLeak {
        /// Sonic conductance of the hole, NL/(s bar), at least 0; b as the dump valve.
        conductance_nl_per_s_bar: f64,
    },
    /// Something is in a segment's way: it bends no further than it is when the fault comes. Straightening is free.
    FingerBlocked(Segment),
    /// A moment from outside bends a segment further, or straightens it, within [`PUSH_MS`]; never beyond straight.
    FingerPushed {
        /// Which segment.
        segment: Segment,
        /// By how much, degrees; negative straightens.
        degrees: f64,
    },
}

/// Time in which a push comes and goes, ms: a hand's quick movement, assumed.
pub const PUSH_MS: f64 = 100.0;

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

/// How a sensor's analogue signal is broken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SignalFault {
    Open,
    Short,
    Frozen,
    /// So many times its noise.
    Noisy(f64),
}

/// All faults of one moment, sorted by the part they break. Of several on one part the last listed counts; leaks on
/// one chamber too. The pump's relay and what the pump gives are two parts, and so are a push at a segment and something in
/// its way: the push acts first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ActiveFaults {
    pub pressure_signal: Option<SignalFault>,
    pub pressure_switch: Option<bool>,
    pub bend_signal: Option<SignalFault>,
    pub emergency_stop: bool,
    pub pump: Option<bool>,
    pub pump_share: f64,
    pub blocked: [bool; 3],
    pub push_deg: [f64; 3],
    pub segments: [Option<Passage>; 3],
    pub dump: Option<Passage>,
    pub leaks_nl_per_s_bar: [f64; 3],
    pub manifold_leak_nl_per_s_bar: f64,
}

impl Default for ActiveFaults {
    fn default() -> Self {
        Self {
            pressure_signal: None,
            pressure_switch: None,
            bend_signal: None,
            emergency_stop: false,
            pump: None,
            pump_share: 1.0,
            blocked: [false; 3],
            push_deg: [0.0; 3],
            segments: [None; 3],
            dump: None,
            leaks_nl_per_s_bar: [0.0; 3],
            manifold_leak_nl_per_s_bar: 0.0,
        }
    }
}

impl ActiveFaults {
    pub(super) fn at(faults: &[InjectedFault], now: Millis) -> Self {
        let mut active = Self::default();
        for fault in faults.iter().filter(|fault| fault.is_active(now)) {
            match fault.kind {
                FaultKind::PressureSensorOpen => active.pressure_signal = Some(SignalFault::Open),
                FaultKind::PressureSensorShort => active.pressure_signal = Some(SignalFault::Short),
                FaultKind::PressureSensorFrozen => active.pressure_signal = Some(SignalFault::Frozen),
                FaultKind::PressureSensorNoisy { times } => active.pressure_signal = Some(SignalFault::Noisy(times)),
                FaultKind::PressureSwitchStuck(closed) => active.pressure_switch = Some(closed),
                FaultKind::BendSensorOpen => active.bend_signal = Some(SignalFault::Open),
                FaultKind::BendSensorShort => active.bend_signal = Some(SignalFault::Short),
                FaultKind::BendSensorFrozen => active.bend_signal = Some(SignalFault::Frozen),
                FaultKind::EmergencyStop => active.emergency_stop = true,
                FaultKind::PumpStuckOn => active.pump = Some(true),
                FaultKind::PumpDead => active.pump = Some(false),
                FaultKind::PumpWeak { share } => active.pump_share = share,
                FaultKind::SegmentValveStuck(segment, passage) => active.segments[segment as usize] = Some(passage),
                FaultKind::DumpStuck(passage) => active.dump = Some(passage),
                FaultKind::ChamberLeak { segment, conductance_nl_per_s_bar } => {
                    active.leaks_nl_per_s_bar[segment as usize] = conductance_nl_per_s_bar;
                }
                FaultKind::ManifoldLeak { conductance_nl_per_s_bar } => {
                    active.manifold_leak_nl_per_s_bar = conductance_nl_per_s_bar;
                }
                FaultKind::FingerBlocked(segment) => active.blocked[segment as usize] = true,
                FaultKind::FingerPushed { segment, degrees } => active.push_deg[segment as usize] = degrees,
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
