//! What was commanded against what the manifold's pressure did: pump, dump, valves, leaks.
//!
//! Each rule holds whatever the plant's figures are within wide bounds: pump flow half to 1.3 times the nominal, chambers
//! up to twice as large, valves with 0.7 of their conductance, dead times up to twice as long. So each waits until a
//! command has *certainly* been obeyed, and asks for less than the slowest plant gives.

use super::fault::Fault;
use super::held::{Held, lasts};
use crate::actuation::{Actuation, Passage, PerSegment};
use crate::observer::Pneumatics as Nominal;
use crate::units::Pressure;

/// Valves and dump have obeyed after so many ticks: twice the nominal dead time, the sensor's lag, the reading's filter.
const OBEYED: u16 = 32;
/// The pump has stopped: twice the dead time, its run-down, the sensor's lag.
const STOPPED: u16 = 120;
/// Everything open for so long is empty: chambers at 150 kPa vent in 1.6 s, the slowest in 4 s.
const EMPTY_AFTER: u16 = 5000;

/// Without the pump nothing rises above the highest pressure that there was, but for errors of the estimates and the
/// gas's warming.
const RISE: Pressure = Pressure::from_kpa(10);
/// The same for the manifold alone, whose own reading is the base.
const RISE_ALONE: Pressure = Pressure::from_kpa(8);
/// The manifold alone holds its air, but for its cooling.
const FALL_ALONE: Pressure = Pressure::from_kpa(8);
/// For so many ticks each.
const TICKS: u8 = 6;
/// What is still there when the finger must have been empty for long: pump or dump do not obey.
const NOT_EMPTY: Pressure = Pressure::from_kpa(4);

/// A movement that must have been at least so large is compared with what was seen ...
const EXPECTED: Pressure = Pressure::from_kpa(5);
/// ... or of this size when the reading stands still: the true pressure may move six times as fast.
const EXPECTED_STILL: Pressure = Pressure::from_milli_kpa(1500);

/// Lost between two looks at a chamber or within [`SAMPLE`] ticks, while nothing let it out.
const BURST: Pressure = Pressure::from_kpa(10);
/// The same, with a little forgiven each time ...
const SLOW: Pressure = Pressure::from_kpa(6);
/// ... which a chamber that settles after a flow, or is disturbed by a neighbour, loses too.
const FORGIVEN: Pressure = Pressure::from_milli_kpa(12);
/// Less than this is the estimate's noise.
const STEP: Pressure = Pressure::from_milli_kpa(300);
/// No single loss counts for more: the first look after a flow may find that the estimate was 13 kPa too high.
const AT_ONCE: Pressure = Pressure::from_milli_kpa(700);
/// But so much is no error of an estimate.
const GONE: Pressure = Pressure::from_kpa(25);
/// Ticks between two samples of the chambers' estimates.
const SAMPLE: u16 = 32;
/// Setpoints must have rested for so long: bends settle after the pressure does, and the chamber grows with them.
const SETTLED: u16 = 1000;
/// A chamber so far below its setpoint ...
const SHORT_OF: Pressure = Pressure::from_kpa(10);
/// ... for so long after its setpoint moved last is not filled: three chambers to 150 kPa take 6.5 s on the slowest plant.
const SHORT_TICKS: u16 = 12_000;

/// A movement that must come, and what has come.
#[derive(Clone, Copy, Debug, Default)]
struct Expectation {
    expected: i32,
    from: Pressure,
}

impl Expectation {
    /// Starts over.
    const fn restart(&mut self, manifold: Pressure) {
        (self.expected, self.from) = (0, manifold);
    }

    /// Adds what one more tick must bring at least; true when enough was expected and too little came.
    const fn falls_short(&mut self, at_least: i32, enough: Pressure, moved: i32) -> bool {
        self.expected = self.expected.saturating_add(at_least);
        self.expected >= enough.to_bits() && moved < self.expected / 4
    }
}

/// What the rules look at in a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look<'a> {
    /// The manifold's pressure, filtered over 4 ms.
    pub manifold: Pressure,
    /// Estimates.
    pub chambers: &'a PerSegment<Pressure>,
    pub setpoints: &'a PerSegment<Pressure>,
    /// The last tick's.
    pub commanded: &'a Actuation,
    /// The reading has less noise than a sound sensor's.
    pub stands_still: bool,
}

