//! What a campaign breaks, and what the supervisor may call it.

use model_core::actuation::Segment;
use model_core::self_test::Part;
use model_core::supervisor::fault::{Action, Fault, FaultSet};
use model_core::supervisor::table::TABLE;

/// A kind of fault: a row of the detection matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// The pressure sensor's wire breaks.
    PressureSensorOpen,
    /// The pressure sensor's signal is shorted to the supply.
    PressureSensorShort,
    /// The pressure sensor's output stands still.
    PressureSensorFrozen,
    /// The pressure sensor's noise is ten times as large.
    PressureSensorNoisy,
    /// The pressure switch never closes.
    SwitchStuckOpen,
    /// The pressure switch is closed.
    SwitchStuckClosed,
    /// The strain gauge's wire breaks.
    BendSensorOpen,
    /// The bend sensor's signal is shorted to the supply.
    BendSensorShort,
    /// The bend sensor's output stands still.
    BendSensorFrozen,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The pump's relay is welded.
    PumpStuckOn,
    /// The pump does not run.
    PumpDead,
    /// The pump gives 5 to 30 % of its flow.
    PumpWeak,
    /// A segment's valve does not close.
    ValveStuckOpen,
    /// A segment's valve does not open.
    ValveStuckClosed,
    /// The dump valve does not close.
    DumpStuckOpen,
    /// The dump valve does not open.
    DumpStuckClosed,
    /// A chamber leaks slowly: 0.0001 to 0.0005 NL/(s bar).
    LeakSlow,
    /// A chamber bursts: 0.01 to 0.1 NL/(s bar).
    LeakBurst,
    /// Something is in a segment's way.
    FingerBlocked,
    /// A segment is pushed by 25 to 75 degrees.
    FingerPushed,
    /// The host that drives the finger falls silent.
    LinkLost,
    /// Control ticks come late.
    TickOverrun,
    /// The control task hangs until the watchdog bites.
    TaskHang,
    /// The supply dips.
    PowerDip,
    /// The stored settings are damaged at the start.
    SettingsCorrupt,
    /// A hole in the manifold, or a dump valve that does not seal: 0.001 to 0.01 NL/(s bar).
    ManifoldLeak,
    /// Cold valves: all dead times are twice what was drawn, from power-on.
    ColdValves,
    /// A host holds a pressure for longer than a session may last.
    SessionTime,
    /// A host asks for more bends than a session may have.
    SessionCycles,
}

/// Faults found by what the air does, whatever part is to blame: any of them is as good as another when it comes to venting.
const PNEUMATIC: [Fault; 28] = [
    Fault::OverPressure,
    Fault::OverPressureSwitch,
    Fault::PressureRate,
    Fault::PressureSensorStuck,
    Fault::SwitchDisagrees,
    Fault::SelfTest(Part::PressureSensor),
    Fault::SelfTest(Part::Pump),
    Fault::SelfTest(Part::PumpStuckOn),
    Fault::SelfTest(Part::Tightness),
    Fault::SelfTest(Part::SegmentValve(Segment::Proximal)),
    Fault::SelfTest(Part::SegmentValve(Segment::Middle)),
    Fault::SelfTest(Part::SegmentValve(Segment::Distal)),
    Fault::SelfTest(Part::Dump),
    Fault::SelfTest(Part::Venting),
    Fault::SegmentValveStuckOpen(Segment::Proximal),
    Fault::SegmentValveStuckOpen(Segment::Middle),
    Fault::SegmentValveStuckOpen(Segment::Distal),
    Fault::SegmentValveStuckClosed(Segment::Proximal),
    Fault::SegmentValveStuckClosed(Segment::Middle),
    Fault::SegmentValveStuckClosed(Segment::Distal),
    Fault::DumpStuckOpen,
    Fault::DumpStuckClosed,
    Fault::PumpStuckOn,
    Fault::PumpNotDelivering,
    Fault::LeakBurst,
    Fault::AirDisagrees,
    Fault::BendDisagrees,
    Fault::PressureSensorNoisy,
];

fn set(faults: &[Fault]) -> FaultSet {
    faults.iter().fold(FaultSet::EMPTY, |set, &fault| set.union(FaultSet::of(fault)))
}

impl Kind {
    /// All, in the matrix's order.
    pub const ALL: [Self; 30] = [
        Self::PressureSensorOpen,
        Self::PressureSensorShort,
        Self::PressureSensorFrozen,
        Self::PressureSensorNoisy,
        Self::SwitchStuckOpen,
        Self::SwitchStuckClosed,
        Self::BendSensorOpen,
        Self::BendSensorShort,
        Self::BendSensorFrozen,
        Self::EmergencyStop,
        Self::PumpStuckOn,
        Self::PumpDead,
        Self::PumpWeak,
        Self::ValveStuckOpen,
        Self::ValveStuckClosed,
        Self::DumpStuckOpen,
        Self::DumpStuckClosed,
        Self::LeakSlow,
        Self::LeakBurst,
        Self::FingerBlocked,
        Self::FingerPushed,
        Self::LinkLost,
        Self::TickOverrun,
        Self::TaskHang,
        Self::PowerDip,
        Self::SettingsCorrupt,
        Self::ManifoldLeak,
        Self::ColdValves,
        Self::SessionTime,
        Self::SessionCycles,
    ];

