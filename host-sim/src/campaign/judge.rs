//! Judges a run by the plant's truth and by what the controller latched; what it believed counts for nothing.

use super::draw::{Case, Drawn};
use super::kind::{Kind, fault_name};
use super::shows::{Commanded, Showing, hazards, own_valve_closed};
use super::vent::{HORIZON_MS, Reference, VENTED_KPA};
use crate::plant::Plant;
use model_core::actuation::Actuation;
use model_core::controller::{Mode, Outputs};
use model_core::supervisor::fault::{Clearing, Fault, FaultSet};

/// No chamber may be above this, kPa, ...
pub const LIMIT_KPA: f64 = 165.0;
/// ... for longer than this, ms.
pub const LIMIT_MS: u32 = 20;
/// After venting a diagnosis may look for the part for so long, ms, before the run is ended.
const DIAGNOSIS_MS: u32 = 8000;
/// A diagnosis may lift no chamber above this, kPa: a manifold's air in three chambers, and as much again.
pub const DIAGNOSIS_KPA: f64 = 30.0;
/// The reading is at its range's end from so far before it, degrees: zero and noise.
const RANGE_END_DEG: f64 = 3.0;
/// How much higher than the de-energised plant a chamber may end that cannot vent, kPa.
const SAME_KPA: f64 = 5.0;

/// What a run may break.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Property {
    /// No chamber above 165 kPa for more than 20 ms.
    OverPressure,
    /// Every chamber that can vent is below 10 kPa within 1.5 times the plant's own vent time.
    VentTime,
    /// Every fault that shows is detected within its bound.
    Detection,
    /// Nothing is energised while faulted, beyond what a diagnosis may.
    Energised,
    /// Nothing panics.
    Panic,
}

impl Property {
    /// All, in order.
    pub const ALL: [Self; 5] = [Self::OverPressure, Self::VentTime, Self::Detection, Self::Energised, Self::Panic];
}

/// What the controller did in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// It stepped.
    Ticked,
    /// It did not: it is late, hangs or has no power. Outputs are de-energised when `safe`.
    Missing {
        /// Whether the outputs are de-energised.
        safe: bool,
    },
}

/// How a fault of a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It never showed in a true quantity, or the run was over before it came.
    NotShown,
    /// It showed, and the run ended before its bound.
    Undecided,
    /// Detected this long after it showed, ms; 0 when before.
    Detected {
        /// Time from showing, ms.
        latency_ms: u32,
    },
    /// Not within its bound.
    Missed,
}

/// A fault's fate.
#[derive(Clone, Copy, Debug)]
pub struct Fate {
    /// Which.
    pub drawn: Drawn,
    /// How it ended.
    pub ending: Ending,
    /// Whether a latched fault calls it by its name in the end.
    pub named: bool,
}

/// All that is kept of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Length, ms.
    pub simulated_ms: u32,
    /// Time without any fault and before any alarm, ms.
    pub fault_free_ms: u32,
    /// An alarm while nothing was broken.
    pub false_alarm: Option<Fault>,
    /// The first fault that was latched while something was.
    pub first_alarm: Option<Fault>,
    /// What became of each fault.
    pub fates: Vec<Fate>,
    /// What was broken, and how.
    pub violations: Vec<(Property, String)>,
    /// What physically kept a chamber from venting.
    pub cannot_vent: Option<String>,
    /// What physically kept a chamber above the limit after detection.
    pub unavoidable: Option<String>,
    /// The slowest chamber's vent time over the plant's own, per cent.
    pub vent_percent: Option<u32>,
    /// What happened when, ms.
    pub timeline: Vec<(u32, String)>,
}

/// From the first fault that vents on.
#[derive(Clone, Copy, Debug)]
struct Venting {
    since_ms: u32,
    fault: Fault,
    reference: Reference,
    /// From when on each is below the limit, ms after the detection.
    below_since_ms: [Option<u32>; 3],
}