/// See the module's page.
#[derive(Clone, Debug)]
pub(super) struct Pneumatics {
    pump: Held,
    dump: Held,
    valves: PerSegment<Held>,
    /// Nothing can rise above it until the pump runs again.
    ceiling: Pressure,
    /// Lowest and highest of the manifold alone.
    lowest: Pressure,
    highest: Pressure,
    above: u8,
    above_alone: u8,
    below_alone: u8,
    rise: Expectation,
    fall: Expectation,
    setpoints: PerSegment<Pressure>,
    /// Ticks since a setpoint moved.
    still: u16,
    until_sample: u16,
    /// Since the last sample the chamber may have been let out.
    dumped: PerSegment<bool>,
    before: PerSegment<Pressure>,
    lost: PerSegment<Pressure>,
}

impl Pneumatics {
    pub(super) const fn new() -> Self {
        Self {
            pump: Held::new(false),
            dump: Held::new(true),
            valves: [Held::new(true); 3],
            ceiling: Pressure::MAX,
            lowest: Pressure::MAX,
            highest: Pressure::MIN,
            above: 0,
            above_alone: 0,
            below_alone: 0,
            rise: Expectation { expected: 0, from: Pressure::ZERO },
            fall: Expectation { expected: 0, from: Pressure::ZERO },
            setpoints: [Pressure::ZERO; 3],
            still: 0,
            until_sample: SAMPLE,
            dumped: [true; 3],
            before: [Pressure::ZERO; 3],
            lost: [Pressure::ZERO; 3],
        }
    }

    /// One tick; the fault that shows.
    pub(super) fn watch(&mut self, look: &Look) -> Option<Fault> {
        self.remember(look.commanded);
        self.nothing_rises_without_the_pump(look)
            .or_else(|| self.the_manifold_alone_keeps_its_air(look))
            .or_else(|| self.the_pump_delivers(look))
            .or_else(|| self.the_dump_lets_out(look))
            .or_else(|| self.chambers_keep_their_air(look))
    }

    fn remember(&mut self, commanded: &Actuation) {
        self.pump.push(commanded.pump);
        self.dump.push(commanded.dump == Passage::Open);
        for (held, passage) in self.valves.iter_mut().zip(commanded.segments) {
            held.push(passage == Passage::Open);
        }
        let dump = !self.dump.off_for(OBEYED);
        for (dumped, valve) in self.dumped.iter_mut().zip(self.valves) {
            *dumped |= dump && !valve.off_for(OBEYED);
        }
    }

    fn alone(&self) -> bool {
        self.valves.iter().all(|valve| valve.off_for(OBEYED))
    }

    fn valves_unchanged(&self) -> bool {
        self.valves.iter().all(|valve| valve.unchanged_for(OBEYED))
    }

    /// How many chambers share the manifold's air at the most.
    fn open(&self) -> i32 {
        self.valves.iter().map(|valve| i32::from(!valve.off_for(OBEYED))).sum()
    }

    fn nothing_rises_without_the_pump(&mut self, look: &Look) -> Option<Fault> {
        if !self.pump.off_for(STOPPED) {
            (self.ceiling, self.lowest) = (Pressure::MAX, Pressure::MAX);
            (self.above, self.above_alone) = (0, 0);
            return None;
        }
        if self.ceiling == Pressure::MAX {
            self.ceiling = look.chambers.iter().copied().fold(look.manifold, Pressure::max);
        } else if self.dump.on_for(EMPTY_AFTER) && self.valves.iter().all(|valve| valve.on_for(EMPTY_AFTER)) {
            self.ceiling = self.ceiling.min(NOT_EMPTY);
        }
        self.lowest = if self.alone() { self.lowest.min(look.manifold) } else { Pressure::MAX };
        let above = lasts(&mut self.above, look.manifold > self.ceiling + RISE, TICKS);
        let alone = lasts(&mut self.above_alone, look.manifold > self.lowest + RISE_ALONE, TICKS);
        (above || alone).then_some(Fault::PumpStuckOn)
    }

    fn the_manifold_alone_keeps_its_air(&mut self, look: &Look) -> Option<Fault> {
        if !(self.alone() && self.dump.off_for(OBEYED)) {
            (self.highest, self.below_alone) = (Pressure::MIN, 0);
            return None;
        }
        self.highest = self.highest.max(look.manifold);
        let margin = FALL_ALONE + Pressure::from_bits(self.highest.to_bits() >> 4);
        lasts(&mut self.below_alone, look.manifold < self.highest - margin, TICKS).then_some(Fault::DumpStuckOpen)
    }

