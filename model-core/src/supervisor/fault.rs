//! Every fault by name and number, and what kinds of answer there are. The answers themselves are in
//! [`TABLE`].

use super::table::TABLE;
use crate::actuation::Segment;
use crate::self_test::Part;

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The manifold's pressure is above the limit.
    OverPressure,
    /// The pressure switch closed.
    OverPressureSwitch,
    /// The pressure sensor is below its electrical range: a broken wire.
    PressureSensorBelowRange,
    /// The pressure sensor is above its electrical range: a short.
    PressureSensorAboveRange,
    /// The emergency stop was pressed.
    EmergencyStop,
    /// The manifold's pressure changes faster than pump and chambers can change it.
    PressureRate,
    /// The pressure sensor's reading does not move, though it must.
    PressureSensorStuck,
    /// The pressure sensor's reading jumps about.
    PressureSensorNoisy,
    /// Pressure switch and pressure sensor contradict each other.
    SwitchDisagrees,
    /// The self test failed: this does not respond.
    SelfTest(Part),
    /// This segment's valve does not close.
    SegmentValveStuckOpen(Segment),
    /// This segment's valve does not open.
    SegmentValveStuckClosed(Segment),
    /// The dump valve does not close.
    DumpStuckOpen,
    /// The dump valve does not open.
    DumpStuckClosed,
    /// The pump runs though it is commanded off.
    PumpStuckOn,
    /// The pump is commanded on and delivers little or nothing.
    PumpNotDelivering,
    /// Air is lost slowly: the regulator can keep the pressure.
    LeakSlow,
    /// Air is lost faster than the regulator may make up for.
    LeakBurst,
    /// The manifold's pressure does not move as pump, dump and valves must move it.
    AirDisagrees,
    /// The finger's bend is not what its pressures give: it is obstructed or pushed, or a pressure is not what it seems.
    BendDisagrees,
    /// The bend sensor fails.
    BendSensorFailed,
    /// Control ticks come late again and again.
    TickOverrun,
    /// A task hung, and the watchdog restarted the firmware.
    TaskHang,
    /// The host that drives the finger is silent.
    LinkLost,
    /// The supply dipped, and the firmware was restarted.
    PowerDip,
    /// Stored settings are damaged; the defaults are in use.
    SettingsCorrupt,
    /// The session lasted its longest time.
    SessionTime,
    /// The session had its largest number of bends.
    SessionCycles,
}