/// See the module's page.
pub struct Judge<'a> {
    case: &'a Case,
    showings: Vec<Showing>,
    detected: Vec<Option<u32>>,
    named: Vec<bool>,
    commanded: Commanded,
    over_ms: [u32; 3],
    latched: FaultSet,
    all_latched: FaultSet,
    venting: Option<Venting>,
    energised: bool,
    last_mode: Option<Mode>,
    outcome: Outcome,
}

impl<'a> Judge<'a> {
    /// At the run's start.
    #[must_use]
    pub fn new(case: &'a Case) -> Self {
        Self {
            case,
            showings: case.faults.iter().map(|&drawn| Showing::new(drawn)).collect(),
            detected: vec![None; case.faults.len()],
            named: vec![false; case.faults.len()],
            commanded: Commanded::default(),
            over_ms: [0; 3],
            latched: FaultSet::EMPTY,
            all_latched: FaultSet::EMPTY,
            venting: None,
            energised: false,
            last_mode: None,
            outcome: Outcome::default(),
        }
    }

    /// The controller was restarted: nothing is latched.
    pub fn restarted(&mut self) {
        self.latched = FaultSet::EMPTY;
    }

    /// Whether a fault that vents is latched.
    #[must_use]
    pub fn is_venting(&self) -> bool {
        self.venting.is_some()
    }

    fn violate(&mut self, now_ms: u32, property: Property, how: String) {
        if self.outcome.violations.iter().all(|(other, _)| *other != property) {
            self.outcome.timeline.push((now_ms, format!("VIOLATED {property:?}: {how}")));
            self.outcome.violations.push((property, how));
        }
    }

    /// One tick, before the plant moves on; true when there is nothing left to see.
    pub fn tick(
        &mut self,
        now_ms: u32,
        event: Event,
        outputs: Option<&Outputs>,
        actuation: Actuation,
        plant: &Plant,
    ) -> bool {
        let chambers_kpa = plant.chambers_kpa();
        self.commanded.step(actuation);
        self.show(now_ms, event, outputs, actuation, plant);
        if let (Event::Ticked, Some(outputs)) = (event, outputs) {
            self.hear(now_ms, outputs, plant);
            self.energise(now_ms, outputs, actuation, &chambers_kpa);
        }
        let present = self.case.faults.iter().any(|fault| fault.from_ms <= now_ms);
        if !present && self.outcome.false_alarm.is_none() {
            self.outcome.fault_free_ms += 1;
        }
        self.limit(now_ms, &chambers_kpa);
        self.vent(now_ms, &chambers_kpa)
    }

    /// Whether faults show.
    fn show(&mut self, now_ms: u32, event: Event, outputs: Option<&Outputs>, actuation: Actuation, plant: &Plant) {
        let waiting = |(showing, detected): (&Showing, &Option<u32>)| showing.is_present(now_ms) && detected.is_none();
        if self.venting.is_some() || !self.showings.iter().zip(&self.detected).any(waiting) {
            return;
        }
        let truth = plant.truth();
        let faults = self.case.faults.iter().zip(&self.detected);
        for (showing, (drawn, detected)) in self.showings.iter_mut().zip(faults) {
            if !showing.is_present(now_ms) || detected.is_some() {
                continue;
            }
            let before_ms = showing.since_ms;
            if now_ms == drawn.from_ms {
                self.outcome.timeline.push((now_ms, format!("comes {}", describe(drawn))));
            }
            if is_away(drawn.kind, event, actuation) {
                continue;
            }
            showing.tick(now_ms, self.case, &truth, outputs, actuation, &self.commanded);
            if let (Some(since_ms), None) = (showing.since_ms, before_ms) {
                self.outcome.timeline.push((since_ms, format!("shows {}", drawn.kind.name())));
            }
        }
    }

