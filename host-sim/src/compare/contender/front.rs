//! What every peer needs to regulate three chambers through one manifold and one sensor, so that only their laws differ.
//!
//! It is built as generously as could be thought of: the core's observer tells the pressures of closed chambers; all chambers that
//! want the same direction share the manifold, each one's valve open only while air flows its way; the pump (or the dump
//! valve) keeps the manifold a tuned amount beyond the chambers, more when they are far from their references; when
//! nobody wants anything, chambers are looked at with the manifold brought to their estimate first. Its constants are tuned
//! together with each law's.

use super::guard::Guard;
use model_core::actuation::{Actuation, Passage, PerSegment};
use model_core::observer::{Observer, Pneumatics};
use model_core::regulator::MANIFOLD_CEILING;
use model_core::units::Pressure;

/// Figures of the front, tuned with each law.
#[derive(Clone, Copy, Debug)]
pub struct FrontGains {
    /// The manifold is kept so far beyond the chamber at least, kPa.
    pub supply_floor_kpa: f64,
    /// And so much further for each kPa of error.
    pub supply_per_error: f64,
    /// The pump (or the dump valve) starts when so much of that is missing, kPa.
    pub supply_hysteresis_kpa: f64,
    /// A direction is kept for so long while the other one is wanted too, ms.
    pub slot_ms: f64,
    /// A chamber's pressure is taken as what it will be in so long, ms.
    pub lead_ms: f64,
    /// Before a look the manifold is brought within this of the estimate, kPa.
    pub match_kpa: f64,
    /// A chamber that was not seen for so long is looked at, ms.
    pub look_ms: f64,
    /// A look lasts at least so long, ms.
    pub settle_ms: f64,
}

/// What a law wants of one chamber this tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wish {
    /// 1 to raise it, -1 to lower it, 0 for nothing.
    pub direction: i8,
    /// Whether its valve shall be open now, if air flows its way.
    pub open: bool,
}

/// What a law sees.
#[derive(Clone, Copy, Debug, Default)]
pub struct View {
    /// References, kPa.
    pub references_kpa: [f64; 3],
    /// Their change a millisecond, kPa; 0 when they jump.
    pub reference_rates: [f64; 3],
    /// Estimated pressures, kPa.
    pub chambers_kpa: [f64; 3],
    /// Estimated pressures after the lead, kPa.
    pub ahead_kpa: [f64; 3],
    /// Rates at which an open valve would change each chamber now, kPa/ms, never negative.
    pub open_rates: [f64; 3],
    /// Which chambers' valves were commanded open in the last tick by a wish.
    pub served: [bool; 3],
}

/// Looking at a chamber.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Look {
    /// At none.
    Not,
    /// The manifold is being brought to this chamber's estimate.
    Matching(usize),
    /// Its valve, and those of its equals, are open for so many ticks.
    Open([bool; 3], u32),
}

/// References that change faster have jumped, kPa/ms.
const JUMP_KPA: f64 = 1.0;
/// Chambers whose estimates differ by no more than this are looked at together, kPa.
const EQUAL_KPA: f64 = 1.0;
/// Below it a chamber that shall be empty is not looked at, kPa.
const EMPTY_KPA: f64 = 1.5;
/// Attempts to match within so many ticks; then the look takes what it has.
const MATCH_TICKS: u32 = 400;

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Front {
    gains: FrontGains,
    observer: Observer,
    guard: Guard,
    references_kpa: Option<[f64; 3]>,
    /// Direction that is served, and for how long.
    direction: i8,
    slot_ticks: u32,
    /// Wishes of the last tick that were granted.
    served: [bool; 3],
    supplying: bool,
    look: Look,
    match_ticks: u32,
    unseen_ticks: [u32; 3],
    /// Moved since last seen at rest.
    moved: [bool; 3],
}

impl Front {
    /// Vented.
    #[must_use]
    pub fn new(gains: FrontGains) -> Self {
        Self {
            gains,
            observer: Observer::new(Pneumatics::NOMINAL),
            guard: Guard::new(),
            references_kpa: None,
            direction: 0,
            slot_ticks: 0,
            served: [false; 3],
            supplying: false,
            look: Look::Not,
            match_ticks: 0,
            unseen_ticks: [0; 3],
            moved: [false; 3],
        }
    }

    /// The observer starts anew from what the self test has measured.
    pub fn know(&mut self, pneumatics: Pneumatics) {
        self.observer = Observer::new(pneumatics);
    }

    /// Estimates, kPa.
    #[must_use]
    pub fn estimates_kpa(&self) -> [f64; 3] {
        self.observer.chambers().map(Pressure::to_f64)
    }

