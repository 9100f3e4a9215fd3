//! When a fault shows in a true quantity: from then on the time to its detection counts.
//!
//! A valve that is stuck where it should be anyway, or a leak in an empty chamber, is no danger and can be seen by nobody. What
//! counts for each kind is said at its arm of `Showing::condition`, and all of it must hold for [`STEADY_MS`] on end but for what
//! is electrical, which shows at once. From then on the time to its detection runs while it holds, and for
//! [`HOLD_OVER_MS`] after: in between it is no danger, and nobody can see it. It stands still while the controller makes no tick:
//! that has a bound of its own.

use super::draw::{Case, Drawn, Program, What};
use super::kind::Kind;
use crate::plant::Truth;
use model_core::actuation::{Actuation, Passage, PerSegment, Segment};
use model_core::controller::{Mode, Outputs};
use model_core::units::Pressure;

/// A condition must hold this long, ms.
pub const STEADY_MS: u32 = 50;
/// The time to detection runs while the condition holds, and for this long after, ms.
pub const HOLD_OVER_MS: u32 = 500;
/// A pressure that is this far off shows, kPa.
pub const OFF_KPA: f64 = 10.0;
/// A segment that is held this far off its free bend shows, degrees, and a reading that is this far off the finger's bend: ...
pub const OFF_DEG: f64 = 40.0;
/// ... and by this share of the finger's bend: the supervisor's bound is up to 30 degrees and a sixteenth, and gain (1 %),
/// calibration (3 %) and zero may hide as much again of what a hand or an obstacle does.
pub const OFF_SHARE: f64 = 0.05;
/// ... and in motion by so many times the way that is left to go with the supervisor's lag, ms, ...
const MOTION_TIMES: f64 = 1.25;
const MOTION_LAG_MS: f64 = 80.0;
/// ... and for a while after, as it fades, ms.
const MOTION_FADES_MS: f64 = 256.0;
/// ... and while a sequence runs that is there to find the coefficients by as much as the supervisor's bound is widened then.
pub const IDENTIFYING_DEG: f64 = 60.0;
/// A switch that is open so far above its threshold shows, kPa.
pub const SWITCH_OFF_KPA: f64 = 8.0;
/// A session's limits, as docs/faults.md has them: time, ms, and bends, ...
const SESSION_MS: u32 = 3_600_000;
const SESSION_BENDS: u32 = 2000;
/// ... each from above the one to below the other setpoint, kPa.
const BENT_KPA: f64 = 20.0;
const STRAIGHT_KPA: f64 = 10.0;
/// The manifold, shut off, shows a leak when it has lost this and ..., kPa: twice what the supervisor asks for.
const MANIFOLD_LOST_KPA: f64 = 16.0;
/// ... this share of what it had, in one go.
const MANIFOLD_LOST_SHARE: f64 = 0.125;
/// A leak that takes less than this from its chamber now does not show, kPa/s.
pub const LEAK_KPA_PER_S: f64 = 1.0;
/// A slow leak shows in what is lost beside this, kPa/s, which a sound chamber that cools loses too, ...
const LEAK_FORGIVEN_KPA_PER_S: f64 = 0.4;
/// ... while setpoints have rested for so long, ms, ...
const LEAK_REST_MS: u32 = 1000;
/// ... when it comes to this, kPa: half more than the supervisor asks for, for the errors of its estimates.
pub const LEAK_SLOW_KPA: f64 = 12.0;

/// For how long each actuator has had its command, ms.
#[derive(Clone, Copy, Debug, Default)]
pub struct Commanded {
    last: Actuation,
    pump_ms: u32,
    dump_ms: u32,
    segments_ms: [u32; 3],
}

