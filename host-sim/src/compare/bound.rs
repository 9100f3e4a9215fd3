//! The least time a step can take on this plant, for anybody: full knowledge, perfect sensors, no switching limits.
//!
//! A step's bound starts from the true state at the moment of the step (pressures, bends, pump speed, commands on their way)
//! and ends when every chamber whose reference moved can be within the band for the first time. Why nothing is faster:
//!
//! 1. *One chamber.* Take the air N in manifold and chamber, the air n in the chamber, and its bend a. dN/dt is the pump's
//!    flow, which falls with the manifold's pressure (N - n)/V: it grows with n. dn/dt is the valve's flow: it grows with N, and
//!    with a (a larger chamber is at a lower pressure). da/dt grows with n. No other slopes cross, so the system is
//!    cooperative, and pump and valve only add to its right-hand sides: by Kamke's comparison, pump and valve on from the
//!    first moment, up to the manifold's ceiling, give the most N and n at every later moment. The chamber that is
//!    filled alone and as fast as possible is the one that has had the least time to bend, so it needs the least air.
//! 2. *Several alike* (the same reference, from pressures within 2 kPa): all at once in equal shares. An orifice's flow is concave in
//!    the pressure it flows to, so of all ways to share the air this passes the most; then the sum of the chambers is a chamber
//!    as in 1. What unequal shares could gain by bending later is of second order; the tests search for it and find nothing.
//! 3. *Several unlike.* Each alone, and each group of chambers that are alike, is a bound. So is their sum, S: by the same concavity
//!    the air gets in fastest where it is shared in stairs, the lowest first, and no chamber beyond its band. Every chamber
//!    that is not full counts as an open valve to their mean, in the largest volume that it can have by then, which by 1 is that of a
//!    chamber with the pump to itself; (N, S) is cooperative, and the step is not done before S is what the chambers need, each
//!    as in 1 and 2.
//! 4. *Falling* is the same with the dump valve for the pump and every inequality turned round; leaks help. Chambers that fall to
//!    one reference from different pressures come together within some ten milliseconds through the manifold: their mean falls as
//!    in 2.
//! 5. *Some rise and some fall.* Then air may pass from one to the other, and only the valves bound it: each rising
//!    chamber through its valve from a manifold at the ceiling, each falling one through its valve to the atmosphere.
//!    Such bounds are loose and listed apart.
//!
//! On the way each chamber's error is at its least at every moment, so its sum over time bounds the mean absolute error too.
//!
//! What is assumed: chambers whose reference rests give and take no air, and the manifold keeps to the ceiling that all
//! regulators have.

use super::trial::StepStart;
use crate::metrics::BAND_KPA;
use crate::plant::gas::REFERENCE_KPA;
use crate::plant::static_curve::StaticCurve;
use crate::plant::valve::Orifice;
use crate::plant::{FaultKind, PlantParameters, Scene};
use model_core::actuation::{Actuation, Passage};
use model_core::regulator::MANIFOLD_CEILING;
use serde::Serialize;

/// Which way the references of a step go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// All that move rise.
    Rise,
    /// All that move fall.
    Fall,
    /// Some rise and some fall.
    Mixed,
}

/// Step of the integration, ms: the stiffest volume settles at 1.3 per ms.
const STEP_MS: f64 = 0.05;
/// What takes longer is not bounded, ms.
const LONGEST_MS: f64 = 10_000.0;
/// Pressures for which static bends are kept: from 0 in steps, kPa.
const TABLE_KPA: f64 = 0.25;
const TABLE_LENGTH: usize = 800;

/// The plant's physics, without its sensors and without its noise.
#[derive(Clone, Debug)]
pub struct Physics {
    parameters: PlantParameters,
    segment: Orifice,
    dump: Orifice,
    leaks: [Option<Orifice>; 3],
    /// Static bend of each segment over pressure, rad.
    bends_rad: [Vec<f64>; 3],
    rest_l: f64,
    growth_l_per_rad: f64,
    manifold_l: f64,
    /// What is left of the bend's lag after a step.
    lag_share: f64,
    /// The same of the pump's speed.
    speed_share: f64,
}

