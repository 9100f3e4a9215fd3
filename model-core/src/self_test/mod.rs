//! Power-on self test: pump, valves, dump and sensors show that they respond before a finger is moved.
//!
//! ```text
//! Resting ─▶ Closing ─▶ Charging ─▶ Settling ─▶ Holding ─▶ Opening ─▶ (each segment, then the dump) ─▶ Venting ─▶ passed
//! ```
//!
//! Everything is closed and the manifold alone is charged with a little air. It must rise while the pump runs, stop when
//! it stops, stay while all is closed, and fall when the part under test opens. A finger's chambers see what one manifold
//! holds at a time: with host-sim's plant at most 14 kPa, and the manifold at most 42 kPa; 18 and 53 kPa with a relay twice as
//! slow (`cargo test -p finger-tests --test self_test -- --nocapture`).
//!
//! The same flows are measured on the way: pump, valves and chambers as they are, for the observer ([`SelfTest::measured`]).

mod measurement;

use crate::actuation::{Actuation, Passage, Segment};
use crate::controller::{Fault, Inputs, Reading};
use crate::observer::Pneumatics;
use crate::units::Pressure;
use measurement::Measurement;

/// What did not respond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The pressure sensor fails, or is not near zero with everything open.
    PressureSensor,
    /// The bend sensor fails.
    BendSensor,
    /// The pressure does not rise while the pump runs: pump, relay or pressure sensor.
    Pump,
    /// The pressure rises after the pump was stopped.
    PumpStuckOn,
    /// The pressure falls or rises too little with everything closed: the dump valve does not close, a segment valve has ceased to, or
    /// something leaks.
    Tightness,
    /// Opening this valve changes nothing: it does not open, or did not close.
    SegmentValve(Segment),
    /// Opening the dump valve does not let the pressure out.
    Dump,
    /// The finger does not reach atmosphere with everything open.
    Venting,
}

impl Part {
    /// Every part.
    pub const ALL: [Self; 10] = [
        Self::PressureSensor,
        Self::BendSensor,
        Self::Pump,
        Self::PumpStuckOn,
        Self::Tightness,
        Self::SegmentValve(Segment::Proximal),
        Self::SegmentValve(Segment::Middle),
        Self::SegmentValve(Segment::Distal),
        Self::Dump,
        Self::Venting,
    ];

    /// A number that stays the same from version to version, 0..=9.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::PressureSensor => 0,
            Self::BendSensor => 1,
            Self::Pump => 2,
            Self::PumpStuckOn => 3,
            Self::Tightness => 4,
            Self::SegmentValve(segment) => 5 + segment as u8,
            Self::Dump => 8,
            Self::Venting => 9,
        }
    }
}

/// How it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Drive this, and go on.
    Testing(Actuation),
    /// Everything responds; vented.
    Passed,
    /// This does not; vent.
    Failed(Part),
}

/// Near atmosphere: the sensor's zero error (2 kPa) and its noise.
const AT_ATMOSPHERE: Pressure = Pressure::from_kpa(4);
/// With everything open it has to be there for this long: a chamber that still vents lifts the manifold.
const REST_TICKS: u16 = 400;
/// Chambers at 150 kPa vent in 1.6 s; half as fast, with as much to spare.
const REST_LIMIT: u16 = 5000;
/// Dead time of the valves, twice the nominal.
const CLOSING_TICKS: u16 = 20;
/// The pump is stopped here; what it delivers while it runs down takes the manifold to about 30 kPa.
const CHARGED: Pressure = Pressure::from_kpa(12);
/// ... and at least so much above what the opening before has left.
const CHARGED_BY: Pressure = Pressure::from_kpa(6);
/// With more than this left the finger vents before the next charge: of a strong pump with a late relay each would lift the next.
const LEFT_AT_MOST: Pressure = Pressure::from_kpa(18);
/// A nominal pump needs 45 ms, one with half its flow and twice its dead time 80 ms. A sensor that does not move lets a
/// nominal pump reach 80 kPa in the manifold, and no chamber.
const CHARGE_LIMIT: u16 = 110;
/// The relay's dead time twice, the rotor's run-down, the sensor's lag.
const SETTLING_TICKS: u16 = 90;
const HOLDING_TICKS: u16 = 60;
/// While all is closed the pressure may fall by the gas cooling and the sensor's noise.
const HOLD_LOSS: Pressure = Pressure::from_kpa(4);
/// A pump that runs on adds 60 kPa in that time.
const HOLD_GAIN: Pressure = Pressure::from_kpa(6);
/// A chamber has taken two thirds of the manifold's air by then, the open dump all of it.
const OPENED_TICKS: u16 = 120;
/// The bend comes to rest, and the volume with it: only then it is measured.
const OPENING_TICKS: u16 = 240;
/// Share of its pressure, in percent, above which a manifold that opens to one chamber must have been open to another.
const KEPT_WITH_ANOTHER: i64 = 54;
/// The pump charges one and the same manifold each time. When a charge rises by less than this share, in percent, of the first one's
/// for each tick of the pump, it has filled a chamber too: 42 to 57 of 100.
const CHARGED_ALONE: i64 = 75;

