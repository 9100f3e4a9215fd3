//! Pump, dump valve and three segment valves to per-segment setpoints, through one sensor on the manifold.
//!
//! ```text
//!              some setpoint above zero                    nothing to do
//!  Venting ───────────────────────────▶ Closing ─────────────────────────▶ Resting (no valve open)
//!     ▲                                    │  ▲                                │
//!     │ every setpoint zero                │  │ a chamber is off, or due       │
//!     │                          a service │  └────────────────────────────────┤
//!     │                                    ▼                                   │
//!     │                                 Matching ── small ──▶ Equalising ──▶ Resting (group's valves open)
//!     │                                    │                      ▲            │
//!     │                                    └── large ──▶ Flowing ─┘            │
//!     │                                                     ▲──────────────────┘ group off by much
//! ```
//!
//! A *service* moves a group of chambers in one direction. *Matching* brings the manifold, alone, to the pressure at
//! which opening the group does what is wanted: to the group's own pressure before a long flow, so that nothing is
//! disturbed, or for a small step to the pressure whose equalisation with the group gives the setpoint. The pump's
//! coarse pulses thus end in the manifold, and the dump valve bleeds what is too much: the chambers see metered doses.
//! *Flowing* runs the pump (or the dump valve) with the group open, lets go of each chamber as it arrives, takes in
//! each as the level passes it, and stops by the level at which all would come to rest, with what will still flow
//! during the dead time counted. *Equalising* waits for the air to rest: only then is the sensor's reading the
//! chambers' pressure. A group that has arrived stays open, so that it goes on being seen.

use crate::actuation::{Actuation, Passage, PerSegment};
use crate::division::divide;
use crate::observer::Observer;
use crate::units::Pressure;
use fixed::types::I16F16;

/// The highest pressure that the regulator asks of the manifold.
pub const MANIFOLD_CEILING: Pressure = Pressure::from_kpa(160);

/// A chamber at rest is served when it is off by more than this: half of the sensor's display resolution.
const HOLD_BAND: Pressure = Pressure::from_milli_kpa(500);
/// The same while its setpoint moves: following closer would only wear the relay.
const MOVING_BAND: Pressure = Pressure::from_milli_kpa(2500);
/// From this error on, air flows continuously instead of in one metered dose.
const FLOW_BAND: Pressure = Pressure::from_milli_kpa(6000);
/// A chamber within this of the group's level is at the group's level.
const LEVEL_BAND: Pressure = Pressure::from_milli_kpa(1500);
/// A flow to a resting setpoint stops short by this, and a metered dose does the rest: no overshoot.
const FLOW_MARGIN: Pressure = Pressure::from_milli_kpa(1200);
/// Below this a chamber whose setpoint is zero counts as empty.
const EMPTY: Pressure = Pressure::from_milli_kpa(1000);

/// Ticks after which a closed chamber is looked at again, counted from its last look: bends settle, and seals leak.
const LOOK_AGAIN: [u32; 4] = [300, 1000, 3000, 8000];
/// Shortest pump pulse in ticks: below it a relay does not follow.
const PUMP_MIN_TICKS: u16 = 15;
/// Shortest pulse of the dump valve in ticks.
const DUMP_MIN_TICKS: u16 = 3;
/// Longest pulse in matching, in ticks: then it is measured again.
const PULSE_MAX_TICKS: u16 = 120;
/// Ticks from a pulse's end to a settled reading, beside the dead time: pump's run-down, sensor's lag, filter.
const SETTLE_TICKS: u16 = 24;
/// Pulses after which matching takes what it has.
const MAX_PULSES: u8 = 12;

/// Chambers that act together.
type Group = PerSegment<bool>;
const NONE: Group = [false; 3];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Rise,
    Fall,
}

impl Direction {
    /// `value` counted so that getting nearer is up.
    fn signed(self, value: Pressure) -> Pressure {
        match self {
            Self::Rise => value,
            Self::Fall => Pressure::ZERO - value,
        }
    }
}

