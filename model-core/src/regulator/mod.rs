//! Pump, dump valve and three segment valves to per-segment setpoints, through one sensor on the manifold.
//!
//! ```text
//!              some setpoint above zero              someone is beyond the band
//!  Venting ───────────────────────────▶ Resting ─────────────────────────────────▶ Moving up or down
//!     ▲                                  │  ▲  ▲                                      │   │  ▲
//!     │ every setpoint zero              │  │  └──────────────────────────────────────┘   └──┘
//!     └── from any phase       a closed  │  │ manifold there,    all who wanted have it,     the other way
//!                              chamber   ▼  │ its valve opens    nobody is off               is worse
//!                              is due   Looking
//! ```
//!
//! All decisions are by the observer's model, which is a dead time ahead: what is commanded now acts there now. While
//! *moving*, the manifold is a rail above (or below) the chambers that want air (or want to lose it): each has its valve open
//! until it will have arrived, and the pump (or the dump valve) works until the rail holds the air that is missing. So
//! chambers at one level rise together; of those with different setpoints each is let go on the way, and each that the level
//! passes is taken in. Who is filled or emptied fast will recoil as it grows or shrinks, and is taken a little further.
//! *Resting*, valves stay open where manifold and chambers will rest at their setpoints: then they are seen. A closed chamber
//! is *looked* at after a while: the manifold, alone, is brought to its pressure, then its valve opens.
//!
//! A setpoint that moves is followed where it will be when commands act, with a wide band and a lead of the same size: few
//! switchings, and no lag on the mean.

use crate::actuation::{Actuation, Passage, PerSegment};
use crate::observer::{Ahead, Observer};
use crate::units::Pressure;
use fixed::types::I16F16;

mod flow;
mod hunting;
mod reference;

use hunting::Hunting;
use reference::Setpoint;

/// The highest pressure that the regulator asks of the manifold.
pub const MANIFOLD_CEILING: Pressure = Pressure::from_kpa(157);

/// Chambers that act together.
type Group = PerSegment<bool>;
const NONE: Group = [false; 3];

const fn milli_kpa(value: i32) -> Pressure {
    Pressure::from_milli_kpa(value)
}