    /// Those that are drawn when nothing else is asked for: a session's limits take an hour a run.
    pub const DRAWN: &[Self] = Self::ALL.split_at(28).0;

    /// Its name on the command line and in tables.
    #[must_use]
    pub fn name(self) -> String {
        kebab(&format!("{self:?}"))
    }

    /// The kind of this name.
    ///
    /// # Errors
    /// Names those that there are.
    pub fn find(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let known: Vec<_> = Self::ALL.iter().map(|kind| kind.name()).collect();
            format!("no fault is named {name:?}; there are {}", known.join(", "))
        })
    }

    /// The faults that call it by its name, where it may be in any segment: in this one.
    #[must_use]
    pub fn named(self, segment: Segment) -> FaultSet {
        let tested = |part| Fault::SelfTest(part);
        set(&match self {
            Self::PressureSensorOpen => vec![Fault::PressureSensorBelowRange],
            Self::PressureSensorShort => vec![Fault::PressureSensorAboveRange],
            Self::PressureSensorFrozen => vec![Fault::PressureSensorStuck, tested(Part::PressureSensor)],
            Self::PressureSensorNoisy => vec![Fault::PressureSensorNoisy],
            Self::SwitchStuckOpen | Self::SwitchStuckClosed => vec![Fault::SwitchDisagrees],
            Self::BendSensorOpen | Self::BendSensorShort | Self::BendSensorFrozen => {
                vec![Fault::BendSensorFailed, tested(Part::BendSensor)]
            }
            Self::EmergencyStop => vec![Fault::EmergencyStop],
            Self::PumpStuckOn => vec![Fault::PumpStuckOn, tested(Part::PumpStuckOn)],
            Self::PumpDead | Self::PumpWeak => vec![Fault::PumpNotDelivering, tested(Part::Pump)],
            Self::ValveStuckOpen => {
                vec![Fault::SegmentValveStuckOpen(segment), tested(Part::SegmentValve(segment))]
            }
            Self::ValveStuckClosed => {
                vec![Fault::SegmentValveStuckClosed(segment), tested(Part::SegmentValve(segment))]
            }
            Self::DumpStuckOpen => vec![Fault::DumpStuckOpen, tested(Part::Dump)],
            Self::DumpStuckClosed => vec![Fault::DumpStuckClosed, tested(Part::Dump)],
            Self::LeakSlow => vec![Fault::LeakSlow],
            Self::LeakBurst => vec![Fault::LeakBurst, tested(Part::Tightness)],
            Self::FingerBlocked | Self::FingerPushed => vec![Fault::BendDisagrees],
            Self::LinkLost => vec![Fault::LinkLost],
            Self::TickOverrun => vec![Fault::TickOverrun],
            Self::TaskHang => vec![Fault::TaskHang],
            Self::PowerDip => vec![Fault::PowerDip],
            Self::SettingsCorrupt => vec![Fault::SettingsCorrupt],
            // Hose, fitting or the valve's seat: nothing tells where the manifold's air goes.
            Self::ManifoldLeak => {
                vec![Fault::DumpStuckOpen, Fault::LeakBurst, tested(Part::Dump), tested(Part::Tightness)]
            }
            Self::ColdValves => {
                let valves = Segment::ALL.map(|segment| tested(Part::SegmentValve(segment)));
                valves.into_iter().chain([tested(Part::Dump)]).collect()
            }
            Self::SessionTime => vec![Fault::SessionTime],
            Self::SessionCycles => vec![Fault::SessionCycles],
        })
    }

    /// The faults that count as its detection: those that name it, and for everything that the air tells of any other found
    /// by the air. Which part it is the diagnosis after venting says, or nobody. What calls for venting is not detected by what
    /// does not vent.
    #[must_use]
    pub fn accepted(self, segment: Segment) -> FaultSet {
        let named = self.named(segment);
        match self {
            Self::EmergencyStop
            | Self::BendSensorOpen
            | Self::BendSensorShort
            | Self::LinkLost
            | Self::TickOverrun
            | Self::TaskHang
            | Self::PowerDip
            | Self::SettingsCorrupt
            | Self::SessionTime
            | Self::SessionCycles => named,
            Self::BendSensorFrozen => named.union(FaultSet::of(Fault::BendDisagrees)),
            _ => named.union(set(&PNEUMATIC)),
        }
    }

    /// The row of the fault table that bounds its detection: the first fault that names it.
    fn row(self) -> &'static model_core::supervisor::fault::Row {
        let first = match self {
            Self::SwitchStuckClosed => Fault::OverPressureSwitch,
            Self::BendSensorOpen | Self::BendSensorShort | Self::BendSensorFrozen => Fault::BendSensorFailed,
            Self::ValveStuckOpen => Fault::SegmentValveStuckOpen(Segment::Proximal),
            Self::ValveStuckClosed => Fault::SegmentValveStuckClosed(Segment::Proximal),
            Self::PumpStuckOn => Fault::PumpStuckOn,
            Self::PumpDead | Self::PumpWeak => Fault::PumpNotDelivering,
            Self::DumpStuckOpen | Self::ManifoldLeak => Fault::DumpStuckOpen,
            Self::ColdValves => Fault::SelfTest(Part::Dump),
            Self::DumpStuckClosed => Fault::DumpStuckClosed,
            Self::LeakBurst => Fault::LeakBurst,
            Self::PressureSensorFrozen => Fault::PressureSensorStuck,
            _ => self.named(Segment::Proximal).iter().next().unwrap_or(Fault::OverPressure),
        };
        TABLE.iter().find(|row| row.fault == first).expect("every fault has its row")
    }

    /// Longest time from when it shows until it must be detected, ms: the fault table's. What first shows in a self test has
    /// that test's time.
    #[must_use]
    pub fn bound_ms(self, in_self_test: bool) -> u32 {
        let test = TABLE.iter().find(|row| in_self_test && row.fault == Fault::SelfTest(Part::Venting));
        self.row().detect_within_ms.max(test.map_or(0, |row| row.detect_within_ms))
    }

    /// What it breaks: of two faults on one part only one would be there. Where each segment has one of its own, in this one.
    #[must_use]
    pub fn part(self, segment: Segment) -> String {
        match self {
            Self::PressureSensorOpen
            | Self::PressureSensorShort
            | Self::PressureSensorFrozen
            | Self::PressureSensorNoisy => "pressure sensor".to_owned(),
            Self::SwitchStuckOpen | Self::SwitchStuckClosed => "pressure switch".to_owned(),
            Self::BendSensorOpen | Self::BendSensorShort | Self::BendSensorFrozen => "bend sensor".to_owned(),
            Self::PumpStuckOn | Self::PumpDead | Self::PumpWeak => "pump".to_owned(),
            Self::DumpStuckOpen | Self::DumpStuckClosed => "dump valve".to_owned(),
            Self::ValveStuckOpen | Self::ValveStuckClosed => format!("{} valve", segment.name()),
            Self::LeakSlow | Self::LeakBurst => format!("{} chamber", segment.name()),
            Self::ManifoldLeak => "manifold".to_owned(),
            Self::FingerBlocked | Self::FingerPushed => format!("{} segment", segment.name()),
            Self::EmergencyStop
            | Self::LinkLost
            | Self::TickOverrun
            | Self::TaskHang
            | Self::PowerDip
            | Self::SettingsCorrupt
            | Self::ColdValves
            | Self::SessionTime
            | Self::SessionCycles => self.name(),
        }
    }

    /// Whether it calls for venting, as the fault table says.
    #[must_use]
    pub fn vents(self) -> bool {
        self.row().action == Action::Vent
    }
}