/// One chamber on its way.
#[derive(Clone, Copy, Debug)]
struct Chamber {
    index: usize,
    /// Gauge pressure at the start, kPa.
    start_kpa: f64,
    content_nl: f64,
    bend_rad: f64,
    /// Time until its valve can be open, ms.
    delay_ms: f64,
    /// The edge of the band that it reaches first, gauge, kPa.
    goal_kpa: f64,
    /// Its leak.
    leak: Option<Orifice>,
}

/// The least that a step takes.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// Which way the references go.
    pub kind: Kind,
    /// Time until all chambers that move can be within the band, ms.
    pub time_ms: f64,
    /// Their errors until then, each at its least, summed over time and chambers, kPa ms.
    pub error_kpa_ms: f64,
}

/// What one chamber alone takes.
struct Alone {
    time_ms: f64,
    /// Its error on the way, summed over time, kPa ms.
    error_kpa_ms: f64,
    /// Air in it then, NL.
    content_nl: f64,
}

/// Groups of chambers that are alike: their mean, and how many they are.
fn alike(chambers: &[Chamber], rise: bool) -> Vec<(Chamber, f64)> {
    let near = |one: &Chamber, other: &Chamber| {
        (one.goal_kpa - other.goal_kpa).abs() <= 0.0 && (!rise || (one.start_kpa - other.start_kpa).abs() <= BAND_KPA)
    };
    let mut groups: Vec<Vec<Chamber>> = Vec::new();
    for chamber in chambers {
        match groups.iter_mut().find(|group| group.iter().all(|other| near(chamber, other))) {
            Some(group) => group.push(*chamber),
            None => groups.push(vec![*chamber]),
        }
    }
    let stands_for = |group: &Vec<Chamber>| {
        let count = group.len() as f64;
        let mean = |of: fn(&Chamber) -> f64| group.iter().map(of).sum::<f64>() / count;
        let mean_chamber = Chamber {
            content_nl: mean(|chamber| chamber.content_nl),
            bend_rad: mean(|chamber| chamber.bend_rad),
            delay_ms: group.iter().map(|chamber| chamber.delay_ms).fold(f64::INFINITY, f64::min),
            // If one leaks, all do: that helps no less.
            leak: group.iter().find_map(|chamber| chamber.leak),
            ..group[0]
        };
        (mean_chamber, count)
    };
    groups.iter().map(stands_for).collect()
}

/// Static bend at a gauge pressure, by halving.
fn static_bend_rad(curve: &StaticCurve, kpa: f64) -> f64 {
    let (mut low, mut high) = (0.0, curve.end_rad());
    for _ in 0..50 {
        let middle = f64::midpoint(low, high);
        if curve.pressure_and_slope(middle).0 < kpa { low = middle } else { high = middle }
    }
    f64::midpoint(low, high)
}

impl Physics {
    /// Of this plant.
    #[must_use]
    pub fn new(parameters: PlantParameters, scene: &Scene) -> Self {
        let finger = &parameters.finger;
        let rest_l = finger.chamber_ml / 1000.0;
        let mut leaks = [None; 3];
        for fault in &scene.faults {
            if let FaultKind::ChamberLeak { segment, conductance_nl_per_s_bar } = fault.kind {
                let law = crate::plant::parameters::OrificeParameters {
                    conductance_nl_per_s_bar,
                    ..parameters.segment_valve.clone()
                };
                leaks[segment as usize] = Some(Orifice::new(&law));
            }
        }
        Self {
            segment: Orifice::new(&parameters.segment_valve),
            dump: Orifice::new(&parameters.dump_valve),
            leaks,
            bends_rad: finger.coefficients_kpa.map(|coefficients| {
                let curve = StaticCurve::new(coefficients);
                (0..TABLE_LENGTH).map(|row| static_bend_rad(&curve, row as f64 * TABLE_KPA)).collect()
            }),
            rest_l,
            growth_l_per_rad: rest_l * finger.volume_growth / finger.growth_reference_deg.to_radians(),
            manifold_l: parameters.gas.manifold_ml / 1000.0,
            lag_share: -(-STEP_MS / finger.lag_ms).exp_m1(),
            speed_share: -(-STEP_MS / parameters.pump.spin_up_ms).exp_m1(),
            parameters,
        }
    }

