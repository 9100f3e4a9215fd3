//! The fault table: the one place that says what each fault is, how soon it is found, what is done, how urgent it is and
//! how it is cleared. `cargo xtask docs` prints it into `docs/faults.md`.
//!
//! The texts are for people at a desk. Nothing on the device refers to the table: what it needs of it are the sets in
//! [`FaultSet`](super::fault::FaultSet), made when it is compiled.

use super::fault::{Action, Clearing, Fault, Priority, Row};
use crate::actuation::Segment;
use crate::self_test::Part;
use Action::{FallBackToPressure, Vent, Warn};
use Clearing::{Command, CommandThenSelfTest};
use Priority::{High, Low, Medium};

const SELF_TEST: &str = "the self test's phase for this part did not end as it must";
const TESTED: &str = "-";
const READING_IS_BACK: &str = "the reading is plausible and below the limit";
const STUCK_OPEN: &str = "opening any other valve shares the air with this chamber too (diagnosis)";
const STUCK_CLOSED: &str = "opening it leaves the manifold's pressure as it was (diagnosis)";

/// The rows, by rising code.
pub const TABLE: [Row; 40] = [
    row(Fault::OverPressure, "manifold above 172 kPa for 5 ms", 10, Vent, High, Command, READING_IS_BACK),
    row(Fault::OverPressureSwitch, "pressure switch closed", 1, Vent, High, Command, "switch open"),
    row(
        Fault::PressureSensorBelowRange,
        "reading below its electrical range for 5 ms (wire break)",
        5,
        Vent,
        High,
        Command,
        READING_IS_BACK,
    ),
    row(
        Fault::PressureSensorAboveRange,
        "reading above its electrical range for 5 ms (short)",
        5,
        Vent,
        High,
        Command,
        READING_IS_BACK,
    ),
    row(Fault::EmergencyStop, "emergency stop pressed, or its loop broken", 1, Vent, High, Command, "stop released"),
    row(
        Fault::PressureRate,
        "manifold changes faster than pump, dump and three open chambers together can change it",
        40,
        Vent,
        High,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::PressureSensorStuck,
        "reading moves less than its own noise while pump or dump must move it",
        1000,
        Vent,
        High,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::PressureSensorNoisy,
        "mean absolute second difference of the reading above 4 kPa",
        200,
        Vent,
        Medium,
        CommandThenSelfTest,
        "the reading is calm",
    ),
    row(
        Fault::SwitchDisagrees,
        "switch closed while the reading is far below its threshold, or open while the reading is above it",
        100,
        Vent,
        High,
        CommandThenSelfTest,
        "switch open",
    ),
    row(Fault::SelfTest(Part::PressureSensor), SELF_TEST, 6000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(Fault::SelfTest(Part::BendSensor), SELF_TEST, 6000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(Fault::SelfTest(Part::Pump), SELF_TEST, 6000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(Fault::SelfTest(Part::PumpStuckOn), SELF_TEST, 6000, Vent, High, CommandThenSelfTest, TESTED),
    row(Fault::SelfTest(Part::Tightness), SELF_TEST, 6000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(
        Fault::SelfTest(Part::SegmentValve(Segment::Proximal)),
        SELF_TEST,
        6000,
        Vent,
        Medium,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::SelfTest(Part::SegmentValve(Segment::Middle)),
        SELF_TEST,
        6000,
        Vent,
        Medium,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::SelfTest(Part::SegmentValve(Segment::Distal)),
        SELF_TEST,
        6000,
        Vent,
        Medium,
        CommandThenSelfTest,
        TESTED,
    ),
    row(Fault::SelfTest(Part::Dump), SELF_TEST, 6000, Vent, High, CommandThenSelfTest, TESTED),
    row(Fault::SelfTest(Part::Venting), SELF_TEST, 6000, Vent, High, CommandThenSelfTest, TESTED),
    row(Fault::SegmentValveStuckOpen(Segment::Proximal), STUCK_OPEN, 20_000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(Fault::SegmentValveStuckOpen(Segment::Middle), STUCK_OPEN, 20_000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(Fault::SegmentValveStuckOpen(Segment::Distal), STUCK_OPEN, 20_000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(
        Fault::SegmentValveStuckClosed(Segment::Proximal),
        STUCK_CLOSED,
        10_000,
        Vent,
        High,
        CommandThenSelfTest,
        TESTED,
    ),
    row(Fault::SegmentValveStuckClosed(Segment::Middle), STUCK_CLOSED, 10_000, Vent, High, CommandThenSelfTest, TESTED),
    row(Fault::SegmentValveStuckClosed(Segment::Distal), STUCK_CLOSED, 10_000, Vent, High, CommandThenSelfTest, TESTED),
    row(
        Fault::DumpStuckOpen,
        "pressure falls, or does not rise, with the dump valve commanded closed",
        2000,
        Vent,
        Medium,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::DumpStuckClosed,
        "pressure does not fall with the dump valve commanded open",
        2000,
        Vent,
        High,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::PumpStuckOn,
        "pressure keeps rising with the pump commanded off for longer than its dead time and run-down",
        500,
        Vent,
        High,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::PumpNotDelivering,
        "pump commanded on and the pressure does not rise by its share",
        2000,
        Vent,
        Medium,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::LeakSlow,
        "a chamber is found lower than it was left, look after look",
        30_000,
        Warn,
        Low,
        Command,
        TESTED,
    ),
    row(
        Fault::LeakBurst,
        "pressure falls with pump off and dump closed, faster than cooling and settling explain",
        2000,
        Vent,
        Medium,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::BendDisagrees,
        "bend differs from the model's bend of the estimated pressures by more than its bound, which grows in motion",
        2000,
        Vent,
        Medium,
        CommandThenSelfTest,
        "the bend is near zero",
    ),
    row(
        Fault::BendSensorFailed,
        "bend reading outside its electrical range for 5 ms, or not moving in a large motion",
        2000,
        FallBackToPressure,
        Low,
        Command,
        "the reading is plausible",
    ),
    row(Fault::TickOverrun, "ten late ticks within a second", 1000, Vent, Medium, Command, "no late tick for a second"),
    row(Fault::TaskHang, "the watchdog restarted the firmware", 200, Vent, High, Command, "-"),
    row(
        Fault::LinkLost,
        "no valid frame for a second while a host drives the finger",
        1001,
        Vent,
        Medium,
        Command,
        "a frame was heard",
    ),
    row(Fault::PowerDip, "brown-out reset", 200, Vent, Medium, Command, "-"),
    row(
        Fault::SettingsCorrupt,
        "no stored record is whole, and there are damaged ones",
        200,
        Vent,
        Medium,
        Command,
        "-",
    ),
    row(Fault::SessionTime, "under pressure for 60 min in a session", 1, Vent, Low, Command, "-"),
    row(Fault::SessionCycles, "2000 bends in a session", 1, Vent, Low, Command, "-"),
];

const fn row(
    fault: Fault,
    condition: &'static str,
    detect_within_ms: u32,
    action: Action,
    priority: Priority,
    clearing: Clearing,
    clears_when: &'static str,
) -> Row {
    Row { fault, condition, detect_within_ms, action, priority, clearing, clears_when }
}