    fn the_pump_delivers(&mut self, look: &Look) -> Option<Fault> {
        if !(self.pump.on_for(OBEYED) && self.dump.off_for(OBEYED) && self.valves_unchanged()) {
            self.rise.restart(look.manifold);
            return None;
        }
        /// Half of the nominal flow into one, two, three and four volumes of the largest chambers (twice the nominal), kPa
        /// per tick in 2^-16 for each kPa below the pressure at which the weakest pump counts as stalled.
        const PER_ROOM: [i32; 4] = {
            let mut per_room = [0; 4];
            let (mut open, volume) = (0, 2 * Nominal::NOMINAL.chamber_ratio.to_bits() as i64);
            while open < 4 {
                let rate = Nominal::NOMINAL.pump_rate.to_bits() as i64 * 65_536 / 2;
                per_room[open] = (rate / (65_536 + open as i64 * volume) / 200) as i32;
                open += 1;
            }
            per_room
        };
        let room = (200 - (look.manifold.to_bits() >> 16)).clamp(0, 200);
        let at_least = room * at(PER_ROOM, self.open());
        let moved = (look.manifold - self.rise.from).to_bits();
        let enough = if look.stands_still { EXPECTED_STILL } else { EXPECTED };
        let short = self.rise.falls_short(at_least, enough, moved);
        if self.rise.expected >= EXPECTED.to_bits() {
            self.rise.restart(look.manifold);
        }
        short.then_some(if look.stands_still { Fault::PressureSensorStuck } else { Fault::PumpNotDelivering })
    }

    fn the_dump_lets_out(&mut self, look: &Look) -> Option<Fault> {
        let enough_left = look.manifold > const { Pressure::from_kpa(10) };
        if !(self.dump.on_for(OBEYED) && self.pump.off_for(STOPPED) && self.valves_unchanged() && enough_left) {
            self.fall.restart(look.manifold);
            return None;
        }
        /// A valve lets out at least 0.0085 kPa/ms of the manifold alone for each kPa (ISO 6358, between 10 and 150 kPa);
        /// 0.7 of that, from the same volumes as above, in 2^-16.
        const PER_KPA: [i32; 4] = {
            let mut per_kpa = [0; 4];
            let (mut open, volume) = (0, 2 * Nominal::NOMINAL.chamber_ratio.to_bits() as i64);
            while open < 4 {
                per_kpa[open] = (65_536 * 65_536 * 595 / 100_000 / (65_536 + open as i64 * volume)) as i32;
                open += 1;
            }
            per_kpa
        };
        let at_least = (look.manifold.to_bits() >> 16).clamp(0, 200) * at(PER_KPA, self.open());
        let moved = (self.fall.from - look.manifold).to_bits();
        let enough = if look.stands_still { EXPECTED_STILL } else { EXPECTED };
        let short = self.fall.falls_short(at_least, enough, moved);
        if self.fall.expected >= EXPECTED.to_bits() {
            self.fall.restart(look.manifold);
        }
        short.then_some(if look.stands_still { Fault::PressureSensorStuck } else { Fault::DumpStuckClosed })
    }

    fn chambers_keep_their_air(&mut self, look: &Look) -> Option<Fault> {
        if *look.setpoints != self.setpoints {
            if self.still > 0 {
                // The next looks find the errors of new flows: what was lost before counts half.
                self.lost = self.lost.map(|lost| Pressure::from_bits(lost.to_bits() / 2));
            }
            (self.setpoints, self.still) = (*look.setpoints, 0);
            return None;
        }
        self.still = self.still.saturating_add(1);
        self.until_sample = self.until_sample.saturating_sub(1);
        if self.until_sample > 0 {
            return None;
        }
        self.until_sample = SAMPLE;
        let settled = self.still > SETTLED;
        let dumped = core::mem::take(&mut self.dumped);
        let mut found = None;
        let chambers = look.chambers.iter().zip(look.setpoints);
        let memory = self.before.iter_mut().zip(&mut self.lost).zip(dumped);
        for ((&chamber, &setpoint), ((before, lost), dumped)) in chambers.zip(memory) {
            // What lies above the setpoint is let out on purpose.
            let kept = chamber.min(setpoint);
            let step = *before - kept;
            let gone = if step > STEP { step } else { Pressure::ZERO };
            // Top-ups in between do not hide what was lost: it counts from the highest since the last loss.
            *before = if step > STEP { kept } else { kept.max(*before) };
            if setpoint == Pressure::ZERO {
                continue;
            }
            if settled && !dumped {
                *lost = (*lost - FORGIVEN).max(Pressure::ZERO) + gone.min(AT_ONCE);
            }
            let burst = settled && !dumped && gone > GONE;
            if burst || *lost > BURST {
                found = Some(Fault::LeakBurst);
            } else if *lost > SLOW {
                found = found.or(Some(Fault::LeakSlow));
            }
            if self.still > SHORT_TICKS && kept + SHORT_OF < setpoint {
                found = Some(Fault::PumpNotDelivering);
            }
        }
        found
    }
}