impl Commanded {
    /// One tick.
    pub fn step(&mut self, actuation: Actuation) {
        let count = |ms: &mut u32, same: bool| *ms = if same { ms.saturating_add(1) } else { 0 };
        count(&mut self.pump_ms, self.last.pump == actuation.pump);
        count(&mut self.dump_ms, self.last.dump == actuation.dump);
        for segment in 0..3 {
            count(&mut self.segments_ms[segment], self.last.segments[segment] == actuation.segments[segment]);
        }
        self.last = actuation;
    }
}

/// Whether and since when a fault shows.
#[derive(Clone, Copy, Debug)]
pub struct Showing {
    drawn: Drawn,
    /// The true manifold's pressure (kPa) and the finger's bend (degrees) when it came.
    at_start: Option<(f64, f64)>,
    /// The manifold's pressure when the pump should have come to rest, or its highest since it was shut off, kPa.
    rest_kpa: Option<f64>,
    /// Pressure that the leak has taken, kPa; a slow one's while setpoints rest, beside what is forgiven.
    lost_kpa: f64,
    /// The last tick's setpoints, and for how long they have rested, ms.
    setpoints: PerSegment<Pressure>,
    rest_ms: u32,
    /// The finger's bend under its pressures in the last tick, and how far behind a motion it may be, degrees.
    free_deg: Option<f64>,
    motion_deg: f64,
    /// For how long the finger was driven, ms, and how often it was bent.
    driven_ms: u32,
    bends: u32,
    bent: bool,
    streak_ms: u32,
    /// Since when, ms.
    pub since_ms: Option<u32>,
    /// For how long in all, ms.
    pub exposed_ms: u32,
    /// Ticks since it last did, ms.
    gap_ms: u32,
    /// Whether the self test ran when it began to.
    pub in_self_test: bool,
}

/// What a condition looks at.
struct Look<'a> {
    case: &'a Case,
    truth: &'a Truth,
    outputs: Option<&'a Outputs>,
    actuation: Actuation,
    commanded: &'a Commanded,
}

impl Look<'_> {
    /// The reference of a chamber, kPa; none while there is none to follow.
    fn reference_kpa(&self, segment: usize) -> Option<f64> {
        let outputs = self.outputs?;
        match outputs.mode {
            Mode::Faulted(_) | Mode::SelfTest => None,
            _ => Some(outputs.setpoints[segment].to_f64()),
        }
    }

    /// Whether a chamber is off its reference.
    fn off(&self, segment: usize) -> bool {
        self.reference_kpa(segment).is_some_and(|kpa| (self.truth.chambers_kpa[segment] - kpa).abs() > OFF_KPA)
    }

    /// Whether a chamber with its valve commanded open lies below its reference.
    fn wanting(&self, segment: usize) -> bool {
        self.actuation.segments[segment] == Passage::Open
            && self.reference_kpa(segment).is_some_and(|kpa| kpa - self.truth.chambers_kpa[segment] > OFF_KPA)
    }
}

impl Showing {
    /// Not yet.
    #[must_use]
    pub fn new(drawn: Drawn) -> Self {
        Self {
            drawn,
            at_start: None,
            rest_kpa: None,
            lost_kpa: 0.0,
            setpoints: [Pressure::ZERO; 3],
            rest_ms: 0,
            free_deg: None,
            motion_deg: 0.0,
            driven_ms: 0,
            bends: 0,
            bent: false,
            streak_ms: 0,
            since_ms: None,
            exposed_ms: 0,
            gap_ms: 0,
            in_self_test: false,
        }
    }

    /// Whether this is there at all.
    #[must_use]
    pub fn is_present(&self, now_ms: u32) -> bool {
        now_ms >= self.drawn.from_ms
    }