/// What a service wants of the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Service {
    direction: Direction,
    group: Group,
    /// A continuous flow; otherwise one metered dose, or only a look.
    flow: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Everything open: every setpoint is zero.
    Venting,
    /// Everything closed, waiting for the valves to have closed.
    Closing,
    /// Pump and dump rest; the group's valves are open, so it is seen.
    Resting(Group),
    /// The manifold alone is brought to a pressure.
    Matching { service: Service, pulse: Pulse, pulses: u8 },
    /// Air flows in or out with the group's valves open.
    Flowing(Service),
    /// Pump and dump rest; waiting for the group's valves to let the pressures equalise.
    Equalising(Group),
}

/// A metered action on the manifold alone, then a wait for a settled reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pulse {
    pump: bool,
    on: u16,
    wait: u16,
    /// The manifold's pressure before, and how much it should change (for learning); zero: learn nothing.
    before: Pressure,
    expected: Pressure,
}

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Regulator {
    phase: Phase,
    /// Ticks in this phase.
    ticks: u32,
    setpoints: PerSegment<Pressure>,
    /// Ticks since each setpoint moved last.
    still: PerSegment<u32>,
    /// Ticks since each chamber was seen at rest, and how often it was since its setpoint moved.
    unseen: PerSegment<u32>,
    looks: PerSegment<u8>,
    /// What a pulse really moved over what it should have: learned.
    pump_gain: I16F16,
    dump_gain: I16F16,
    /// The group's level when a flow began, and what the flow should have brought it to.
    flow_from: Pressure,
    flow_to: Pressure,
    pump_was_on: bool,
    pump_ticks: u16,
    dump_was_open: bool,
}

impl Default for Regulator {
    fn default() -> Self {
        Self::new()
    }
}