/// A chamber at rest is served when it is off by more than this: half of the sensor's display resolution.
const HOLD_BAND: Pressure = milli_kpa(500);
/// The same when the manifold has a long way to it: the way is worth more than a small error.
const FAR_BAND: Pressure = milli_kpa(1300);
const FAR: Pressure = milli_kpa(10_000);
/// The same while its setpoint moves: following closer would only wear relay and valves.
const MOVING_BAND: Pressure = milli_kpa(2000);
/// The same when the setpoint comes towards the chamber by itself.
const AGAINST_BAND: Pressure = milli_kpa(4000);
/// While its setpoint moves a chamber is taken so far beyond it.
const MOVING_LEAD: Pressure = milli_kpa(1800);
/// When a service begins, chambers that are off by more than this come along.
const JOIN_BAND: Pressure = milli_kpa(250);
/// The most by which a chamber is taken beyond its setpoint because it will sag.
const SAG_MOST: Pressure = milli_kpa(900);
/// While air flows to others it joins them only when it is off by more than this: their way would be longer.
const PASSING_BAND: Pressure = milli_kpa(1600);
/// Below this a chamber whose setpoint is zero counts as empty.
const EMPTY: Pressure = milli_kpa(700);
/// A valve that has done its work stays open when the manifold is within this of its chamber.
const LEVEL_BAND: Pressure = milli_kpa(1000);
/// Open chambers stay open when they will rest within this of their setpoints, and while those move.
const STAY: Pressure = milli_kpa(1500);
const STAY_MOVING: Pressure = milli_kpa(4000);
/// The manifold may be on the wrong side of an open chamber by this before its valve closes.
const BACKFLOW_BAND: Pressure = milli_kpa(3000);
/// A valve opens for a look when the manifold is within this of its chamber.
const LOOK_BAND: Pressure = milli_kpa(2000);
/// Shortest time of the pump's relay in ticks, either way: below it a relay does not follow.
const PUMP_MIN_TICKS: u32 = 15;
/// No change of the pump comes sooner after the last: the relay's driver would not follow.
const RELAY_TICKS: u32 = 5;
/// Shortest time of a valve in ticks.
const VALVE_MIN_TICKS: u32 = 3;
/// Ticks after which a closed chamber is looked at again, counted from its last look: bends settle, and seals leak.
const LOOK_AGAIN: [u32; 3] = [350, 2000, 6000];
/// Ticks for which an opened chamber is looked at.
const LOOK_TICKS: u32 = 60;

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

    const fn other(self) -> Self {
        match self {
            Self::Rise => Self::Fall,
            Self::Fall => Self::Rise,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Everything open: every setpoint is zero.
    Venting,
    /// Pump and dump rest; the valves of the group are open, so that it is seen.
    Resting,
    /// Air flows one way.
    Moving(Direction),
    /// The manifold alone is brought to the pressure of a chamber that has not been seen for long.
    Looking(usize),
}

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Regulator {
    phase: Phase,
    setpoints: PerSegment<Setpoint>,
    /// Who is served.
    wants: Group,
    /// What was commanded last, and for how many ticks: pump, dump, valves.
    last: Actuation,
    pump_ticks: u32,
    dump_ticks: u32,
    valve_ticks: PerSegment<u32>,
    /// Whose pressure the manifold has, nearly.
    level: Group,
    /// Ticks since each chamber was seen at rest, and how often it was since its setpoint moved.
    unseen: PerSegment<u32>,
    looks: PerSegment<u8>,
    hunting: PerSegment<Hunting>,
}

impl Default for Regulator {
    fn default() -> Self {
        Self::new()
    }
}

/// What one tick decides by.
struct View {
    ahead: Ahead,
    /// Setpoint of the moment at which commands act, less the chamber's pressure then.
    errors: PerSegment<Pressure>,
    volumes: PerSegment<I16F16>,
    /// What the sensor says of the manifold, should the model be wrong.
    measured: Pressure,
}

impl View {
    /// Whether the pump must stop for the manifold's sake.
    fn full(&self) -> bool {
        self.measured + milli_kpa(500) >= MANIFOLD_CEILING
            || self.ahead.manifold + self.ahead.coming >= MANIFOLD_CEILING
    }
}

impl Regulator {
    /// Vented.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            phase: Phase::Venting,
            setpoints: [Setpoint::ZERO; 3],
            wants: NONE,
            last: Actuation::SAFE,
            pump_ticks: u32::MAX,
            dump_ticks: u32::MAX,
            valve_ticks: [u32::MAX; 3],
            level: NONE,
            unseen: [0; 3],
            looks: [0; 3],
            hunting: [Hunting::NONE; 3],
        }
    }

    /// One tick: what to do so that each chamber follows its setpoint. Setpoints are taken as 0..=150 kPa.
    pub fn step(&mut self, setpoints: PerSegment<Pressure>, observer: &mut Observer) -> Actuation {
        let limit = Pressure::from_kpa(150);
        let mut jumped = false;
        for ((setpoint, hunting), new) in self.setpoints.iter_mut().zip(&mut self.hunting).zip(setpoints) {
            let jumps = setpoint.take(new.clamp(Pressure::ZERO, limit));
            hunting.tick(jumps || setpoint.moves());
            jumped |= jumps;
        }
        if self.setpoints.iter().all(|setpoint| setpoint.value == Pressure::ZERO) {
            return self.vent();
        }
        let mut view = View {
            ahead: observer.ahead(),
            errors: [Pressure::ZERO; 3],
            volumes: observer.volumes(),
            measured: observer.manifold(),
        };
        let ahead_ticks = observer.pneumatics().dead_ticks.get();
        for ((error, setpoint), &chamber) in view.errors.iter_mut().zip(&self.setpoints).zip(&view.ahead.chambers) {
            *error = setpoint.after(ahead_ticks) - chamber;
        }
        for index in 0..3 {
            let level = (view.ahead.manifold - get(&view.ahead.chambers, index)).abs() < LOOK_BAND;
            set(&mut self.level, index, level);
        }
        let actuation = self.act(jumped, &view);
        let actuation = self.as_the_relay_can(actuation, &view);
        self.remember(actuation);
        actuation
    }

    /// Whatever ended it, the pump keeps on or off for as long as its relay does anyway: so what is commanded is what comes.
    /// The ceiling alone goes before.
    fn as_the_relay_can(&self, actuation: Actuation, view: &View) -> Actuation {
        let changes = actuation.pump != self.last.pump;
        if !changes || self.pump_ticks >= RELAY_TICKS || view.full() {
            return actuation;
        }
        let dump = if self.last.pump { Passage::Closed } else { actuation.dump };
        Actuation { pump: self.last.pump, dump, ..actuation }
    }

    /// Back to venting, at once; what was learned stays.
    pub fn vent(&mut self) -> Actuation {
        (self.phase, self.wants) = (Phase::Venting, NONE);
        self.setpoints = [Setpoint::ZERO; 3];
        self.remember(Actuation::SAFE);
        Actuation::SAFE
    }

    fn remember(&mut self, actuation: Actuation) {
        let count = |ticks: &mut u32, same: bool| *ticks = if same { ticks.saturating_add(1) } else { 0 };
        count(&mut self.pump_ticks, actuation.pump == self.last.pump);
        count(&mut self.dump_ticks, actuation.dump == self.last.dump);
        for ((ticks, new), old) in self.valve_ticks.iter_mut().zip(actuation.segments).zip(self.last.segments) {
            count(ticks, new == old);
        }
        for index in 0..3 {
            let seen =
                actuation.segments.get(index) == Some(&Passage::Open) && get(&self.valve_ticks, index) > LOOK_TICKS;
            if let (Some(unseen), Some(looks)) = (self.unseen.get_mut(index), self.looks.get_mut(index)) {
                if seen {
                    *looks = looks.saturating_add(u8::from(*unseen > LOOK_TICKS));
                    *unseen = 0;
                } else {
                    *unseen = unseen.saturating_add(1);
                }
            }
        }
        self.last = actuation;
    }

    fn act(&mut self, jumped: bool, view: &View) -> Actuation {
        if self.phase == Phase::Venting {
            self.phase = Phase::Resting;
        }
        self.choose(jumped, view);
        match self.phase {
            Phase::Moving(direction) => self.flow(direction, view),
            Phase::Looking(index) => self.look(index, view),
            Phase::Resting | Phase::Venting => self.rest(view),
        }
    }

    /// Which way air shall flow, and who shall take part.
    fn choose(&mut self, jumped: bool, view: &View) {
        if let Phase::Moving(direction) = self.phase {
            for index in 0..3 {
                let signed = direction.signed(get(&view.errors, index));
                if member(self.wants, index) {
                    // What comes without more pump or dump, and is near enough, is let come.
                    let idle = !self.last.pump && self.last.dump == Passage::Closed;
                    let near = idle && signed < milli_kpa(300) && !self.set_moves(index);
                    let far = if self.follows(index, direction) { MOVING_BAND } else { Pressure::ZERO };
                    let done = near || signed + self.beyond(index, direction, view) + far <= Pressure::ZERO;
                    set(&mut self.wants, index, !done || jumped && signed > JOIN_BAND);
                } else if signed > if jumped { JOIN_BAND } else { self.band(index, direction, view).max(PASSING_BAND) }
                {
                    set(&mut self.wants, index, true);
                }
            }
        }
        let off = |direction: Direction| {
            (0..3)
                .map(|index| Self::lasting(index, direction, view) - self.band(index, direction, view))
                .max()
                .unwrap_or(Pressure::ZERO)
        };
        let (rise, fall) = (off(Direction::Rise), off(Direction::Fall));
        let worst = rise.max(fall);
        let next = if rise > fall { Direction::Rise } else { Direction::Fall };
        match self.phase {
            Phase::Moving(direction) => {
                let done = self.wants == NONE;
                let other = off(direction.other());
                // Chambers that follow share the time; those that step wait for each other.
                let urgent = other > Pressure::ZERO && other > off(direction) + milli_kpa(3000) && self.any_moving();
                if done && worst <= Pressure::ZERO {
                    self.phase = Phase::Resting;
                } else if done || urgent || jumped {
                    self.begin(next, view);
                }
            }
            Phase::Resting | Phase::Looking(_) => {
                // A reading just taken is let settle.
                let settling = (0..3).any(|index| {
                    self.last.segments.get(index) == Some(&Passage::Open) && get(&self.valve_ticks, index) < 40
                }) && worst < milli_kpa(1500);
                if worst > Pressure::ZERO && !settling {
                    self.begin(next, view);
                } else if self.phase == Phase::Resting
                    && !self.any_moving()
                    && !(0..3).any(|index| self.looked_at(index))
                    && let Some(index) = (0..3).find(|&index| self.look_due(index, view))
                {
                    self.phase = Phase::Looking(index);
                }
            }
            Phase::Venting => {}
        }
    }

    /// How far a chamber is behind, less what its own growth will mend.
    fn lasting(index: usize, direction: Direction, view: &View) -> Pressure {
        let error = direction.signed(get(&view.errors, index));
        let mends = (Pressure::ZERO - direction.signed(get(&view.ahead.sags, index))).clamp(Pressure::ZERO, SAG_MOST);
        error - mends.midpoint(Pressure::ZERO)
    }

    fn begin(&mut self, direction: Direction, view: &View) {
        self.phase = Phase::Moving(direction);
        for index in 0..3 {
            let signed = direction.signed(get(&view.errors, index));
            // Who follows alongside comes along, so that its valve can stay open.
            let along = self.follows(index, direction) && signed > Pressure::ZERO - MOVING_BAND;
            // For a small error the manifold makes no long way.
            let near = (view.ahead.manifold - get(&view.ahead.chambers, index)).abs() < FAR;
            let joins = signed > if near { JOIN_BAND } else { self.band(index, direction, view) } || along;
            set(&mut self.wants, index, joins);
            if let (true, Some(hunting)) = (joins, self.hunting.get_mut(index)) {
                hunting.served(direction);
            }
            // Who needs air once more may leak, and is looked at soon again.
            if let (true, Some(looks)) = (joins, self.looks.get_mut(index)) {
                *looks = 0;
            }
        }
    }

    /// Whether its setpoint moves this way.
    fn follows(&self, index: usize, direction: Direction) -> bool {
        self.setpoints
            .get(index)
            .is_some_and(|setpoint| setpoint.moves() && !setpoint.recedes(direction == Direction::Rise))
    }

    /// Open for so short a time that it has not been seen yet.
    fn looked_at(&self, index: usize) -> bool {
        self.last.segments.get(index) == Some(&Passage::Open) && get(&self.valve_ticks, index) <= LOOK_TICKS
    }

    fn any_moving(&self) -> bool {
        self.setpoints.iter().any(Setpoint::moves)
    }

    /// From which error on a chamber is served.
    fn band(&self, index: usize, direction: Direction, view: &View) -> Pressure {
        self.setpoints.get(index).map_or(HOLD_BAND, |setpoint| {
            if setpoint.moves() {
                if setpoint.recedes(direction == Direction::Rise) { AGAINST_BAND } else { MOVING_BAND }
            } else if setpoint.value == Pressure::ZERO {
                EMPTY
            } else if (view.ahead.manifold - get(&view.ahead.chambers, index)).abs() > FAR {
                FAR_BAND
            } else {
                HOLD_BAND + self.hunting.get(index).map_or(Pressure::ZERO, |hunting| hunting.widens())
            }
        })
    }

    /// How far beyond its setpoint a chamber is taken.
    fn beyond(&self, index: usize, direction: Direction, view: &View) -> Pressure {
        if self.setpoints.get(index).is_some_and(Setpoint::moves) {
            return MOVING_LEAD;
        }
        let sag = direction.signed(get(&view.ahead.sags, index));
        sag.midpoint(Pressure::ZERO).clamp(Pressure::ZERO, SAG_MOST)
    }

    fn set_moves(&self, index: usize) -> bool {
        self.setpoints.get(index).is_some_and(Setpoint::moves)
    }

    fn look_due(&self, index: usize, view: &View) -> bool {
        let after = LOOK_AGAIN.get(usize::from(get(&self.looks, index))).or(LOOK_AGAIN.last());
        let full = get(&view.ahead.chambers, index) > milli_kpa(2000);
        let holds = self.setpoints.get(index).is_some_and(|setpoint| setpoint.value > Pressure::ZERO);
        let closed = self.last.segments.get(index) == Some(&Passage::Closed);
        full && holds && closed && after.is_some_and(|&ticks| get(&self.unseen, index) > ticks)
    }
}

fn member(group: Group, index: usize) -> bool {
    get(&group, index)
}

fn set(group: &mut Group, index: usize, is: bool) {
    if let Some(chosen) = group.get_mut(index) {
        *chosen = is;
    }
}

fn set_open(actuation: &mut Actuation, index: usize) {
    if let Some(passage) = actuation.segments.get_mut(index) {
        *passage = Passage::Open;
    }
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
        let actuation = against(0, kpa([60, 0, 60]), 12);
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
        assert_eq!(against(0, kpa([1000, 0, 0]), 12), against(0, kpa([150, 0, 0]), 12));
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