/// See the module's page.
#[derive(Clone, Debug)]
pub struct SelfTest {
    phase: Phase,
    ticks: u16,
    /// Segment under test; three is the dump valve.
    part: u8,
    /// Pressure at the phase's start, and once what opened has passed what it can.
    from: Pressure,
    opened: Pressure,
    /// Pressure at the last charge's start, and the pump's ticks in it.
    charge: (Pressure, u16),
    /// What the first charge rose by in each of the pump's ticks, 2^-16 kPa.
    first_charge: i64,
    /// For how long it has rested.
    rested: u16,
    /// A segment whose opening changed nothing; another one's opening tells why.
    suspect: Option<Segment>,
    /// It does not close.
    suspect_is_open: bool,
    measurement: Measurement,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Resting,
    Closing,
    Charging,
    Settling,
    Holding,
    Opening,
    Venting,
}

impl Default for SelfTest {
    fn default() -> Self {
        Self::new()
    }
}

impl SelfTest {
    /// At its start.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            phase: Phase::Resting,
            ticks: 0,
            part: 0,
            from: Pressure::ZERO,
            opened: Pressure::ZERO,
            charge: (Pressure::ZERO, 1),
            first_charge: 0,
            rested: 0,
            suspect: None,
            suspect_is_open: false,
            measurement: Measurement::new(),
        }
    }

    /// Pump, valves and chambers as measured, once it has passed; nominal where it could not tell.
    #[must_use]
    pub fn measured(&self) -> Pneumatics {
        self.measurement.measured()
    }

    /// The fault that the failure of this part means.
    #[must_use]
    pub const fn named(&self, part: Part) -> Fault {
        match part {
            Part::Pump => Fault::PumpNotDelivering,
            Part::PumpStuckOn => Fault::PumpStuckOn,
            Part::Tightness => Fault::DumpStuckOpen,
            Part::Dump => Fault::DumpStuckClosed,
            Part::BendSensor => Fault::BendSensorFailed,
            Part::SegmentValve(segment) if self.suspect_is_open => Fault::SegmentValveStuckOpen(segment),
            Part::SegmentValve(segment) => Fault::SegmentValveStuckClosed(segment),
            Part::PressureSensor | Part::Venting => Fault::SelfTest(part),
        }
    }

    fn enter(&mut self, phase: Phase, pressure: Pressure) {
        (self.phase, self.ticks, self.from, self.rested) = (phase, 0, pressure, 0);
    }

    /// One tick. A sensor that is electrically out of its range for a tick is left to the supervisor.
    #[inline(never)] // Twice in the controller: power-on and diagnosis.
    pub fn step(&mut self, inputs: &Inputs) -> Verdict {
        let Reading::Valid(pressure) = inputs.manifold else { return Verdict::Testing(Actuation::SAFE) };
        self.ticks = self.ticks.saturating_add(1);
        self.measurement.read(pressure, inputs.bend);
        match self.phase {
            Phase::Opening => {
                if self.ticks == OPENED_TICKS {
                    self.opened = pressure;
                }
                self.measurement.opens(pressure);
            }
            Phase::Charging => self.measurement.pumps(),
            _ => self.measurement.work(),
        }
        match self.phase {
            Phase::Resting | Phase::Venting => return self.rest(pressure, inputs.bend),
            Phase::Closing if self.ticks >= CLOSING_TICKS => {
                self.measurement.charging();
                self.enter(Phase::Charging, pressure);
            }
            Phase::Charging if pressure >= CHARGED.max(self.from + CHARGED_BY) => {
                self.measurement.stops(pressure);
                self.charge = (self.from, self.ticks);
                self.enter(Phase::Settling, pressure);
            }
            Phase::Charging if self.ticks >= CHARGE_LIMIT => return Verdict::Failed(Part::Pump),
            Phase::Settling if self.ticks >= SETTLING_TICKS => self.enter(Phase::Holding, pressure),
            Phase::Holding if self.ticks >= HOLDING_TICKS => {
                if pressure > self.from + HOLD_GAIN {
                    return Verdict::Failed(Part::PumpStuckOn);
                }
                if pressure < self.from - HOLD_LOSS || pressure < CHARGED - HOLD_LOSS {
                    return Verdict::Failed(Part::Tightness);
                }
                if self.has_filled_more(pressure) {
                    return Verdict::Failed(Part::Tightness);
                }
                self.measurement.charged();
                self.enter(Phase::Opening, pressure);
            }
            Phase::Opening if self.ticks >= OPENING_TICKS => {
                // Nominal: a chamber takes 65 %, the dump 100 %. Noise and zero error make at most 15 %.
                let fallen = self.opened.to_bits() < self.from.to_bits() / 4 * 3;
                if let Some(suspect) = self.suspect {
                    self.suspect_is_open = fallen && self.keeps();
                    return Verdict::Failed(Part::SegmentValve(suspect));
                }
                match (self.segment(), fallen) {
                    (Some(segment), false) => {
                        self.suspect = Some(segment);
                        self.part = u8::from(self.part == 0);
                        // The other chamber may hold air from its own test.
                        self.enter(Phase::Resting, pressure);
                    }
                    (None, false) => return Verdict::Failed(Part::Dump),
                    (Some(segment), true) => {
                        self.measurement.filled(segment as usize);
                        self.part = self.part.saturating_add(1);
                        // Perhaps another chamber is open all the time: its own test tells. It must not be filled further till then.
                        let vents_first = self.keeps() || pressure > LEFT_AT_MOST;
                        self.enter(if vents_first { Phase::Resting } else { Phase::Closing }, pressure);
                    }
                    (None, true) => {
                        self.measurement.dumped();
                        self.enter(Phase::Venting, pressure);
                    }
                }
            }
            _ => {}
        }
        Verdict::Testing(self.actuation())
    }

    /// Whether the manifold, opened to a chamber, keeps more than it can alone. Alone it keeps 30..51 % of its pressure, with one
    /// chamber always open 57..66 %: chambers of 0.7 to 2 times their volume, and a manifold as it should be.
    fn keeps(&self) -> bool {
        i64::from(self.opened.to_bits()) * 100 > i64::from(self.from.to_bits()) * KEPT_WITH_ANOTHER
    }

    /// Whether the charge has filled more than the manifold, by how little it rose: a valve that did close does not any more. One
    /// that never did is found by its own test.
    fn has_filled_more(&mut self, pressure: Pressure) -> bool {
        let (from, ticks) = self.charge;
        let rise = i64::from((pressure - from).to_bits()).checked_div(i64::from(ticks)).unwrap_or(0);
        if self.part == 0 || self.suspect.is_some() {
            self.first_charge = rise;
            return false;
        }
        rise * 100 < self.first_charge * CHARGED_ALONE
    }

    /// Everything open, until atmosphere has lasted.
    fn rest(&mut self, pressure: Pressure, bend: Reading<crate::units::Bend>) -> Verdict {
        self.rested = if pressure.abs() <= AT_ATMOSPHERE { self.rested.saturating_add(1) } else { 0 };
        if self.rested >= REST_TICKS {
            if self.phase == Phase::Venting {
                return Verdict::Passed;
            }
            if !matches!(bend, Reading::Valid(_)) {
                return Verdict::Failed(Part::BendSensor);
            }
            self.measurement.rests();
            self.enter(Phase::Closing, pressure);
            return Verdict::Testing(self.actuation());
        }
        match self.phase {
            _ if self.ticks < REST_LIMIT => Verdict::Testing(Actuation::SAFE),
            Phase::Venting => Verdict::Failed(Part::Venting),
            _ => Verdict::Failed(Part::PressureSensor),
        }
    }

    fn segment(&self) -> Option<Segment> {
        Segment::ALL.get(usize::from(self.part)).copied()
    }

    fn actuation(&self) -> Actuation {
        let mut actuation = Actuation { pump: self.phase == Phase::Charging, ..Actuation::HOLD };
        if self.phase == Phase::Opening {
            match self.segment().and_then(|segment| actuation.segments.get_mut(segment as usize)) {
                Some(valve) => *valve = Passage::Open,
                None => actuation.dump = Passage::Open,
            }
        }
        actuation
    }
}