    /// One tick with the fault, before the plant moves on.
    pub fn tick(
        &mut self,
        now_ms: u32,
        case: &Case,
        truth: &Truth,
        outputs: Option<&Outputs>,
        actuation: Actuation,
        commanded: &Commanded,
    ) {
        let look = Look { case, truth, outputs, actuation, commanded };
        self.follow(&look);
        let (holds, needed_ms) = self.condition(now_ms, &look);
        if self.since_ms.is_some() {
            self.gap_ms = if holds { 0 } else { self.gap_ms.saturating_add(1) };
            self.exposed_ms += u32::from(self.gap_ms <= HOLD_OVER_MS);
            return;
        }
        if !holds {
            self.streak_ms = 0;
            return;
        }
        self.streak_ms += 1;
        if self.streak_ms >= needed_ms {
            (self.since_ms, self.exposed_ms) = (Some(now_ms + 1 - needed_ms), needed_ms - 1);
            self.in_self_test = outputs.is_some_and(|outputs| outputs.mode == Mode::SelfTest);
        }
    }

    /// For how long it has shown, ms; one that has begun to counts.
    #[must_use]
    pub fn shown_ms(&self) -> u32 {
        if self.since_ms.is_some() { self.exposed_ms } else { self.streak_ms.saturating_sub(1) }
    }

    /// What moves while the fault is there.
    fn follow(&mut self, look: &Look<'_>) {
        let setpoints = look.outputs.map_or([Pressure::ZERO; 3], |outputs| outputs.setpoints);
        let moved = setpoints != self.setpoints;
        if moved && self.rest_ms > 0 && self.drawn.kind == Kind::LeakSlow {
            // The supervisor's estimates start anew: what was lost before counts half.
            self.lost_kpa /= 2.0;
        }
        if look.outputs.is_some_and(|outputs| matches!(outputs.mode, Mode::Running | Mode::Holding | Mode::Paused)) {
            self.driven_ms += 1;
        }
        let above = |kpa| setpoints.iter().any(|setpoint| setpoint.to_f64() > kpa);
        if !self.bent && above(BENT_KPA) {
            (self.bent, self.bends) = (true, self.bends + 1);
        } else if !above(STRAIGHT_KPA) {
            self.bent = false;
        }
        self.rest_ms = if moved { 0 } else { self.rest_ms.saturating_add(1) };
        self.setpoints = setpoints;
        let free_deg = look.truth.bends_deg.iter().sum::<f64>() - look.truth.forced_deg.iter().sum::<f64>();
        let way_deg = self.free_deg.map_or(0.0, |last_deg| (free_deg - last_deg).abs() * MOTION_LAG_MS);
        self.motion_deg = way_deg.max(self.motion_deg * (1.0 - 1.0 / MOTION_FADES_MS));
        self.free_deg = Some(free_deg);
    }

    /// How far the finger must be off before one sensor can tell it from a finger that is in order, degrees.
    fn off_deg(&self, case: &Case) -> f64 {
        let identifies = matches!(case.program, Program::Sequence(sequence) if sequence.identifies());
        let unknown_deg = if identifies { IDENTIFYING_DEG } else { 0.0 };
        OFF_DEG + OFF_SHARE * self.free_deg.unwrap_or_default() + MOTION_TIMES * self.motion_deg + unknown_deg
    }

    /// Whether it shows, and how long it must to begin with, ms.
    fn condition(&mut self, now_ms: u32, look: &Look<'_>) -> (bool, u32) {
        match self.drawn.kind {
            // What is electrical shows at once.
            Kind::PressureSensorOpen
            | Kind::PressureSensorShort
            | Kind::PressureSensorNoisy
            | Kind::SwitchStuckClosed
            | Kind::BendSensorOpen
            | Kind::BendSensorShort
            | Kind::EmergencyStop
            | Kind::TickOverrun
            | Kind::TaskHang
            | Kind::SettingsCorrupt => (true, 1),
            // With the supply's return: without it nobody is there to see it.
            Kind::PowerDip => (matches!(self.drawn.what, What::Dip { ms } if now_ms >= self.drawn.from_ms + ms), 1),
            // While a host should drive the finger.
            Kind::LinkLost => (look.outputs.is_some_and(|outputs| outputs.mode == Mode::Holding), 1),
            Kind::SessionTime => (self.driven_ms > SESSION_MS, 1),
            Kind::SessionCycles => (self.bends > SESSION_BENDS, 1),
            _ => (self.physical(look), STEADY_MS),
        }
    }