    /// Takes references and the reading; tells what the law may know.
    pub fn observe(&mut self, references: PerSegment<Pressure>, manifold: Pressure) -> View {
        self.observer.measure(manifold);
        let references_kpa = references.map(Pressure::to_f64);
        let before = self.references_kpa.unwrap_or(references_kpa);
        self.references_kpa = Some(references_kpa);
        let chambers_kpa = self.estimates_kpa();
        let flows = self.observer.flows().map(|flow| flow.to_num::<f64>());
        let model = self.observer.pneumatics();
        let chambers = self.observer.chambers();
        let open_rate = |i: usize| {
            let flow = model.valve_flow(model.valve_rates[i], self.observer.manifold(), chambers[i]);
            (flow / model.chamber_ratios[i]).to_num::<f64>().abs()
        };
        View {
            references_kpa,
            reference_rates: core::array::from_fn(|i| {
                let rate = references_kpa[i] - before[i];
                if rate.abs() > JUMP_KPA { 0.0 } else { rate }
            }),
            chambers_kpa,
            ahead_kpa: core::array::from_fn(|i| chambers_kpa[i] + flows[i] * self.gains.lead_ms),
            open_rates: core::array::from_fn(open_rate),
            served: self.served,
        }
    }

    /// Grants the wishes as far as one manifold can.
    pub fn act(&mut self, view: &View, wishes: [Wish; 3]) -> Actuation {
        let actuation = if view.references_kpa.iter().all(|&kpa| kpa <= 0.0) {
            // As every regulator of this machine: without a setpoint it is de-energised.
            (self.look, self.direction, self.supplying) = (Look::Not, 0, false);
            (self.served, self.moved, self.unseen_ticks) = ([false; 3], [false; 3], [0; 3]);
            Actuation::SAFE
        } else {
            self.choose_direction(view, wishes);
            if self.direction == 0 { self.look(view) } else { self.serve(view, wishes) }
        };
        let rise = |pump_ticks: u32| {
            let flow = self.observer.pneumatics().pump_flow(self.observer.manifold());
            flow.to_num::<f64>() * f64::from(pump_ticks)
        };
        let coming_kpa = rise(self.observer.pump_ticks_pending());
        let full = self.observer.manifold().to_f64() + coming_kpa >= MANIFOLD_CEILING.to_f64();
        let actuation = self.guard.keep(actuation, full);
        self.observer.commanded(&actuation);
        actuation
    }

    /// Keeps a direction as long as it is wanted and its slot lasts; else takes that of the largest error.
    fn choose_direction(&mut self, view: &View, wishes: [Wish; 3]) {
        self.slot_ticks = self.slot_ticks.saturating_add(1);
        let wanted = |direction: i8| wishes.iter().any(|wish| wish.direction == direction);
        let keeps = self.direction != 0
            && wanted(self.direction)
            && (f64::from(self.slot_ticks) < self.gains.slot_ms || !wanted(-self.direction));
        if keeps {
            return;
        }
        let error = |i: usize| (view.references_kpa[i] - view.chambers_kpa[i]).abs();
        let next = if self.direction != 0 && wanted(-self.direction) {
            -self.direction
        } else {
            (0..3)
                .filter(|&i| wishes[i].direction != 0)
                .max_by(|&a, &b| error(a).total_cmp(&error(b)))
                .map_or(0, |i| wishes[i].direction)
        };
        if next != self.direction {
            (self.direction, self.slot_ticks, self.supplying) = (next, 0, false);
            self.served = [false; 3];
        }
    }

    /// The manifold's pressure once all that was commanded has flowed, with these valves open, kPa.
    fn manifold_ahead_kpa(&self, open: [bool; 3]) -> f64 {
        let model = self.observer.pneumatics();
        let manifold = self.observer.manifold();
        let pumped = model.pump_flow(manifold).to_num::<f64>() * f64::from(self.observer.pump_ticks_pending());
        let dumped = model.valve_flow(model.dump_rate, manifold, Pressure::ZERO).to_num::<f64>()
            * f64::from(self.observer.dump_ticks_pending());
        let opened = open.iter().zip(model.chamber_ratios).filter(|&(&open, _)| open);
        let volume = 1.0 + opened.map(|(_, ratio)| ratio.to_num::<f64>()).sum::<f64>();
        manifold.to_f64() + (pumped - dumped) / volume
    }