    /// What was latched.
    fn hear(&mut self, now_ms: u32, outputs: &Outputs, plant: &Plant) {
        if self.last_mode != Some(outputs.mode) {
            self.last_mode = Some(outputs.mode);
            self.outcome.timeline.push((now_ms, format!("mode {:?}", outputs.mode)));
        }
        let new = outputs.faults.without(self.latched);
        self.latched = outputs.faults;
        if new.is_empty() && !self.case.faults.iter().any(|fault| fault.from_ms == now_ms) {
            return;
        }
        self.all_latched = self.all_latched.union(new);
        let present: Vec<Drawn> = self.case.faults.iter().copied().filter(|fault| fault.from_ms <= now_ms).collect();
        let mut accepted = FaultSet::EMPTY;
        for fault in &present {
            accepted = accepted.union(fault.kind.accepted(fault.segment));
        }
        for fault in new.iter() {
            self.outcome.timeline.push((now_ms, format!("latched {}", fault_name(fault))));
            if present.is_empty() {
                self.outcome.false_alarm.get_or_insert(fault);
            } else {
                self.outcome.first_alarm.get_or_insert(fault);
            }
            if self.venting.is_none() && FaultSet::of(fault).intersects(FaultSet::VENTING) {
                let more_comes = self.case.faults.iter().any(|fault| fault.from_ms > now_ms);
                let reference = Reference::of(plant, LIMIT_KPA, LIMIT_MS, more_comes);
                self.venting = Some(Venting { since_ms: now_ms, fault, reference, below_since_ms: [None; 3] });
                self.outcome
                    .timeline
                    .push((now_ms, format!("the plant's own vent times: {:?} ms", reference.vented_ms)));
            }
        }
        for (index, drawn) in self.case.faults.iter().enumerate().filter(|(_, drawn)| drawn.from_ms <= now_ms) {
            // What is told already needs no second telling. Of two at once either's venting is enough.
            let own = self.latched.intersects(drawn.kind.accepted(drawn.segment))
                || new.contains(Fault::BendSensorFailed) && is_out_of_range(drawn, self.case, plant);
            let vented = present.len() > 1 && FaultSet::VENTING.intersects(intersection(new, accepted));
            if own || vented {
                self.detected[index].get_or_insert(now_ms);
            }
            self.named[index] |= self.latched.intersects(drawn.kind.named(drawn.segment));
        }
    }

    /// What is energised while a fault that vents is latched.
    fn energise(&mut self, now_ms: u32, outputs: &Outputs, actuation: Actuation, chambers_kpa: &[f64; 3]) {
        let Some(Venting { since_ms, fault, reference, .. }) = self.venting else { return };
        if !self.latched.intersects(FaultSet::VENTING) && !matches!(outputs.mode, Mode::Faulted(_)) {
            return;
        }
        // What leaves through a hole alone, behind its own stuck valve, is nothing that can vent.
        let case = self.case;
        let vents = |chamber: usize| reference.vented_ms[chamber].is_some() && !own_valve_closed(case, now_ms, chamber);
        let energised = actuation != Actuation::SAFE;
        if energised && !self.energised {
            let full = (0..3).find(|&chamber| vents(chamber) && chambers_kpa[chamber] >= VENTED_KPA);
            if let Some(chamber) = full {
                let kpa = chambers_kpa[chamber];
                let after = now_ms - since_ms;
                self.violate(
                    now_ms,
                    Property::Energised,
                    format!("{after} ms after detection, chamber at {kpa:.1} kPa"),
                );
            } else if fault.clearing() != Clearing::CommandThenSelfTest {
                self.violate(now_ms, Property::Energised, format!("after {}, which needs no test", fault_name(fault)));
            } else {
                self.outcome.timeline.push((now_ms, "diagnosis energises".to_owned()));
            }
        }
        if energised {
            let lifted = (0..3).find(|&chamber| chambers_kpa[chamber] > DIAGNOSIS_KPA && vents(chamber));
            if let Some(chamber) = lifted {
                let kpa = chambers_kpa[chamber];
                self.violate(now_ms, Property::Energised, format!("a diagnosis lifts a chamber to {kpa:.1} kPa"));
            }
        }
        self.energised = energised;
    }

