//! The outputs of each phase.

use super::*;

impl Regulator {
    /// Pump or dump, and the valves of those who want.
    pub(super) fn flow(&mut self, direction: Direction, view: &View) -> Actuation {
        let mut actuation = self.last;
        let manifold = view.ahead.manifold;
        // Air that is missing, and the level at which the manifold has to end for it to arrive.
        let (mut missing, mut end) = (I16F16::ZERO, Pressure::MIN);
        let mut starved = false;
        let furthest = (0..3)
            .filter(|&index| member(self.wants, index))
            .map(|index| direction.signed(get(&view.errors, index)) + self.beyond(index, direction, view))
            .max()
            .unwrap_or(Pressure::ZERO);
        let ending = furthest < milli_kpa(500);
        for index in 0..3 {
            let chamber = get(&view.ahead.chambers, index);
            let wants = member(self.wants, index);
            let above = direction.signed(manifold - chamber);
            let was_open = self.last.segments.get(index) == Some(&Passage::Open);
            let open = if wants {
                above > if was_open { Pressure::ZERO - BACKFLOW_BAND } else { milli_kpa(300) }
            } else {
                was_open && self.set_moves(index) && above.abs() < LEVEL_BAND
                    || was_open
                        && ending
                        && direction.signed(get(&view.errors, index)) > Pressure::ZERO - milli_kpa(1500)
                    || was_open && get(&self.valve_ticks, index) < VALVE_MIN_TICKS
            };
            if let Some(passage) = actuation.segments.get_mut(index) {
                *passage = if open { Passage::Open } else { Passage::Closed };
            }
            if wants {
                let error = direction.signed(get(&view.errors, index));
                let goal = error + self.beyond(index, direction, view);
                missing = missing.saturating_add(get(&view.volumes, index).saturating_mul(goal.to_fixed()));
                end = end.max(direction.signed(chamber) + goal);
                starved |= above < milli_kpa(1000);
            }
        }
        // All who are served follow one level.
        let together = (0..3).filter(|&index| member(self.wants, index)).all(|index| {
            let setpoint =
                direction.signed(get(&view.ahead.chambers, index)) + direction.signed(get(&view.errors, index));
            self.follows(index, direction) && (setpoint - end).abs() < milli_kpa(6000)
        });
        let short = missing.saturating_add((end - direction.signed(manifold)).to_fixed());
        let coming = if direction == Direction::Rise { view.ahead.coming.to_fixed() } else { I16F16::ZERO };
        let minimum = self.last.pump && self.pump_ticks < PUMP_MIN_TICKS;
        if together && short <= coming && !minimum {
            // The rest comes by itself, and through open valves.
            (self.phase, self.wants) = (Phase::Resting, NONE);
            return Actuation { segments: actuation.segments, ..Actuation::HOLD };
        }
        match direction {
            Direction::Rise => {
                let coming = view.ahead.coming.to_fixed();
                let more = short
                    > if self.last.pump || starved {
                        coming
                    } else {
                        coming.saturating_add(const { I16F16::lit("6") })
                    };
                let keeps = self.pump_ticks < PUMP_MIN_TICKS;
                let full = view.full();
                actuation.pump = if keeps { self.last.pump } else { more } && !full && self.wants != NONE;
                actuation.dump = Passage::Closed;
            }
            Direction::Fall => {
                actuation.pump = false;
                let more = short > I16F16::ZERO;
                let keeps = self.dump_ticks < VALVE_MIN_TICKS;
                let open = if keeps { self.last.dump == Passage::Open } else { more } && self.wants != NONE;
                actuation.dump = if open { Passage::Open } else { Passage::Closed };
            }
        }
        actuation
    }

    /// Valves stay open as long as their chambers will rest together where they should: then they go on being seen.
    pub(super) fn rest(&mut self, view: &View) -> Actuation {
        let mut actuation = Actuation { segments: self.last.segments, ..Actuation::HOLD };
        let manifold = view.ahead.manifold + view.ahead.coming;
        let opened = |index: usize| self.last.segments.get(index) == Some(&Passage::Open);
        let (mut air, mut volume) = (manifold.to_fixed(), I16F16::ONE);
        for index in (0..3).filter(|&index| opened(index)) {
            let own = get(&view.volumes, index);
            volume = volume.saturating_add(own);
            air = air.saturating_add(own.saturating_mul(get(&view.ahead.chambers, index).to_fixed()));
        }
        for index in (0..3).filter(|&index| opened(index)) {
            let chamber = get(&view.ahead.chambers, index);
            let setpoint = chamber + get(&view.errors, index);
            // The level less the setpoint, times the volume: nothing is divided.
            let excess = air.saturating_sub(volume.saturating_mul(setpoint.to_fixed())).saturating_abs();
            let band = if self.set_moves(index) { STAY_MOVING } else { STAY };
            let looking = get(&self.valve_ticks, index) < LOOK_TICKS && (manifold - chamber).abs() < milli_kpa(3500);
            if excess > volume.saturating_mul(band.to_fixed())
                && !looking
                && let Some(passage) = actuation.segments.get_mut(index)
            {
                *passage = Passage::Closed;
            }
        }
        actuation
    }

    /// Brings the manifold, alone, to a chamber's pressure, and opens it.
    pub(super) fn look(&mut self, index: usize, view: &View) -> Actuation {
        let mut actuation = Actuation::HOLD;
        let manifold = view.ahead.manifold;
        let chamber = get(&view.ahead.chambers, index);
        let off = manifold + view.ahead.coming - chamber;
        if off.abs() < LOOK_BAND && view.ahead.coming < milli_kpa(1000) {
            self.phase = Phase::Resting;
            for other in 0..3 {
                let near = (get(&view.ahead.chambers, other) - chamber).abs() < milli_kpa(1000);
                if other == index || near && self.look_due(other, view) {
                    set_open(&mut actuation, other);
                }
            }
            return actuation;
        }
        if off > Pressure::ZERO {
            let keeps = self.last.dump == Passage::Open && self.dump_ticks < VALVE_MIN_TICKS;
            if keeps || off > milli_kpa(1000) {
                actuation.dump = Passage::Open;
            }
        } else {
            let keeps = self.last.pump && self.pump_ticks < PUMP_MIN_TICKS;
            actuation.pump = (keeps || off < Pressure::ZERO - milli_kpa(1000)) && !view.full();
        }
        actuation
    }
}