/// The table's value for so many open chambers.
fn at(table: [i32; 4], open: i32) -> i32 {
    let [none, one, two, three] = table;
    match open {
        0 => none,
        1 => one,
        2 => two,
        _ => three,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KPA: fn(i16) -> Pressure = Pressure::from_kpa;

    /// What a run of ticks finds, each given as manifold (kPa) and command; chambers and setpoints stay.
    fn found(
        chambers: PerSegment<Pressure>,
        still: bool,
        ticks: impl IntoIterator<Item = (f64, Actuation)>,
    ) -> Option<(usize, Fault)> {
        let mut pneumatics = Pneumatics::new();
        ticks.into_iter().enumerate().find_map(|(tick, (manifold, commanded))| {
            let manifold = Pressure::from_f64_kpa(manifold);
            let look = Look {
                manifold,
                chambers: &chambers,
                setpoints: &chambers,
                commanded: &commanded,
                stands_still: still,
            };
            pneumatics.watch(&look).map(|fault| (tick, fault))
        })
    }

    const PUMP: Actuation = Actuation { pump: true, ..Actuation::HOLD };
    const HELD: PerSegment<Pressure> = [Pressure::from_kpa(60); 3];

    #[test]
    fn a_pump_that_runs_on_is_found_by_the_rise() {
        let rising = (0..400).map(|tick| (20.0 + f64::from(tick) * 0.3, Actuation::HOLD));
        let (tick, fault) = found(HELD, false, rising).expect("found");
        assert_eq!(fault, Fault::PumpStuckOn);
        assert!(tick < 200, "{tick}");
        assert_eq!(found(HELD, false, (0..5000).map(|_| (60.0, Actuation::HOLD))), None);
    }

    #[test]
    fn a_pump_that_gives_nothing_and_a_reading_that_stands_still_are_told_apart() {
        let flat = || (0..400).map(|_| (20.0, PUMP));
        assert_eq!(found(HELD, false, flat()).map(|(_, fault)| fault), Some(Fault::PumpNotDelivering));
        let (tick, fault) = found(HELD, true, flat()).expect("found");
        assert_eq!(fault, Fault::PressureSensorStuck);
        assert!(tick < 60, "{tick}");
        // The slowest pump that must be borne, on the manifold alone: half of 1 kPa/ms.
        assert_eq!(found(HELD, false, (0..150).map(|tick| (f64::from(tick) * 0.5, PUMP))), None);
    }

    #[test]
    fn a_dump_that_stays_open_or_closed_is_found() {
        let falling = (0..200).map(|tick| (60.0 - f64::from(tick) * 0.5, Actuation::HOLD));
        assert_eq!(found(HELD, false, falling).map(|(_, fault)| fault), Some(Fault::DumpStuckOpen));
        let kept = (0..2000).map(|_| (60.0, Actuation::SAFE));
        let (tick, fault) = found(HELD, false, kept).expect("found");
        assert_eq!(fault, Fault::DumpStuckClosed);
        assert!(tick < 600, "{tick}");
        let venting = (0..4000).map(|tick| (150.0 * (-f64::from(tick) / 1200.0).exp(), Actuation::SAFE));
        assert_eq!(found(HELD, false, venting), None);
    }

    #[test]
    fn a_chamber_that_loses_air_is_found_and_one_that_settles_is_not() {
        let open = Actuation { segments: [Passage::Open, Passage::Closed, Passage::Closed], ..Actuation::HOLD };
        let run = |pressure: fn(u32) -> f64| {
            let mut pneumatics = Pneumatics::new();
            let setpoints = [KPA(60), Pressure::ZERO, Pressure::ZERO];
            (0..20_000_u32).find_map(|tick| {
                let chambers = [Pressure::from_f64_kpa(pressure(tick)), Pressure::ZERO, Pressure::ZERO];
                let look = Look {
                    manifold: KPA(60),
                    chambers: &chambers,
                    setpoints: &setpoints,
                    commanded: &open,
                    stands_still: false,
                };
                pneumatics.watch(&look)
            })
        };
        // Topped up every second.
        assert_eq!(run(|tick| 60.0 - f64::from(tick % 1000) * 0.002), Some(Fault::LeakSlow));
        assert_eq!(run(|tick| 60.0 - 5.0 * (1.0 - (-f64::from(tick) / 300.0).exp())), None);
        assert_eq!(run(|tick| if tick < 3000 { 60.0 } else { 20.0 }), Some(Fault::LeakBurst));
        assert_eq!(run(|_| 30.0), Some(Fault::PumpNotDelivering));
    }
}