    /// Whether what is not electrical shows in this tick.
    fn physical(&mut self, look: &Look<'_>) -> bool {
        let Look { case, truth, actuation, commanded, .. } = *look;
        let bend_deg: f64 = truth.bends_deg.iter().sum();
        let (start_kpa, start_deg) = *self.at_start.get_or_insert((truth.manifold_kpa, bend_deg));
        let segment = self.drawn.segment as usize;
        let valve = &case.plant.segment_valve;
        let pump_settling_ms = case.plant.pump.dead_time_ms + (5.0 * case.plant.pump.spin_up_ms) as u32;
        match self.drawn.kind {
            // The manifold is elsewhere than where the reading stands still.
            Kind::PressureSensorFrozen => (truth.manifold_kpa - start_kpa).abs() > OFF_KPA,
            // The manifold is above the switch's threshold and all that a reading may be off by, and it does not close.
            Kind::SwitchStuckOpen => truth.manifold_kpa > case.plant.pressure_sensor.switch_kpa + SWITCH_OFF_KPA,
            Kind::BendSensorFrozen => (bend_deg - start_deg).abs() > self.off_deg(case),
            // Commanded off, run down, and the manifold has risen since; or it is above atmosphere with the dump commanded open.
            Kind::PumpStuckOn => {
                if actuation.pump || commanded.pump_ms < pump_settling_ms {
                    self.rest_kpa = None;
                    return false;
                }
                let rest_kpa = *self.rest_kpa.get_or_insert(truth.manifold_kpa);
                let vented = actuation.dump == Passage::Open && commanded.dump_ms > 500;
                truth.pump_speed > 0.5
                    && (truth.manifold_kpa - rest_kpa > OFF_KPA || vented && truth.manifold_kpa > OFF_KPA)
            }
            // Commanded on, run up, and a chamber that should be filled is below its reference.
            Kind::PumpDead | Kind::PumpWeak => {
                actuation.pump && commanded.pump_ms > pump_settling_ms && (0..3).any(|segment| look.wanting(segment))
            }
            // Commanded closed for longer than its dead time, open, and its chamber is off its reference.
            Kind::ValveStuckOpen => {
                actuation.segments[segment] == Passage::Closed
                    && commanded.segments_ms[segment] > valve.dead_time_ms
                    && look.off(segment)
            }
            // Commanded open for longer than its dead time, closed, and the pressures on its sides differ.
            Kind::ValveStuckClosed => {
                actuation.segments[segment] == Passage::Open
                    && commanded.segments_ms[segment] > valve.dead_time_ms
                    && (truth.manifold_kpa - truth.chambers_kpa[segment]).abs() > OFF_KPA
            }
            // Commanded closed for longer than its dead time, open, and air is lost: the manifold is above atmosphere, or a
            // chamber that should be filled is below its reference.
            Kind::DumpStuckOpen => {
                actuation.dump == Passage::Closed
                    && commanded.dump_ms > case.plant.dump_valve.dead_time_ms
                    && (truth.manifold_kpa > OFF_KPA || (0..3).any(|segment| look.wanting(segment)))
            }
            // Shut off, dump closed and pump at rest, the manifold has lost so much; or a chamber that should be filled is below
            // its reference.
            Kind::ManifoldLeak => {
                let dead_ms = valve.dead_time_ms.max(case.plant.dump_valve.dead_time_ms);
                let shut = actuation.segments == [Passage::Closed; 3]
                    && actuation.dump == Passage::Closed
                    && commanded.dump_ms > dead_ms
                    && commanded.segments_ms.iter().all(|&ms| ms > dead_ms);
                let rests = !actuation.pump && commanded.pump_ms > pump_settling_ms;
                self.rest_kpa = shut.then(|| self.rest_kpa.unwrap_or(f64::MIN).max(truth.manifold_kpa));
                let lost =
                    |from_kpa: f64| from_kpa - truth.manifold_kpa > MANIFOLD_LOST_KPA + MANIFOLD_LOST_SHARE * from_kpa;
                rests && self.rest_kpa.is_some_and(lost)
                    || actuation.pump
                        && commanded.pump_ms > pump_settling_ms
                        && (0..3).any(|segment| look.wanting(segment))
            }
            // Commanded open for longer than its dead time, closed, and the manifold is above atmosphere.
            Kind::DumpStuckClosed => {
                actuation.dump == Passage::Open
                    && commanded.dump_ms > case.plant.dump_valve.dead_time_ms
                    && truth.manifold_kpa > OFF_KPA
            }
            // The air that has left through it would have been so much pressure in the chamber at rest, and more leaves now.
            Kind::LeakBurst => {
                let kpa_per_s = leak_kpa_per_s(case, truth, segment);
                self.lost_kpa += kpa_per_s * 1e-3;
                self.lost_kpa > OFF_KPA && kpa_per_s > LEAK_KPA_PER_S
            }
            // The same while setpoints rest, so that nothing but the leak takes air, beside what a sound chamber may lose.
            Kind::LeakSlow => {
                let kpa_per_s = leak_kpa_per_s(case, truth, segment);
                if look.reference_kpa(segment).is_some_and(|kpa| kpa > 0.0) && self.rest_ms > LEAK_REST_MS {
                    self.lost_kpa = (self.lost_kpa + (kpa_per_s - LEAK_FORGIVEN_KPA_PER_S) * 1e-3).max(0.0);
                }
                self.lost_kpa > LEAK_SLOW_KPA && kpa_per_s > LEAK_KPA_PER_S
            }
            // The self test's 12 kPa bend a finger, too; nobody looks at it then.
            Kind::FingerBlocked | Kind::FingerPushed => {
                // The one sensor tells the sum: of two at once one can hide the other.
                let off = truth.forced_deg[segment].abs().min(truth.forced_deg.iter().sum::<f64>().abs());
                off > self.off_deg(case) && look.outputs.is_some_and(|outputs| outputs.mode != Mode::SelfTest)
            }
            // Electrical: see `Self::condition`. And cold valves work, late: nothing that must be told; what may not come of
            // it the other properties say.
            _ => false,
        }
    }
}