    /// No chamber above the limit for longer than its time.
    fn limit(&mut self, now_ms: u32, chambers_kpa: &[f64; 3]) {
        for (chamber, &kpa) in chambers_kpa.iter().enumerate() {
            self.over_ms[chamber] = if kpa > LIMIT_KPA { self.over_ms[chamber] + 1 } else { 0 };
            if self.over_ms[chamber] != LIMIT_MS + 1 {
                continue;
            }
            let compressed = self.is_compressed(now_ms, chamber);
            if compressed || self.venting.is_some_and(|venting| venting.reference.over_pressure) {
                let why = if compressed {
                    "a push compresses the closed chamber".to_owned()
                } else {
                    hazards(self.case, now_ms, chamber).join(" and ")
                };
                self.outcome.timeline.push((now_ms, format!("unavoidably above {LIMIT_KPA} kPa: {why}")));
                self.outcome.unavoidable.get_or_insert(why);
            } else {
                self.violate(
                    now_ms,
                    Property::OverPressure,
                    format!("chamber {chamber} at {kpa:.1} kPa for {LIMIT_MS} ms"),
                );
            }
        }
    }

    /// Venting within its time; true when there is nothing left to see.
    fn vent(&mut self, now_ms: u32, chambers_kpa: &[f64; 3]) -> bool {
        let Some(mut venting) = self.venting else { return false };
        let after_ms = now_ms - venting.since_ms;
        let mut open = false;
        for (chamber, &kpa) in chambers_kpa.iter().enumerate() {
            let Some(own_ms) = venting.reference.vented_ms[chamber] else {
                open |= after_ms < HORIZON_MS;
                if after_ms == HORIZON_MS {
                    self.stays(now_ms, chamber, kpa, venting.reference.end_kpa[chamber]);
                }
                continue;
            };
            if kpa < VENTED_KPA {
                venting.below_since_ms[chamber].get_or_insert(after_ms);
            } else if after_ms <= own_ms {
                // Filled by the fuller ones, as in the plant left to itself. What a diagnosis lifts later is another matter.
                venting.below_since_ms[chamber] = None;
            }
            let reached_ms = venting.below_since_ms[chamber].filter(|_| after_ms >= own_ms);
            if let Some(reached_ms) = reached_ms
                && own_ms > 0
                && after_ms == reached_ms.max(own_ms)
            {
                let percent = (u64::from(reached_ms) * 100).div_ceil(u64::from(own_ms)) as u32;
                let worst = self.outcome.vent_percent.get_or_insert(percent);
                *worst = percent.max(*worst);
            }
            open |= reached_ms.is_none();
            // One tick for the readings, which see a tick's end.
            let deadline_ms = (own_ms * 3).div_ceil(2) + 1;
            if reached_ms.is_none() && after_ms == deadline_ms + 1 {
                let how = format!(
                    "chamber {chamber} at {kpa:.1} kPa {after_ms} ms after detection, own vent time {own_ms} ms"
                );
                self.violate(now_ms, Property::VentTime, how);
            }
        }
        self.venting = Some(venting);
        let all_named = !self.named.is_empty() && self.named.iter().all(|&named| named);
        let diagnosis =
            venting.fault.clearing() == Clearing::CommandThenSelfTest && !all_named && after_ms < DIAGNOSIS_MS;
        after_ms > HORIZON_MS || !open && !diagnosis
    }

    /// A chamber that cannot vent ends no higher than in the de-energised plant.
    fn stays(&mut self, now_ms: u32, chamber: usize, kpa: f64, own_kpa: f64) {
        let why = hazards(self.case, now_ms, chamber).join(" and ");
        if why.is_empty() {
            self.violate(now_ms, Property::VentTime, format!("the plant itself does not vent chamber {chamber}"));
        } else if kpa > (own_kpa + SAME_KPA).max(DIAGNOSIS_KPA) {
            let how =
                format!("chamber {chamber} at {kpa:.1} kPa where the de-energised plant is at {own_kpa:.1}: {why}");
            self.violate(now_ms, Property::VentTime, how);
        }
        self.outcome.timeline.push((now_ms, format!("chamber {chamber} cannot vent, {kpa:.1} kPa: {why}")));
        let known = self.outcome.cannot_vent.get_or_insert_default();
        if why.len() > known.len() {
            *known = why;
        }
    }