/// `LinkLost` as `link-lost`, and `SelfTest(Pump)` as `self-test-pump`.
#[must_use]
pub fn kebab(debug: &str) -> String {
    let mut out = String::new();
    for letter in debug.chars() {
        if letter.is_ascii_uppercase() && !out.is_empty() {
            out.push('-');
        }
        if letter.is_ascii_alphanumeric() {
            out.push(letter.to_ascii_lowercase());
        }
    }
    out
}

/// A fault of the core as tables name it.
#[must_use]
pub fn fault_name(fault: Fault) -> String {
    kebab(&format!("{fault:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_found_and_kebab() {
        for (index, kind) in Kind::ALL.into_iter().enumerate() {
            assert_eq!(Kind::find(&kind.name()), Ok(kind));
            assert_eq!(Kind::ALL.iter().position(|&other| other == kind), Some(index));
        }
        assert!(Kind::find("gremlins").expect_err("unknown").contains("link-lost"));
        let valve = Fault::SelfTest(Part::SegmentValve(Segment::Middle));
        assert_eq!(fault_name(valve), "self-test-segment-valve-middle");
    }

    #[test]
    fn what_names_a_kind_is_accepted_and_bounds_it() {
        for kind in Kind::ALL {
            for segment in Segment::ALL {
                let (named, accepted) = (kind.named(segment), kind.accepted(segment));
                assert!(!named.is_empty() && named.without(accepted).is_empty(), "{kind:?}");
            }
            assert!((1..=60_000).contains(&kind.bound_ms(false)), "{kind:?}");
        }
        assert!(Kind::EmergencyStop.vents() && !Kind::BendSensorOpen.vents());
    }
}
