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
const TESTED: &str = "always";
const READING_IS_BACK: &str = "the reading is plausible and below the limit";
const STUCK_OPEN: &str = "opening any other valve shares the air with this chamber too (diagnosis)";
const STUCK_CLOSED: &str = "opening it leaves the manifold's pressure as it was (diagnosis)";

/// The rows, by rising code.
pub const TABLE: [Row; 40] = [
    row(Fault::OverPressure, "manifold above 168 kPa for 5 ms", 10, Vent, High, Command, READING_IS_BACK),
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
        "manifold changes by more than 36 kPa in 4 ms: faster than three full chambers can fill it",
        10,
        Vent,
        High,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::PressureSensorStuck,
        "reading has no noise, and moves by less than a quarter of what pump or dump must move it at the least",
        12000,
        Vent,
        High,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::PressureSensorNoisy,
        "mean absolute second difference of the reading above 2 kPa for 20 ms",
        200,
        Vent,
        Medium,
        CommandThenSelfTest,
        "the reading is calm",
    ),
    row(
        Fault::SwitchDisagrees,
        "switch closed for 100 ms with the reading below 140 kPa, or open for 5 ms with it above 170 kPa",
        110,
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
    row(Fault::SegmentValveStuckOpen(Segment::Proximal), STUCK_OPEN, 12_000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(Fault::SegmentValveStuckOpen(Segment::Middle), STUCK_OPEN, 12_000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(Fault::SegmentValveStuckOpen(Segment::Distal), STUCK_OPEN, 12_000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(
        Fault::SegmentValveStuckClosed(Segment::Proximal),
        STUCK_CLOSED,
        12_000,
        Vent,
        High,
        CommandThenSelfTest,
        TESTED,
    ),
    row(Fault::SegmentValveStuckClosed(Segment::Middle), STUCK_CLOSED, 10_000, Vent, High, CommandThenSelfTest, TESTED),
    row(Fault::SegmentValveStuckClosed(Segment::Distal), STUCK_CLOSED, 10_000, Vent, High, CommandThenSelfTest, TESTED),
    row(
        Fault::DumpStuckOpen,
        "the manifold, shut off, falls by more than 8 kPa and a sixteenth",
        12000,
        Vent,
        Medium,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::DumpStuckClosed,
        "dump open for 32 ms, pump off for 120 ms: pressure falls by less than a quarter of what the slowest plant's does",
        12000,
        Vent,
        High,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::PumpStuckOn,
        "pump off for 120 ms: the manifold rises 10 kPa above all that was there, or 8 kPa when shut off",
        3000,
        Vent,
        High,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::PumpNotDelivering,
        "pump on for 32 ms and the pressure rises by less than a quarter of what the weakest pump gives; or a chamber 10 kPa short of a setpoint that has rested for 12 s",
        13000,
        Vent,
        Medium,
        CommandThenSelfTest,
        TESTED,
    ),
    row(
        Fault::LeakSlow,
        "setpoints at rest for 1 s: a chamber lost 6 kPa beside 0.4 kPa/s, in small steps, top-ups not counted",
        30000,
        Warn,
        Low,
        Command,
        TESTED,
    ),
    row(Fault::LeakBurst, "the same with 10 kPa, or 25 kPa at once", 12000, Vent, Medium, CommandThenSelfTest, TESTED),
    row(
        Fault::BendDisagrees,
        "bend differs from the model's of the estimated pressures for 240 ms by more than 16..37 degrees and a sixteenth, and 1.25 times the way still to go in motion",
        2000,
        Vent,
        Medium,
        CommandThenSelfTest,
        "the bend is near zero",
    ),
    row(
        Fault::BendSensorFailed,
        "reading outside its electrical range for 5 ms; or it stands still while it disagrees",
        12000,
        FallBackToPressure,
        Low,
        Command,
        "the reading is plausible",
    ),
    row(
        Fault::TickOverrun,
        "more late ticks than one in 100, by ten",
        1000,
        Vent,
        Medium,
        Command,
        "no late tick for a second",
    ),
    row(Fault::TaskHang, "the watchdog, or a panic, restarted the firmware", 200, Vent, High, Command, "always"),
    row(
        Fault::LinkLost,
        "no valid frame for 1 s while a host drives the finger by hand",
        1001,
        Vent,
        Medium,
        Command,
        "a frame was heard",
    ),
    row(Fault::PowerDip, "brown-out reset", 200, Vent, Medium, Command, "always"),
    row(
        Fault::SettingsCorrupt,
        "no stored record is whole, and there are damaged ones",
        200,
        Vent,
        Medium,
        Command,
        "-",
    ),
    row(Fault::SessionTime, "under pressure for 60 min in a session", 1, Vent, Low, Command, "always"),
    row(Fault::SessionCycles, "2000 bends in a session", 1, Vent, Low, Command, "always"),
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