    fn static_bend_rad(&self, index: usize, gauge_kpa: f64) -> f64 {
        let place = (gauge_kpa / TABLE_KPA).clamp(0.0, (TABLE_LENGTH - 2) as f64);
        let (row, share) = (place as usize, place.fract());
        let bends = &self.bends_rad[index];
        bends[row] + (bends[row + 1] - bends[row]) * share
    }

    fn volume_l(&self, bend_rad: f64) -> f64 {
        self.rest_l + self.growth_l_per_rad * bend_rad
    }

    fn atmosphere_kpa(&self) -> f64 {
        self.parameters.gas.atmosphere_kpa
    }

    fn manifold_kpa(&self, content_nl: f64) -> f64 {
        content_nl * REFERENCE_KPA / self.manifold_l
    }

    /// Air in a chamber of this bend at a gauge pressure, NL.
    fn content_nl(&self, gauge_kpa: f64, bend_rad: f64) -> f64 {
        (gauge_kpa + self.atmosphere_kpa()) * self.volume_l(bend_rad) / REFERENCE_KPA
    }

    /// The pump's flow at its present speed, NL/s.
    fn pump_nl_per_s(&self, speed: f64, manifold_kpa: f64) -> f64 {
        let pump = &self.parameters.pump;
        let share = 1.0 - (manifold_kpa - self.atmosphere_kpa()) / pump.stall_kpa;
        speed * pump.free_flow_nl_per_min / 60.0 * share.max(0.0)
    }

    /// The least that a step takes; `from_kpa` are the references before it.
    #[must_use]
    pub fn bound(&self, start: &StepStart, from_kpa: [f64; 3], to_kpa: [f64; 3]) -> Bound {
        let change: [f64; 3] = core::array::from_fn(|i| to_kpa[i] - from_kpa[i]);
        let chamber = |index: usize, goal_kpa: f64| Chamber {
            index,
            start_kpa: start.truth.chambers_kpa[index],
            content_nl: self.content_nl(start.truth.chambers_kpa[index], start.truth.bends_deg[index].to_radians()),
            bend_rad: start.truth.bends_deg[index].to_radians(),
            delay_ms: self.valve_delay_ms(start, index),
            goal_kpa,
            leak: self.leaks[index],
        };
        let towards = |sign: f64| -> Vec<Chamber> {
            (0..3).filter(|&i| sign * change[i] > 0.0).map(|i| chamber(i, to_kpa[i] - sign * BAND_KPA)).collect()
        };
        let (rising, falling) = (towards(1.0), towards(-1.0));
        let (kind, (time_ms, error_kpa_ms)) = match (rising.is_empty(), falling.is_empty()) {
            (false, false) => {
                let up = rising.iter().map(|chamber| self.through_valve(chamber, true));
                let down = falling.iter().map(|chamber| self.through_valve(chamber, false));
                let slowest_and_sum =
                    |(slowest, sum): (f64, f64), one: Alone| (one.time_ms.max(slowest), sum + one.error_kpa_ms);
                (Kind::Mixed, up.chain(down).fold((0.0, 0.0), slowest_and_sum))
            }
            (false, true) => (Kind::Rise, self.together(start, &rising, true)),
            (true, _) => (Kind::Fall, self.together(start, &falling, false)),
        };
        Bound { kind, time_ms, error_kpa_ms }
    }