/// What the leak takes from a chamber of the volume that it has now, kPa/s.
fn leak_kpa_per_s(case: &Case, truth: &Truth, segment: usize) -> f64 {
    let finger = &case.plant.finger;
    let growth = finger.volume_growth * truth.bends_deg[segment] / finger.growth_reference_deg;
    let chamber_l = finger.chamber_ml * (1.0 + growth.max(0.0)) / 1000.0;
    truth.leak_flows_nl_per_s[segment] * 100.0 / chamber_l
}

/// Whether this chamber's own valve is stuck closed.
#[must_use]
pub fn own_valve_closed(case: &Case, now_ms: u32, chamber: usize) -> bool {
    case.faults.iter().any(|fault| {
        fault.kind == Kind::ValveStuckClosed && fault.segment == Segment::ALL[chamber] && fault.from_ms <= now_ms
    })
}

/// What keeps chambers from venting, by name; empty when nothing does.
#[must_use]
pub fn hazards(case: &Case, now_ms: u32, chamber: usize) -> Vec<&'static str> {
    let present = |kind: Kind| case.faults.iter().any(|fault| fault.kind == kind && fault.from_ms <= now_ms);
    [
        (own_valve_closed(case, now_ms, chamber), "own valve stuck closed"),
        (present(Kind::DumpStuckClosed), "dump stuck closed"),
        (present(Kind::PumpStuckOn), "pump stuck on"),
    ]
    .into_iter()
    .filter_map(|(holds, name)| holds.then_some(name))
    .collect()
}
