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

/// A chamber's volume in 16ths of the manifold's, as nominal.
const CHAMBER_16THS: i32 = Nominal::NOMINAL.chamber_ratios[0].to_bits() >> 12;
/// A movement that must have been at least so large, everywhere that is open, is compared with what was seen ...
const EXPECTED: Pressure = Pressure::from_kpa(5);
/// ... or of this size when the reading stands still: the true pressure may move six times as fast.
const EXPECTED_STILL: Pressure = Pressure::from_milli_kpa(1500);

/// Lost between two looks at a chamber or within [`SAMPLE`] ticks, while nothing let it out.
const BURST: Pressure = Pressure::from_kpa(10);
/// The same, with a little forgiven each time ...
const SLOW: Pressure = Pressure::from_kpa(8);
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

/// Air in the manifold and in each open chamber, in kPa of the manifold alone, 2^-16.
type Air = [i32; 4];

/// Windows in a row in which too little moved.
const SHORT_WINDOWS: u8 = 3;

/// Air that must come or go, and what has.
#[derive(Clone, Copy, Debug)]
struct Expectation {
    expected: i32,
    /// None until what is open has been the same for a tick.
    from: Option<Air>,
    short: u8,
}

impl Expectation {
    const NONE: Self = Self { expected: 0, from: None, short: 0 };

    /// Adds what one more tick must add (or take away, `sign` -1) at least; starts a new window when that is enough to judge
    /// by. True when too little moved, [`SHORT_WINDOWS`] times in a row unless the reading stands still.
    fn falls_short(&mut self, sign: i32, at_least: i32, enough: i32, air: Air, still: bool) -> bool {
        let from = *self.from.get_or_insert(air);
        self.expected = self.expected.saturating_add(at_least);
        if self.expected < enough {
            return false;
        }
        let (mut moved, mut gross) = (0_i32, 0_i32);
        for (now, then) in air.into_iter().zip(from) {
            let change = now.saturating_sub(then);
            moved = moved.saturating_add(change.saturating_mul(sign));
            gross = gross.saturating_add(change.saturating_abs());
        }
        // What passes from one volume to another is counted wrongly by as much as their sizes are: by half at the most. And
        // chambers of twice the volume take twice the air that is counted for them; as much again for the estimates.
        let margin = if still { 0 } else { gross / 2 };
        let short = moved.saturating_add(margin) < self.expected / 4;
        self.short = if short { self.short.saturating_add(1) } else { 0 };
        (self.expected, self.from) = (0, Some(air));
        self.short >= if still { 1 } else { SHORT_WINDOWS }
    }
}

/// Half of the nominal flow, kPa of the manifold alone per tick in 2^-16, for each kPa below the pressure at which the
/// weakest pump counts as stalled.
const PER_ROOM: i32 = Nominal::NOMINAL.pump_rate.to_bits() / 2 / 200;
/// A valve lets out at least 0.0085 kPa/ms of the manifold alone for each kPa (ISO 6358, between 10 and 150 kPa);
/// 0.7 of that, in 2^-16.
const PER_KPA: i32 = 65_536 * 595 / 100_000;

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
    /// The reading stood still in the last tick.
    stood_still: bool,
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
            rise: Expectation::NONE,
            fall: Expectation::NONE,
            stood_still: false,
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
        self.remember(*look.commanded);
        if look.stands_still != self.stood_still {
            self.stood_still = look.stands_still;
            self.rise = Expectation::NONE;
            self.fall = Expectation::NONE;
        }
        self.nothing_rises_without_the_pump(look)
            .or_else(|| self.the_manifold_alone_keeps_its_air(look))
            .or_else(|| self.the_pump_delivers(look))
            .or_else(|| self.the_dump_lets_out(look))
            .or_else(|| self.chambers_keep_their_air(look))
    }

    fn remember(&mut self, commanded: Actuation) {
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

    /// The air of this moment, by the reading and the estimates: what passes between them does not change its sum. While the
    /// reading stands still it alone counts, for all: the estimates move by what was commanded.
    fn air(&self, look: &Look) -> Air {
        if look.stands_still {
            return [(look.manifold.to_bits() / 16).saturating_mul(self.volume_16ths()), 0, 0, 0];
        }
        let mut air = [look.manifold.to_bits(), 0, 0, 0];
        let chambers = self.valves.iter().zip(look.chambers);
        for ((valve, chamber), own) in chambers.zip(air.iter_mut().skip(1)) {
            if !valve.off_for(OBEYED) {
                *own = (chamber.to_bits() / 16).saturating_mul(CHAMBER_16THS);
            }
        }
        air
    }

    /// Volume of manifold and open chambers, in 16ths of the manifold's.
    fn volume_16ths(&self) -> i32 {
        self.open().saturating_mul(CHAMBER_16THS).saturating_add(16)
    }

    /// How much air must have been expected to move before what moved is judged, 2^-16.
    fn enough(&self, look: &Look) -> i32 {
        let enough = if look.stands_still { EXPECTED_STILL } else { EXPECTED };
        (enough.to_bits() / 16).saturating_mul(self.volume_16ths())
    }

    fn the_pump_delivers(&mut self, look: &Look) -> Option<Fault> {
        if !(self.pump.on_for(OBEYED) && self.dump.off_for(OBEYED) && self.valves_unchanged()) {
            self.rise = Expectation::NONE;
            return None;
        }
        let room = (200 - (look.manifold.to_bits() >> 16)).clamp(0, 200);
        let enough = self.enough(look);
        let (air, still) = (self.air(look), look.stands_still);
        let short = self.rise.falls_short(1, room * PER_ROOM, enough, air, still);
        short.then_some(if still { Fault::PressureSensorStuck } else { Fault::PumpNotDelivering })
    }

    fn the_dump_lets_out(&mut self, look: &Look) -> Option<Fault> {
        let enough_left = look.manifold > const { Pressure::from_kpa(10) };
        if !(self.dump.on_for(OBEYED) && self.pump.off_for(STOPPED) && self.valves_unchanged() && enough_left) {
            self.fall = Expectation::NONE;
            return None;
        }
        let at_least = (look.manifold.to_bits() >> 16).clamp(0, 200) * PER_KPA;
        let enough = self.enough(look);
        let (air, still) = (self.air(look), look.stands_still);
        let short = self.fall.falls_short(-1, at_least, enough, air, still);
        short.then_some(if still { Fault::PressureSensorStuck } else { Fault::DumpStuckClosed })
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
            let mut seen = chambers;
            for (chamber, passage) in seen.iter_mut().zip(commanded.segments) {
                if passage == Passage::Open {
                    *chamber = manifold;
                }
            }
            let look =
                Look { manifold, chambers: &seen, setpoints: &chambers, commanded: &commanded, stands_still: still };
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
        assert!(tick < 1000, "{tick}");
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