impl Fault {
    /// The fault with this number.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        let [proximal, middle, distal] = Segment::ALL;
        Some(match code {
            0 => Self::OverPressure,
            1 => Self::OverPressureSwitch,
            2 => Self::PressureSensorBelowRange,
            3 => Self::PressureSensorAboveRange,
            4 => Self::EmergencyStop,
            5 => Self::PressureRate,
            6 => Self::PressureSensorStuck,
            7 => Self::PressureSensorNoisy,
            8 => Self::SwitchDisagrees,
            16..=25 => return Part::ALL.into_iter().find(|part| part.code() + 16 == code).map(Self::SelfTest),
            32 => Self::SegmentValveStuckOpen(proximal),
            33 => Self::SegmentValveStuckOpen(middle),
            34 => Self::SegmentValveStuckOpen(distal),
            35 => Self::SegmentValveStuckClosed(proximal),
            36 => Self::SegmentValveStuckClosed(middle),
            37 => Self::SegmentValveStuckClosed(distal),
            38 => Self::DumpStuckOpen,
            39 => Self::DumpStuckClosed,
            40 => Self::PumpStuckOn,
            41 => Self::PumpNotDelivering,
            42 => Self::LeakSlow,
            43 => Self::LeakBurst,
            44 => Self::AirDisagrees,
            48 => Self::BendDisagrees,
            49 => Self::BendSensorFailed,
            56 => Self::TickOverrun,
            57 => Self::TaskHang,
            58 => Self::LinkLost,
            59 => Self::PowerDip,
            60 => Self::SettingsCorrupt,
            61 => Self::SessionTime,
            62 => Self::SessionCycles,
            _ => return None,
        })
    }

    /// A number that stays the same from version to version, 0..=62: its bit in a [`FaultSet`].
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::OverPressure => 0,
            Self::OverPressureSwitch => 1,
            Self::PressureSensorBelowRange => 2,
            Self::PressureSensorAboveRange => 3,
            Self::EmergencyStop => 4,
            Self::PressureRate => 5,
            Self::PressureSensorStuck => 6,
            Self::PressureSensorNoisy => 7,
            Self::SwitchDisagrees => 8,
            Self::SelfTest(part) => 16 + part.code(),
            Self::SegmentValveStuckOpen(segment) => 32 + segment as u8,
            Self::SegmentValveStuckClosed(segment) => 35 + segment as u8,
            Self::DumpStuckOpen => 38,
            Self::DumpStuckClosed => 39,
            Self::PumpStuckOn => 40,
            Self::PumpNotDelivering => 41,
            Self::LeakSlow => 42,
            Self::LeakBurst => 43,
            Self::AirDisagrees => 44,
            Self::BendDisagrees => 48,
            Self::BendSensorFailed => 49,
            Self::TickOverrun => 56,
            Self::TaskHang => 57,
            Self::LinkLost => 58,
            Self::PowerDip => 59,
            Self::SettingsCorrupt => 60,
            Self::SessionTime => 61,
            Self::SessionCycles => 62,
        }
    }

    /// How urgent its alarm is.
    #[must_use]
    pub const fn priority(self) -> Priority {
        FaultSet::of(self).priority_or_low()
    }

    /// What is done at once.
    #[must_use]
    pub const fn action(self) -> Action {
        let bit = FaultSet::of(self);
        if bit.intersects(FaultSet::VENTING) {
            Action::Vent
        } else if bit.intersects(FaultSet::FALLING_BACK) {
            Action::FallBackToPressure
        } else {
            Action::Warn
        }
    }

    /// How it is cleared.
    #[must_use]
    pub const fn clearing(self) -> Clearing {
        if FaultSet::of(self).intersects(FaultSet::TESTED) { Clearing::CommandThenSelfTest } else { Clearing::Command }
    }
}

/// Urgency of an alarm, in the order of IEC 60601-1-8: how soon harm may come, and how bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Priority {
    /// The operator should know.
    Low,
    /// The operator should act soon: treatment has ended, the finger is vented.
    Medium,
    /// The operator must act at once: what vents the finger, or what watches it, may have failed.
    High,
}

impl Priority {
    /// The lower-case name used in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }
}

/// What a fault makes the controller do at once. Every fault latches and raises its alarm beside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Pump off, every passage open, whatever ran has ended.
    Vent,
    /// What runs goes on, on the pressures alone.
    FallBackToPressure,
    /// What runs goes on.
    Warn,
}

/// How a fault is cleared. No fault clears by itself, and nothing that it ended goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clearing {
    /// By command, once its cause is gone.
    Command,
    /// By command, once its cause is gone; the self test must then pass before anything is taken.
    CommandThenSelfTest,
}

/// One fault's line in the [`TABLE`].
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Which.
    pub fault: Fault,
    /// When it is found.
    pub condition: &'static str,
    /// Longest time, ms, from when the fault shows in a true quantity until it is latched.
    pub detect_within_ms: u32,
    /// What is done at once.
    pub action: Action,
    /// How urgent its alarm is.
    pub priority: Priority,
    /// How it is cleared.
    pub clearing: Clearing,
    /// What must be gone before it can be cleared.
    pub clears_when: &'static str,
}

/// Any number of faults: the bit with the number of [`Fault::code`] stands for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaultSet(u64);

impl FaultSet {
    /// None.
    pub const EMPTY: Self = Self(0);
    /// Those that vent.
    pub const VENTING: Self = Self::from_table(Select::Action(Action::Vent));
    /// Those that take the bend from the pressures.
    pub const FALLING_BACK: Self = Self::from_table(Select::Action(Action::FallBackToPressure));
    /// Those after which the self test must pass.
    pub const TESTED: Self = Self::from_table(Select::Clearing(Clearing::CommandThenSelfTest));
    const HIGH: Self = Self::from_table(Select::Priority(Priority::High));
    const MEDIUM: Self = Self::from_table(Select::Priority(Priority::Medium));