    /// The last commands on their way at the start, as many as the dead time is long.
    fn on_their_way(start: &StepStart, dead_ms: u32) -> impl Iterator<Item = Actuation> + '_ {
        let dead = dead_ms as usize;
        let known = start.commands.len().min(dead);
        let before = dead.saturating_sub(known).min(1);
        core::iter::repeat_n(Actuation::SAFE, before)
            .chain(start.commands[start.commands.len() - known..].iter().copied())
    }

    fn valve_delay_ms(&self, start: &StepStart, index: usize) -> f64 {
        let dead_ms = self.parameters.segment_valve.dead_time_ms;
        let open = start.truth.segments[index] == Passage::Open
            || Self::on_their_way(start, dead_ms).any(|command| command.segments[index] == Passage::Open);
        if open { 0.0 } else { f64::from(dead_ms) }
    }

    /// Time until pump (rising) or dump valve (falling) can act, ms.
    fn source_delay_ms(&self, start: &StepStart, rise: bool) -> f64 {
        let (dead_ms, acts) = if rise {
            let dead_ms = self.parameters.pump.dead_time_ms;
            (dead_ms, Self::on_their_way(start, dead_ms).any(|command| command.pump))
        } else {
            let dead_ms = self.parameters.dump_valve.dead_time_ms;
            let coming = Self::on_their_way(start, dead_ms).any(|command| command.dump == Passage::Open);
            (dead_ms, coming || start.truth.dump == Passage::Open)
        };
        if acts { 0.0 } else { f64::from(dead_ms) }
    }

    /// Points 1 to 4 of the module's page.
    fn together(&self, start: &StepStart, chambers: &[Chamber], rise: bool) -> (f64, f64) {
        let groups = alike(chambers, rise);
        let each: Vec<Alone> =
            groups.iter().map(|(chamber, count)| self.alone(start, *chamber, *count, rise)).collect();
        let longest_ms = each.iter().fold(0.0, |longest, one| one.time_ms.max(longest));
        let error_kpa_ms = each.iter().zip(&groups).map(|(one, (_, count))| count * one.error_kpa_ms).sum();
        if groups.len() < 2 {
            return (longest_ms, error_kpa_ms);
        }
        let sign = if rise { 1.0 } else { -1.0 };
        let needed_nl: f64 = each.iter().zip(&groups).map(|(one, (_, count))| count * one.content_nl).sum();
        let mut stairs = Stairs::new(self, start, chambers, sign);
        let delay_ms = chambers.iter().map(|chamber| chamber.delay_ms).fold(f64::INFINITY, f64::min);
        let mut source = Source::new(self, start, rise);
        let mut time_ms = 0.0;
        while sign * (needed_nl - stairs.sum_nl()) > 0.0 && time_ms < LONGEST_MS {
            let (level_kpa, valves) = stairs.level();
            let valves = if time_ms >= delay_ms { valves } else { 0.0 };
            let into_nl = 1e-3 * STEP_MS * valves * sign * self.one_way(source.manifold_kpa(self), level_kpa, rise);
            let leaks = chambers.iter().filter_map(|chamber| chamber.leak.filter(|_| !rise));
            let out: f64 = leaks.map(|leak| leak.flow_nl_per_s(level_kpa, self.atmosphere_kpa())).sum();
            stairs.add(into_nl - 1e-3 * STEP_MS * out);
            source.step(self, into_nl);
            stairs.bend(self, time_ms);
            time_ms += STEP_MS;
        }
        (longest_ms.max(time_ms), error_kpa_ms)
    }

    /// Flow through one segment valve in the wanted direction, NL/s, never negative: the oracle shuts the valve instead.
    fn one_way(&self, manifold_kpa: f64, chamber_kpa: f64, rise: bool) -> f64 {
        let flow = self.segment.flow_nl_per_s(manifold_kpa, chamber_kpa);
        if rise { flow.max(0.0) } else { (-flow).max(0.0) }
    }

    /// Points 1 and 2 of the module's page, or their mirror image: one of so many chambers that are alike.
    fn alone(&self, start: &StepStart, chamber: Chamber, alike: f64, rise: bool) -> Alone {
        let mut source = Source::new(self, start, rise);
        self.fill(chamber, rise, |chamber_kpa, into_nl| source.feed(self, alike, chamber_kpa, into_nl))
    }

    /// Point 5: through its valve from a manifold at the ceiling, or to one at the atmosphere.
    fn through_valve(&self, chamber: &Chamber, rise: bool) -> Alone {
        let ceiling_kpa = MANIFOLD_CEILING.to_f64() + self.atmosphere_kpa();
        let manifold_kpa = if rise { ceiling_kpa } else { self.atmosphere_kpa() };
        let fill = |chamber_kpa: f64, into_nl: &mut dyn FnMut(f64) -> f64| {
            into_nl(self.one_way(manifold_kpa, chamber_kpa, rise));
        };
        self.fill(*chamber, rise, fill)
    }

    /// Follows a chamber until it has reached its goal. `supply` hears the chamber's absolute pressure and says, through the
    /// function it is given, what the open valve would pass (NL/s); it hears what has passed (NL, signed).
    fn fill(&self, mut chamber: Chamber, rise: bool, mut supply: impl FnMut(f64, &mut dyn FnMut(f64) -> f64)) -> Alone {
        let sign = if rise { 1.0 } else { -1.0 };
        let (mut time_ms, mut error_kpa_ms) = (0.0, 0.0);
        while time_ms < LONGEST_MS {
            let gauge_kpa = self.gauge_kpa(&chamber);
            if sign * (chamber.goal_kpa - gauge_kpa) <= 0.0 {
                break;
            }
            error_kpa_ms += STEP_MS * (sign * (chamber.goal_kpa - gauge_kpa) + BAND_KPA);
            self.pass(&mut chamber, time_ms, rise, &mut supply);
            time_ms += STEP_MS;
        }
        Alone { time_ms, error_kpa_ms, content_nl: chamber.content_nl }
    }

    fn gauge_kpa(&self, chamber: &Chamber) -> f64 {
        chamber.content_nl * REFERENCE_KPA / self.volume_l(chamber.bend_rad) - self.atmosphere_kpa()
    }

    /// One step of a chamber; see [`Self::fill`].
    fn pass(
        &self,
        chamber: &mut Chamber,
        time_ms: f64,
        rise: bool,
        mut supply: impl FnMut(f64, &mut dyn FnMut(f64) -> f64),
    ) {
        let sign = if rise { 1.0 } else { -1.0 };
        let gauge_kpa = self.gauge_kpa(chamber);
        let chamber_kpa = gauge_kpa + self.atmosphere_kpa();
        let open = time_ms >= chamber.delay_ms;
        let mut passed_nl = 0.0;
        supply(chamber_kpa, &mut |flow| {
            passed_nl = if open { sign * 1e-3 * STEP_MS * flow } else { 0.0 };
            passed_nl
        });
        chamber.content_nl += passed_nl;
        if let (Some(leak), false) = (chamber.leak, rise) {
            chamber.content_nl -= 1e-3 * STEP_MS * leak.flow_nl_per_s(chamber_kpa, self.atmosphere_kpa());
        }
        chamber.bend_rad += (self.static_bend_rad(chamber.index, gauge_kpa) - chamber.bend_rad) * self.lag_share;
    }
}