    /// Whether another fault had taken the only second witness before this one had to be found: without the bend nobody sees an
    /// obstruction, nor the true pressure of a chamber that its valve shuts off or leaves open. That fault must be found itself.
    fn is_blinded(&self, index: usize) -> bool {
        let (drawn, showing) = (&self.case.faults[index], &self.showings[index]);
        let needs_bend = matches!(
            drawn.kind,
            Kind::FingerBlocked | Kind::FingerPushed | Kind::ValveStuckOpen | Kind::ValveStuckClosed
        );
        let due_ms = showing.since_ms.map_or(0, |since| since + drawn.kind.bound_ms(showing.in_self_test));
        let blinds = |fault: &Drawn| {
            matches!(fault.kind, Kind::BendSensorOpen | Kind::BendSensorShort | Kind::BendSensorFrozen)
                && fault.from_ms <= due_ms
        };
        needs_bend && self.case.faults.iter().any(blinds)
    }

    /// Whether a push from outside has just compressed this closed chamber: until the push must have been found.
    fn is_compressed(&self, now_ms: u32, chamber: usize) -> bool {
        self.case.faults.iter().any(|fault| {
            fault.kind == Kind::FingerPushed
                && fault.segment as usize == chamber
                && (fault.from_ms..=fault.from_ms + fault.kind.bound_ms(false)).contains(&now_ms)
        })
    }

    /// The run's end.
    #[must_use]
    pub fn outcome(mut self, now_ms: u32) -> Outcome {
        self.outcome.simulated_ms = now_ms;
        for (index, &drawn) in self.case.faults.iter().enumerate() {
            let showing = &self.showings[index];
            let (shown_ms, bound_ms) = (showing.shown_ms(), drawn.kind.bound_ms(showing.in_self_test));
            let in_time = shown_ms <= bound_ms;
            let ending = match (self.detected[index], showing.since_ms) {
                (Some(_), _) if in_time => Ending::Detected { latency_ms: shown_ms },
                (None, None) => Ending::NotShown,
                (None, Some(_)) if in_time || self.is_blinded(index) => Ending::Undecided,
                (Some(_), _) if self.is_blinded(index) => Ending::Undecided,
                _ => Ending::Missed,
            };
            if ending == Ending::Missed {
                let when = if self.detected[index].is_some() { "detected" } else { "not detected" };
                let name = drawn.kind.name();
                let how = format!("{name} {when} after {shown_ms} ms in which it showed, bound {bound_ms} ms");
                self.violate(now_ms, Property::Detection, how);
            }
            self.outcome.fates.push(Fate { drawn, ending, named: self.named[index] });
        }
        self.outcome.timeline.sort_by_key(|(ms, _)| *ms);
        self.outcome
    }
}

/// Whether a hand bends the finger to where its sensor ends: a reading out of range is all that there is to see, and looks like
/// a broken sensor's.
fn is_out_of_range(drawn: &Drawn, case: &Case, plant: &Plant) -> bool {
    let bend_deg: f64 = plant.truth().bends_deg.iter().sum();
    let range_deg = 0.0..case.plant.bend_sensor.range_deg * (1.0 - case.plant.bend_sensor.gain_error) - RANGE_END_DEG;
    drawn.kind == Kind::FingerPushed && !range_deg.contains(&bend_deg)
}

/// Whether nobody can see a fault in this tick, as the controller makes none: for that there is a bound of its own. What the
/// interlock's interrupt must answer is seen without a tick, until everything is de-energised.
fn is_away(kind: Kind, event: Event, actuation: Actuation) -> bool {
    let by_itself = matches!(kind, Kind::TaskHang | Kind::PowerDip | Kind::TickOverrun);
    let interlock = matches!(kind, Kind::EmergencyStop | Kind::SwitchStuckClosed);
    event != Event::Ticked && !by_itself && !(interlock && actuation != Actuation::SAFE)
}

/// Those that are in both.
fn intersection(one: FaultSet, other: FaultSet) -> FaultSet {
    one.without(one.without(other))
}

/// A fault in words.
#[must_use]
pub fn describe(drawn: &Drawn) -> String {
    format!("{} at {} ms ({:?})", drawn.kind.name(), drawn.from_ms, drawn.what)
}