    /// Supplies the manifold beyond the chambers and opens those that want it.
    fn serve(&mut self, view: &View, wishes: [Wish; 3]) -> Actuation {
        self.look = Look::Not;
        let sign = f64::from(self.direction);
        let manifold_kpa = self.observer.manifold().to_f64();
        let wants = |i: usize| wishes[i].direction == self.direction;
        // With some room, so that the sensor's noise does not make the valves chatter.
        let flows = |i: usize| {
            let room_kpa = if self.served[i] { -1.0 } else { 0.0 };
            sign * (manifold_kpa - view.chambers_kpa[i]) >= room_kpa
        };
        let open: [bool; 3] = core::array::from_fn(|i| wants(i) && wishes[i].open && flows(i));
        let aim = |i: usize| {
            let error = (view.references_kpa[i] - view.chambers_kpa[i]).abs();
            let beyond = self.gains.supply_floor_kpa + self.gains.supply_per_error * error;
            sign * view.chambers_kpa[i] + beyond
        };
        let furthest = (0..3).filter(|&i| wants(i)).map(aim).fold(f64::NEG_INFINITY, f64::max);
        let limit = if self.direction > 0 { MANIFOLD_CEILING.to_f64() } else { 0.0 };
        let aim_kpa = furthest.min(sign * limit);
        let ahead_kpa = sign * self.manifold_ahead_kpa(open);
        let missing_kpa = aim_kpa - ahead_kpa;
        self.supplying = missing_kpa > if self.supplying { 0.0 } else { self.gains.supply_hysteresis_kpa };
        // A dump valve at the atmosphere can stay open; closing it gains nothing.
        let to_atmosphere = self.direction < 0 && aim_kpa >= 0.0;
        for ((moved, ticks), open) in self.moved.iter_mut().zip(&mut self.unseen_ticks).zip(open) {
            *moved |= open;
            *ticks = ticks.saturating_add(1);
        }
        self.served = open;
        Actuation {
            pump: self.direction > 0 && self.supplying,
            dump: if self.direction < 0 && (self.supplying || to_atmosphere) { Passage::Open } else { Passage::Closed },
            segments: passages(open),
        }
    }

    /// Nobody wants anything: look at those that are due, one after another, and stay with the last.
    fn look(&mut self, view: &View) -> Actuation {
        self.served = [false; 3];
        let holds = |i: usize| view.references_kpa[i] > 0.0 || view.chambers_kpa[i] > EMPTY_KPA;
        for ticks in &mut self.unseen_ticks {
            *ticks = ticks.saturating_add(1);
        }
        if let Look::Open(group, ticks) = self.look {
            self.look = Look::Open(group, ticks.saturating_add(1));
            if f64::from(ticks) < self.gains.settle_ms || !self.observer.air_rests() {
                return Actuation { segments: passages(group), ..Actuation::HOLD };
            }
            for i in (0..3).filter(|&i| group[i]) {
                (self.unseen_ticks[i], self.moved[i]) = (0, false);
            }
        }
        let due = |i: usize| holds(i) && (self.moved[i] || f64::from(self.unseen_ticks[i]) > self.gains.look_ms);
        let next = match self.look {
            Look::Matching(index) => Some(index),
            Look::Not => (0..3).find(|&i| due(i)),
            Look::Open(group, _) => {
                let next = (0..3).find(|&i| !group[i] && due(i));
                if next.is_none() {
                    return Actuation { segments: passages(group), ..Actuation::HOLD };
                }
                next
            }
        };
        let Some(index) = next else { return Actuation::HOLD };
        if self.look != Look::Matching(index) {
            (self.look, self.match_ticks) = (Look::Matching(index), 0);
        }
        self.bring_manifold_to(view, index, holds)
    }

    /// Pulses of pump and dump valve with all valves closed, until the manifold is at the chamber's estimate.
    fn bring_manifold_to(&mut self, view: &View, index: usize, holds: impl Fn(usize) -> bool) -> Actuation {
        self.match_ticks += 1;
        let level_kpa = view.chambers_kpa[index];
        let missing_kpa = level_kpa - self.manifold_ahead_kpa([false; 3]);
        let last = self.guard.last();
        if last.pump && missing_kpa > 0.0 {
            return Actuation { pump: true, ..Actuation::HOLD };
        }
        if last.dump == Passage::Open && missing_kpa < 0.0 && last.segments == [Passage::Closed; 3] {
            return Actuation { dump: Passage::Open, ..Actuation::HOLD };
        }
        if !self.observer.air_rests() {
            return Actuation::HOLD;
        }
        if missing_kpa.abs() <= self.gains.match_kpa || self.match_ticks > MATCH_TICKS {
            let equal = |i: usize| holds(i) && (view.chambers_kpa[i] - level_kpa).abs() <= EQUAL_KPA;
            let group = core::array::from_fn(|i| i == index || equal(i));
            self.look = Look::Open(group, 0);
            return Actuation { segments: passages(group), ..Actuation::HOLD };
        }
        Actuation {
            pump: missing_kpa > 0.0,
            dump: if missing_kpa < 0.0 { Passage::Open } else { Passage::Closed },
            ..Actuation::HOLD
        }
    }
}

fn passages(open: [bool; 3]) -> PerSegment<Passage> {
    open.map(|open| if open { Passage::Open } else { Passage::Closed })
}