/// A chamber that has pump (or dump) to itself, up to the far edge of its band, and stays there: nobody's bend is further at any
/// moment.
struct Foremost {
    chamber: Chamber,
    source: Source,
}

impl Foremost {
    fn new(physics: &Physics, start: &StepStart, chamber: &Chamber, sign: f64) -> Self {
        let edge_kpa = chamber.goal_kpa + sign * 2.0 * BAND_KPA;
        let chamber = Chamber { goal_kpa: edge_kpa, ..*chamber };
        Self { chamber, source: Source::new(physics, start, sign > 0.0) }
    }

    fn volume_l(&self, physics: &Physics) -> f64 {
        physics.volume_l(self.chamber.bend_rad)
    }

    fn step(&mut self, physics: &Physics, time_ms: f64) {
        let source = &mut self.source;
        let rise = source.rise;
        let sign = if rise { 1.0 } else { -1.0 };
        physics.pass(&mut self.chamber, time_ms, rise, |chamber_kpa, into_nl| {
            source.feed(physics, 1.0, chamber_kpa, into_nl);
        });
        let edge_nl = physics.content_nl(self.chamber.goal_kpa, self.chamber.bend_rad);
        if sign * (self.chamber.content_nl - edge_nl) > 0.0 {
            self.chamber.content_nl = edge_nl;
        }
    }
}

/// Unlike chambers that share air in the way that lets it in (or out) fastest: the lowest (highest) first, none beyond its band.
struct Stairs {
    /// Air, volume and the absolute pressure of the band's far edge of each.
    steps: Vec<(f64, f64, f64)>,
    foremost: Vec<Foremost>,
    sign: f64,
}

impl Stairs {
    fn new(physics: &Physics, start: &StepStart, chambers: &[Chamber], sign: f64) -> Self {
        let foremost: Vec<Foremost> =
            chambers.iter().map(|chamber| Foremost::new(physics, start, chamber, sign)).collect();
        let step = |(chamber, foremost): (&Chamber, &Foremost)| {
            let edge_kpa = foremost.chamber.goal_kpa + physics.atmosphere_kpa();
            (chamber.content_nl, foremost.volume_l(physics), edge_kpa)
        };
        Self { steps: chambers.iter().zip(&foremost).map(step).collect(), foremost, sign }
    }