impl Regulator {
    /// Vented.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            phase: Phase::Venting,
            ticks: 0,
            setpoints: [Pressure::ZERO; 3],
            still: [0; 3],
            unseen: [0; 3],
            looks: [0; 3],
            pump_gain: I16F16::ONE,
            dump_gain: I16F16::ONE,
            flow_from: Pressure::ZERO,
            flow_to: Pressure::ZERO,
            pump_was_on: false,
            pump_ticks: 0,
            dump_was_open: true,
        }
    }

    /// One tick: what to do so that each chamber follows its setpoint. Setpoints are taken as 0..=150 kPa.
    pub fn step(&mut self, setpoints: PerSegment<Pressure>, observer: &mut Observer) -> Actuation {
        let limit = Pressure::from_kpa(150);
        self.take_setpoints(setpoints.map(|setpoint| setpoint.clamp(Pressure::ZERO, limit)));
        let before = self.phase;
        let actuation = self.act(observer);
        // A service that goes on keeps its clock, whatever its group has become.
        let same = core::mem::discriminant(&before) == core::mem::discriminant(&self.phase);
        self.ticks = if same { self.ticks.saturating_add(1) } else { 0 };
        self.pump_ticks = if actuation.pump == self.pump_was_on { self.pump_ticks.saturating_add(1) } else { 0 };
        self.pump_was_on = actuation.pump;
        self.dump_was_open = actuation.dump == Passage::Open;
        actuation
    }

    /// Back to venting, at once; what was learned stays.
    pub fn vent(&mut self) -> Actuation {
        (self.phase, self.ticks, self.pump_was_on, self.pump_ticks) = (Phase::Venting, 0, false, 0);
        self.setpoints = [Pressure::ZERO; 3];
        Actuation::SAFE
    }

    fn take_setpoints(&mut self, setpoints: PerSegment<Pressure>) {
        let old = self.setpoints.iter().zip(setpoints);
        let clocks = self.still.iter_mut().zip(&mut self.unseen).zip(&mut self.looks);
        for ((old, new), ((still, unseen), looks)) in old.zip(clocks) {
            *unseen = unseen.saturating_add(1);
            if *old == new {
                *still = still.saturating_add(1);
            } else {
                (*still, *looks) = (0, 0);
            }
        }
        self.setpoints = setpoints;
    }

    fn act(&mut self, observer: &mut Observer) -> Actuation {
        if self.setpoints == [Pressure::ZERO; 3] {
            self.phase = Phase::Venting;
            return Actuation::SAFE;
        }
        let dead = u32::from(observer.pneumatics().dead_ticks.get());
        match self.phase {
            Phase::Venting => {
                self.phase = Phase::Closing;
                Actuation::HOLD
            }
            Phase::Closing => {
                if self.ticks > dead + 12 {
                    self.phase = match self.next_service(observer) {
                        Some(service) => Phase::Matching { service, pulse: Pulse::NONE, pulses: 0 },
                        None => Phase::Resting(NONE),
                    };
                }
                Actuation::HOLD
            }
            Phase::Resting(group) => self.rest(group, observer),
            Phase::Matching { service, pulse, pulses } => self.matching(service, pulse, pulses, observer),
            Phase::Flowing(service) => self.flow(service, observer),
            Phase::Equalising(group) => {
                let calm = (observer.manifold() - observer.manifold_at_rest()).abs() < Pressure::from_milli_kpa(250);
                if observer.air_rests() && (self.ticks > 30 + dead && calm || self.ticks > 200) {
                    observer.equalised(group, self.flow_from, self.flow_to);
                    (self.flow_from, self.flow_to) = (Pressure::ZERO, Pressure::ZERO);
                    self.seen(group);
                    self.phase = Phase::Resting(group);
                }
                open(group)
            }
        }
    }

    /// Open chambers are seen; anything that needs a service closes them first, unless the group itself goes on.
    fn rest(&mut self, group: Group, observer: &mut Observer) -> Actuation {
        for (index, unseen) in self.unseen.iter_mut().enumerate() {
            if member(group, index) {
                *unseen = 0;
            }
        }
        let Some(service) = self.next_service(observer) else { return open(group) };
        if service.flow && service.group == group {
            self.phase = Phase::Flowing(service);
            open(group)
        } else if group != NONE && service.group == group && self.ticks < 60 && !self.moving(group) {
            // The reading is still the one that ended the last service: let the filter settle before acting on it.
            open(group)
        } else if group == NONE {
            self.phase = Phase::Matching { service, pulse: Pulse::NONE, pulses: 0 };
            Actuation::HOLD
        } else {
            self.phase = Phase::Closing;
            Actuation::HOLD
        }
    }

    /// The most urgent thing to do: the direction of the largest error beyond its band, with every chamber that goes
    /// the same way from the same level; else a look at a chamber that is due for one.
    fn next_service(&self, observer: &Observer) -> Option<Service> {
        let chambers = observer.chambers();
        let worst =
            (0..3).filter(|&index| self.off(index, observer)).max_by_key(|&index| self.error(index, &chambers).abs());
        let Some(worst) = worst else {
            let due = (0..3).find(|&index| self.look_due(index, observer))?;
            return Some(Service { direction: Direction::Rise, group: only(due), flow: false });
        };
        let direction = if self.error(worst, &chambers) > Pressure::ZERO { Direction::Rise } else { Direction::Fall };
        // Of those that go this way, start with the one that is furthest behind: the level passes the others.
        let goes = |index: usize| direction.signed(self.error(index, &chambers)) > HOLD_BAND;
        let level = |index: usize| direction.signed(get(&chambers, index));
        let first = (0..3).filter(|&index| goes(index)).min_by_key(|&index| level(index))?;
        let mut group = NONE;
        for (index, chosen) in group.iter_mut().enumerate() {
            *chosen = goes(index) && (level(index) - level(first)) < LEVEL_BAND;
        }
        let flow = direction.signed(self.error(first, &chambers)) > FLOW_BAND
            || (direction == Direction::Fall && get(&self.setpoints, first) == Pressure::ZERO);
        let target = get(&self.setpoints, first);
        for (index, chosen) in group.iter_mut().enumerate() {
            // A flow takes those that have some way to go; a dose has one target, and the others get their own.
            *chosen &= if flow {
                index == first || direction.signed(self.error(index, &chambers)) > FLOW_BAND
            } else {
                (get(&self.setpoints, index) - target).abs() < HOLD_BAND
            };
        }
        Some(Service { direction, group, flow })
    }

    fn error(&self, index: usize, chambers: &PerSegment<Pressure>) -> Pressure {
        get(&self.setpoints, index) - get(chambers, index)
    }

    /// Whether a chamber needs a service.
    fn off(&self, index: usize, observer: &Observer) -> bool {
        let error = self.error(index, &observer.chambers());
        if get(&self.setpoints, index) == Pressure::ZERO {
            return Pressure::ZERO - error > EMPTY;
        }
        error.abs() > if get(&self.still, index) > 0 { HOLD_BAND } else { MOVING_BAND }
    }

    fn look_due(&self, index: usize, observer: &Observer) -> bool {
        let after = LOOK_AGAIN.get(usize::from(get(&self.looks, index))).or(LOOK_AGAIN.last());
        let empty = get(&self.setpoints, index) == Pressure::ZERO;
        let near = get(&observer.chambers(), index) > EMPTY;
        !empty && near && after.is_some_and(|&ticks| get(&self.unseen, index) > ticks)
    }

    fn moving(&self, group: Group) -> bool {
        (0..3).any(|index| member(group, index) && get(&self.still, index) == 0)
    }

    fn seen(&mut self, group: Group) {
        for (index, (unseen, looks)) in self.unseen.iter_mut().zip(&mut self.looks).enumerate() {
            if member(group, index) {
                (*unseen, *looks) = (0, looks.saturating_add(1));
            }
        }
    }

    /// Brings the manifold, alone, into the service's window by pulses, then opens the group.
    fn matching(&mut self, service: Service, pulse: Pulse, pulses: u8, observer: &mut Observer) -> Actuation {
        if pulse.on > 0 {
            let pulse = Pulse { on: pulse.on - 1, ..pulse };
            self.phase = Phase::Matching { service, pulse, pulses };
            let dump = if pulse.pump { Passage::Closed } else { Passage::Open };
            return Actuation { pump: pulse.pump, dump, ..Actuation::HOLD };
        }
        if pulse.wait > 0 {
            let pulse = Pulse { wait: pulse.wait - 1, ..pulse };
            self.phase = Phase::Matching { service, pulse, pulses };
            return Actuation::HOLD;
        }
        self.learn(&pulse, observer);
        let manifold = observer.manifold();
        let (low, aim, high) = self.window(service, observer);
        if (manifold >= low && manifold <= high) || pulses >= MAX_PULSES {
            self.phase = if service.flow { Phase::Flowing(service) } else { Phase::Equalising(service.group) };
            return open(service.group);
        }
        let pulse = self.pulse_to(aim, manifold, observer);
        self.phase = Phase::Matching { service, pulse, pulses: pulses.saturating_add(1) };
        Actuation::HOLD
    }

    /// Lowest, best and highest pressure of the manifold at which the group may be opened.
    fn window(&self, service: Service, observer: &Observer) -> (Pressure, Pressure, Pressure) {
        let chambers = observer.chambers();
        let (mut sum, mut count, mut error) = (I16F16::ZERO, 0, Pressure::MAX);
        for index in (0..3).filter(|&index| member(service.group, index)) {
            sum = sum.saturating_add(get(&chambers, index).to_fixed());
            count += 1;
            error = error.min(service.direction.signed(self.error(index, &chambers)));
        }
        let level = Pressure::from_fixed(sum.checked_div_int(count).unwrap_or(I16F16::ZERO));
        let volume = observer.volume(service.group);
        let ceiling = MANIFOLD_CEILING - Pressure::from_kpa(2);
        if service.flow {
            // From the group's own level to where equalising would already reach the setpoint.
            let far = (error - FLOW_MARGIN).scaled(volume).clamp(LEVEL_BAND, Pressure::from_kpa(40));
            let near = Pressure::ZERO - LEVEL_BAND;
            let at = |offset: Pressure| (level + service.direction.signed(offset)).min(ceiling);
            let (one, other) = (at(near), at(far));
            return (one.min(other), one.midpoint(other).max(Pressure::ZERO), one.max(other));
        }
        // Equalising turns this surplus into the missing pressure; the window is a third of a kPa in the chamber, or
        // more while the setpoint runs away from anything finer.
        let signed_error = service.direction.signed(error);
        let aim = (level + signed_error.scaled(volume)).clamp(Pressure::ZERO, ceiling);
        let half = Pressure::from_milli_kpa(if self.moving(service.group) { 1500 } else { 300 }).scaled(volume);
        (aim - half, aim, aim + half)
    }

    /// The pulse that brings the manifold, alone, to `aim`.
    fn pulse_to(&self, aim: Pressure, manifold: Pressure, observer: &Observer) -> Pulse {
        let model = observer.pneumatics();
        let midway = manifold.midpoint(aim);
        let pump = aim > manifold;
        let (rate, gain, minimum) = if pump {
            (model.pump_flow(midway), self.pump_gain, PUMP_MIN_TICKS)
        } else {
            (model.valve_flow(midway, Pressure::ZERO), self.dump_gain, DUMP_MIN_TICKS)
        };
        // A hundredth of a kPa a tick: no pump is slower, and the quotient stays defined.
        let rate = rate.saturating_mul(gain).max(const { I16F16::lit("0.01") });
        let change = (aim - manifold).abs();
        let wanted = divide(change.to_fixed(), rate).unwrap_or(I16F16::MAX).round().to_bits() >> 16;
        let on = (wanted.clamp(0, i32::from(PULSE_MAX_TICKS)) as u16).max(minimum);
        // Only a pulse of some length says something of the rate.
        let learns = on > 2 * minimum && on < PULSE_MAX_TICKS;
        let wait = u16::from(model.dead_ticks.get()) + SETTLE_TICKS;
        Pulse { pump, on, wait, before: manifold, expected: if learns { change } else { Pressure::ZERO } }
    }

    fn learn(&mut self, pulse: &Pulse, observer: &Observer) {
        if pulse.expected < Pressure::from_kpa(4) {
            return;
        }
        let moved = (observer.manifold() - pulse.before).abs();
        let ratio = divide(moved.to_fixed(), pulse.expected.to_fixed()).unwrap_or(I16F16::ONE);
        let gain = if pulse.pump { &mut self.pump_gain } else { &mut self.dump_gain };
        // A third of the way each time, and never beyond what worn or oversized parts could explain.
        let correction = I16F16::ONE.saturating_add(ratio.saturating_sub(I16F16::ONE) / 3);
        *gain = gain.saturating_mul(correction).clamp(const { I16F16::lit("0.3") }, const { I16F16::lit("3") });
    }

    /// Pump or dump with the group open.
    fn flow(&mut self, mut service: Service, observer: &mut Observer) -> Actuation {
        let direction = service.direction;
        let model = *observer.pneumatics();
        let dead = I16F16::from_num(model.dead_ticks.get());
        let chambers = observer.chambers();
        let flows = observer.flows();

        // Let go of those that will have arrived by the time their valve closes, as long as another goes on.
        for index in 0..3 {
            let others = (0..3).any(|other| {
                other != index
                    && member(service.group, other)
                    && self.ahead(other, direction) > self.ahead(index, direction) + HOLD_BAND
            });
            let coming = Pressure::from_fixed(get(&flows, index).saturating_mul(dead));
            let arriving = direction.signed(get(&chambers, index) + coming);
            let margin = if get(&self.still, index) > 0 { HOLD_BAND } else { Pressure::ZERO };
            let missing = self.ahead(index, direction) - margin - arriving;
            if member(service.group, index) && others && missing <= Pressure::ZERO {
                service.group = without(service.group, index);
            }
        }
        // What will still flow after a stop now.
        let rate = if direction == Direction::Rise {
            let flow = model.pump_flow(observer.manifold()).saturating_mul(self.pump_gain);
            flow.saturating_mul(I16F16::from_num(observer.pump_ticks_pending()))
        } else {
            let flow = model.valve_flow(observer.manifold(), Pressure::ZERO).saturating_mul(self.dump_gain);
            flow.saturating_mul(I16F16::from_num(observer.dump_ticks_pending()))
        };
        let volume = observer.volume(service.group);
        let coming = Pressure::from_fixed(divide(rate, volume).unwrap_or(I16F16::ZERO));
        let level = direction.signed(observer.level(service.group)) + coming;
        // Take in those that go the same way and whose pressure the level has reached.
        for index in 0..3 {
            let reached = level + HOLD_BAND >= direction.signed(get(&chambers, index));
            let goes = direction.signed(self.error(index, &chambers)) > FLOW_BAND;
            if !member(service.group, index) && goes && reached {
                service.group = with(service.group, index);
            }
        }
        // The furthest setpoint of the group ends the flow: those with nearer ones are let go on the way.
        let goal = (0..3)
            .filter(|&index| member(service.group, index))
            .map(|index| self.ahead(index, direction))
            .max()
            .unwrap_or(level);
        let moving = self.moving(service.group);
        let stop = if moving { goal } else { goal - FLOW_MARGIN };
        let to_zero = direction == Direction::Fall && goal == Pressure::ZERO;
        let stop = if to_zero { Pressure::ZERO - EMPTY.midpoint(Pressure::ZERO) } else { stop };
        let arrived = level >= stop;
        if self.ticks == 0 {
            self.flow_from = observer.level(service.group);
        }
        self.flow_to = direction.signed(level);

        let strayed = (0..3).any(|index| !member(service.group, index) && self.off(index, observer));
        let turned = moving && level > goal + MOVING_BAND;
        self.phase = if arrived && (!moving || strayed) || turned {
            Phase::Equalising(service.group)
        } else {
            Phase::Flowing(service)
        };
        let mut actuation = open(service.group);
        // While setpoints move, pump and dump valve start late: one longer run instead of chatter.
        let late = level + MOVING_BAND.midpoint(Pressure::ZERO) < stop;
        let behind = |running: bool| if moving && !running { late } else { !arrived };
        let goes_on = matches!(self.phase, Phase::Flowing(_));
        if direction == Direction::Rise {
            let pending = I16F16::from_num(observer.pump_ticks_pending());
            let rise = Pressure::from_fixed(model.pump_flow(observer.manifold()).saturating_mul(pending));
            let full = observer.manifold() + rise >= MANIFOLD_CEILING;
            // The relay keeps its shortest times, except that an end is an end.
            let keeps = self.pump_ticks < PUMP_MIN_TICKS;
            let wanted = if keeps { self.pump_was_on } else { behind(self.pump_was_on) };
            actuation.pump = wanted && !full && goes_on;
        } else if behind(self.dump_was_open) && goes_on {
            actuation.dump = Passage::Open;
        }
        actuation
    }

    /// A chamber's setpoint, counted so that getting nearer is up.
    fn ahead(&self, index: usize, direction: Direction) -> Pressure {
        direction.signed(get(&self.setpoints, index))
    }
}