    /// One fault alone.
    #[must_use]
    pub const fn of(fault: Fault) -> Self {
        // Every code is below 64; the remainder says so to the compiler.
        Self(1 << (fault.code() % 64))
    }

    /// From bits as [`Self::bits`] gives them; bits that no fault has stand for nothing.
    #[must_use]
    pub const fn from_bits(bits: u64) -> Self {
        Self(bits)
    }

    /// One bit a fault, at the number of its code.
    #[must_use]
    pub const fn bits(self) -> u64 {
        self.0
    }

    /// Adds a fault.
    pub const fn insert(&mut self, fault: Fault) {
        self.0 |= Self::of(fault).0;
    }

    /// This and one more.
    #[must_use]
    pub const fn with(mut self, fault: Fault) -> Self {
        self.insert(fault);
        self
    }

    /// Whether `fault` is in it.
    #[must_use]
    pub const fn contains(self, fault: Fault) -> bool {
        self.intersects(Self::of(fault))
    }

    /// Whether a fault is in both.
    #[must_use]
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// All of both.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Those of this that are not in `other`.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The codes of all that is in it, rising; those of faults that this version does not know as well.
    pub fn codes(self) -> impl Iterator<Item = u8> {
        (0..64).filter(move |&code| self.0 >> code & 1 == 1)
    }

    /// The faults, by rising code.
    pub fn iter(self) -> impl Iterator<Item = Fault> {
        self.codes().filter_map(Fault::from_code)
    }

    /// The most urgent one's priority; none when there is no fault.
    #[must_use]
    pub const fn priority(self) -> Option<Priority> {
        if self.is_empty() { None } else { Some(self.priority_or_low()) }
    }

    const fn priority_or_low(self) -> Priority {
        if self.intersects(Self::HIGH) {
            Priority::High
        } else if self.intersects(Self::MEDIUM) {
            Priority::Medium
        } else {
            Priority::Low
        }
    }

    /// The table's rows with one property, made when the core is compiled: the table itself costs no flash.
    const fn from_table(select: Select) -> Self {
        let mut set = Self::EMPTY;
        let mut index = 0;
        while index < TABLE.len() {
            let row = &TABLE[index];
            let selected = match select {
                Select::Action(action) => action as u8 == row.action as u8,
                Select::Priority(priority) => priority as u8 == row.priority as u8,
                Select::Clearing(clearing) => clearing as u8 == row.clearing as u8,
            };
            if selected {
                set.insert(row.fault);
            }
            index += 1;
        }
        set
    }
}

/// A property of a row.
#[derive(Clone, Copy)]
enum Select {
    Action(Action),
    Priority(Priority),
    Clearing(Clearing),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_one_row_and_its_properties_are_the_rows() {
        let known: Vec<Fault> = (0..=u8::MAX).filter_map(Fault::from_code).collect();
        for &fault in &known {
            assert_eq!(Fault::from_code(fault.code()), Some(fault));
            assert!(fault.code() < 63, "{fault:?}");
            let rows: Vec<_> = TABLE.iter().filter(|row| row.fault == fault).collect();
            assert_eq!(rows.len(), 1, "{fault:?}");
            let row = rows[0];
            assert_eq!((fault.action(), fault.priority()), (row.action, row.priority), "{fault:?}");
            assert_eq!(fault.clearing(), row.clearing, "{fault:?}");
        }
        assert_eq!(known.len(), TABLE.len());
    }

    #[test]
    fn a_set_keeps_what_it_is_given() {
        let mut set = FaultSet::EMPTY;
        assert_eq!(set.priority(), None);
        for row in TABLE {
            assert!(!set.contains(row.fault));
            set.insert(row.fault);
            assert!(set.contains(row.fault));
        }
        assert_eq!(set.iter().count(), TABLE.len());
        assert_eq!(set.priority(), Some(Priority::High));
        assert_eq!(FaultSet::from_bits(set.bits()), set);
        assert!(set.without(set).is_empty());
        assert_eq!(FaultSet::EMPTY.union(set), set);
    }
}