    /// Rising, the largest volumes make the lowest pressures and the most flow; falling, the smallest the highest.
    fn bend(&mut self, physics: &Physics, time_ms: f64) {
        for (step, foremost) in self.steps.iter_mut().zip(&mut self.foremost) {
            foremost.step(physics, time_ms);
            step.1 = foremost.volume_l(physics);
        }
    }

    fn sum_nl(&self) -> f64 {
        self.steps.iter().map(|(content_nl, ..)| content_nl).sum()
    }

    /// What is left of each on its way, as its pressure counted so that getting nearer is up; none where it has none.
    fn heights(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        self.steps.iter().map(|(content_nl, volume_l, edge_kpa)| {
            let height = self.sign * content_nl * REFERENCE_KPA / volume_l;
            (height < self.sign * edge_kpa).then_some(height)
        })
    }

    /// The mean pressure of those on their way, absolute, and how many they are: by concavity no sharing passes more.
    fn level(&self) -> (f64, f64) {
        let (sum, count) =
            self.heights().flatten().fold((0.0, 0.0), |(sum, count), height| (sum + height, count + 1.0));
        if count > 0.0 { (self.sign * sum / count, count) } else { (REFERENCE_KPA, 0.0) }
    }

    /// Gives the air to those furthest behind, or takes it from them.
    fn add(&mut self, nl: f64) {
        /// Those within this are level, kPa.
        const LEVEL_KPA: f64 = 0.1;
        let lowest = self.heights().flatten().fold(f64::INFINITY, f64::min);
        let level: Vec<bool> = self.heights().map(|height| height.is_some_and(|it| it - lowest <= LEVEL_KPA)).collect();
        let volume_l: f64 = self.steps.iter().zip(&level).filter(|(_, level)| **level).map(|(step, _)| step.1).sum();
        for (step, _) in self.steps.iter_mut().zip(&level).filter(|(_, level)| **level) {
            step.0 += nl * step.1 / volume_l;
        }
    }
}

/// The manifold with the pump on, or the dump valve open, as soon as they can be.
struct Source {
    content_nl: f64,
    speed: f64,
    delay_ms: f64,
    time_ms: f64,
    rise: bool,
}

impl Source {
    fn new(physics: &Physics, start: &StepStart, rise: bool) -> Self {
        Self {
            content_nl: (start.truth.manifold_kpa + physics.atmosphere_kpa()) * physics.manifold_l / REFERENCE_KPA,
            speed: start.truth.pump_speed,
            delay_ms: physics.source_delay_ms(start, rise),
            time_ms: 0.0,
            rise,
        }
    }

    fn manifold_kpa(&self, physics: &Physics) -> f64 {
        physics.manifold_kpa(self.content_nl)
    }

    /// One step in which so many alike take through their valves what one takes at this absolute pressure.
    fn feed(&mut self, physics: &Physics, alike: f64, chamber_kpa: f64, into_nl: &mut dyn FnMut(f64) -> f64) {
        let flow = physics.one_way(self.manifold_kpa(physics), chamber_kpa, self.rise);
        self.step(physics, alike * into_nl(flow));
    }

    /// One step in which `into_nl` went into chambers.
    fn step(&mut self, physics: &Physics, into_nl: f64) {
        self.content_nl -= into_nl;
        let manifold_kpa = self.manifold_kpa(physics);
        let acts = self.time_ms >= self.delay_ms;
        if self.rise {
            if acts {
                self.speed += (1.0 - self.speed) * physics.speed_share;
            }
            let ceiling_nl =
                (MANIFOLD_CEILING.to_f64() + physics.atmosphere_kpa()) * physics.manifold_l / REFERENCE_KPA;
            let delivered = 1e-3 * STEP_MS * physics.pump_nl_per_s(self.speed, manifold_kpa);
            self.content_nl = (self.content_nl + delivered).min(ceiling_nl.max(self.content_nl));
        } else if acts {
            let out = physics.dump.flow_nl_per_s(manifold_kpa, physics.atmosphere_kpa());
            self.content_nl -= 1e-3 * STEP_MS * out.max(0.0);
        }
        self.time_ms += STEP_MS;
    }
}