impl Pulse {
    const NONE: Self = Self { pump: false, on: 0, wait: 0, before: Pressure::ZERO, expected: Pressure::ZERO };
}

/// Pump and dump at rest, the group's valves open.
fn open(group: Group) -> Actuation {
    let segments = group.map(|chosen| if chosen { Passage::Open } else { Passage::Closed });
    Actuation { segments, ..Actuation::HOLD }
}

fn member(group: Group, index: usize) -> bool {
    get(&group, index)
}

fn only(index: usize) -> Group {
    with(NONE, index)
}

fn with(mut group: Group, index: usize) -> Group {
    if let Some(chosen) = group.get_mut(index) {
        *chosen = true;
    }
    group
}

fn without(mut group: Group, index: usize) -> Group {
    if let Some(chosen) = group.get_mut(index) {
        *chosen = false;
    }
    group
}

/// The value at `index`, which is always one of three; the default keeps a panic out of the code.
fn get<T: Copy + Default>(values: &PerSegment<T>, index: usize) -> T {
    values.get(index).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observer::Pneumatics;
    use proptest::prelude::*;

    fn kpa(values: [i16; 3]) -> PerSegment<Pressure> {
        values.map(Pressure::from_kpa)
    }

    /// Steps the regulator against readings that do not react; returns what it did last.
    fn against(reading: i16, setpoints: PerSegment<Pressure>, ticks: u32) -> Actuation {
        let mut observer = Observer::new(Pneumatics::NOMINAL);
        let mut regulator = Regulator::new();
        let mut last = Actuation::SAFE;
        for _ in 0..ticks {
            observer.measure(Pressure::from_kpa(reading));
            last = regulator.step(setpoints, &mut observer);
            observer.commanded(&last);
        }
        last
    }

    #[test]
    fn zero_everywhere_vents() {
        for ticks in [1, 2, 500] {
            assert_eq!(against(0, kpa([0; 3]), ticks), Actuation::SAFE);
            assert_eq!(against(150, kpa([0; 3]), ticks), Actuation::SAFE);
        }
    }

    #[test]
    fn a_large_step_runs_the_pump_into_the_chambers_that_rise() {
        let actuation = against(0, kpa([60, 0, 60]), 60);
        assert!(actuation.pump);
        assert_eq!(actuation.dump, Passage::Closed);
        assert_eq!(actuation.segments, [Passage::Open, Passage::Closed, Passage::Open]);
    }

    #[test]
    fn the_pump_stops_when_the_manifold_is_at_its_ceiling() {
        for ticks in 40..400 {
            assert!(!against(160, kpa([150; 3]), ticks).pump, "tick {ticks}");
        }
    }

    #[test]
    fn a_setpoint_beyond_the_limits_is_taken_as_the_limit() {
        assert_eq!(against(0, kpa([1000, 0, 0]), 60), against(0, kpa([150, 0, 0]), 60));
        assert_eq!(against(0, kpa([-50; 3]), 60), Actuation::SAFE);
    }

    proptest! {
        /// Whatever the sensor says: pump and dump never work against each other, and zero setpoints vent at once.
        #[test]
        fn no_reading_makes_it_contradict_itself(
            readings in prop::collection::vec(any::<i32>(), 1..600),
            setpoints in prop::array::uniform3(0_i16..=150),
        ) {
            let mut observer = Observer::new(Pneumatics::NOMINAL);
            let mut regulator = Regulator::new();
            for bits in readings {
                observer.measure(Pressure::from_bits(bits));
                let actuation = regulator.step(kpa(setpoints), &mut observer);
                prop_assert!(!(actuation.pump && actuation.dump == Passage::Open));
                observer.commanded(&actuation);
            }
            observer.measure(Pressure::MAX);
            prop_assert_eq!(regulator.step(kpa([0; 3]), &mut observer), Actuation::SAFE);
        }
    }
}
