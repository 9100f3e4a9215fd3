//! When a fault shows in a true quantity: from then on the time to its detection counts.
//!
//! A valve that is stuck where it should be anyway, or a leak in an empty chamber, is no danger and can be seen by nobody. What
//! counts for each kind is said at its arm of [`Showing::condition`], and all of it must hold for [`STEADY_MS`] on end but for what
//! is electrical, which shows at once.

use super::draw::{Case, Drawn, What};
use super::kind::Kind;
use crate::plant::Truth;
use model_core::actuation::{Actuation, Passage, Segment};
use model_core::controller::{Mode, Outputs};

/// A condition must hold this long, ms.
pub const STEADY_MS: u32 = 50;
/// A pressure that is this far off shows, kPa.
pub const OFF_KPA: f64 = 10.0;
/// A segment that is held this far off its free bend shows, degrees.
pub const OFF_DEG: f64 = 15.0;
/// The whole finger's reading that is this far off shows, degrees.
pub const SENSOR_OFF_DEG: f64 = 20.0;

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
    /// The manifold's pressure when the pump should have come to rest, kPa.
    rest_kpa: Option<f64>,
    /// Pressure that the leak has taken, kPa.
    lost_kpa: f64,
    streak_ms: u32,
    /// Since when, ms.
    pub since_ms: Option<u32>,
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
        Self { drawn, at_start: None, rest_kpa: None, lost_kpa: 0.0, streak_ms: 0, since_ms: None }
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
        if self.since_ms.is_some() {
            return;
        }
        let look = Look { case, truth, outputs, actuation, commanded };
        if !self.condition(now_ms, &look) {
            self.streak_ms = 0;
            return;
        }
        self.streak_ms += 1;
        let needed = if self.at_once() { 1 } else { STEADY_MS };
        if self.streak_ms >= needed {
            self.since_ms = Some(now_ms + 1 - needed);
        }
    }

    /// Since when it shows, ms; one that has begun to counts when it has been detected at `now_ms`.
    #[must_use]
    pub fn since_at(&self, now_ms: u32) -> Option<u32> {
        self.since_ms.or((self.streak_ms > 0).then(|| now_ms + 1 - self.streak_ms.min(now_ms + 1)))
    }

    fn at_once(&self) -> bool {
        matches!(
            self.drawn.kind,
            Kind::PressureSensorOpen
                | Kind::PressureSensorShort
                | Kind::PressureSensorNoisy
                | Kind::SwitchStuckClosed
                | Kind::BendSensorOpen
                | Kind::BendSensorShort
                | Kind::EmergencyStop
                | Kind::LinkLost
                | Kind::TickOverrun
                | Kind::TaskHang
                | Kind::PowerDip
                | Kind::SettingsCorrupt
        )
    }

    fn condition(&mut self, now_ms: u32, look: &Look<'_>) -> bool {
        let Look { case, truth, actuation, commanded, .. } = *look;
        let bend_deg: f64 = truth.bends_deg.iter().sum();
        let (start_kpa, start_deg) = *self.at_start.get_or_insert((truth.manifold_kpa, bend_deg));
        let segment = self.drawn.segment as usize;
        let valve = &case.plant.segment_valve;
        let pump_settling_ms = case.plant.pump.dead_time_ms + (5.0 * case.plant.pump.spin_up_ms) as u32;
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
            | Kind::SettingsCorrupt => true,
            // With the supply's return: without it nobody is there to see it.
            Kind::PowerDip => matches!(self.drawn.what, What::Dip { ms } if now_ms >= self.drawn.from_ms + ms),
            // While a host should drive the finger.
            Kind::LinkLost => look.outputs.is_some_and(|outputs| outputs.mode == Mode::Holding),
            // The manifold is elsewhere than where the reading stands still.
            Kind::PressureSensorFrozen => (truth.manifold_kpa - start_kpa).abs() > OFF_KPA,
            // The manifold is above the switch's threshold, and it does not close.
            Kind::SwitchStuckOpen => truth.manifold_kpa > case.plant.pressure_sensor.switch_kpa + 5.0,
            Kind::BendSensorFrozen => (bend_deg - start_deg).abs() > SENSOR_OFF_DEG,
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
            // Commanded open for longer than its dead time, closed, and the manifold is above atmosphere.
            Kind::DumpStuckClosed => {
                actuation.dump == Passage::Open
                    && commanded.dump_ms > case.plant.dump_valve.dead_time_ms
                    && truth.manifold_kpa > OFF_KPA
            }
            // The air that has left through it would have been so much pressure in the chamber at rest.
            Kind::LeakSlow | Kind::LeakBurst => {
                let kpa_per_nl = 100.0 / (case.plant.finger.chamber_ml / 1000.0);
                self.lost_kpa += truth.leak_flows_nl_per_s[segment] * 1e-3 * kpa_per_nl;
                self.lost_kpa > OFF_KPA
            }
            Kind::FingerBlocked | Kind::FingerPushed => truth.forced_deg[segment].abs() > OFF_DEG,
        }
    }
}

/// What keeps chambers from venting, by name; empty when nothing does.
#[must_use]
pub fn hazards(case: &Case, now_ms: u32, chamber: usize) -> Vec<&'static str> {
    let present = |kind: Kind| case.faults.iter().any(|fault| fault.kind == kind && fault.from_ms <= now_ms);
    let own = case.faults.iter().any(|fault| {
        fault.kind == Kind::ValveStuckClosed && fault.segment == Segment::ALL[chamber] && fault.from_ms <= now_ms
    });
    [
        (own, "own valve stuck closed"),
        (present(Kind::DumpStuckClosed), "dump stuck closed"),
        (present(Kind::PumpStuckOn), "pump stuck on"),
    ]
    .into_iter()
    .filter_map(|(holds, name)| holds.then_some(name))
    .collect()
}
