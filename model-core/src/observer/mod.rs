//! Pressure of each chamber from the one sensor on the manifold.
//!
//! A model of pump, valves, air and growing chambers runs *ahead* of the machine by the dead time: there a command acts in
//! the tick in which it is given, so that whoever decides by it needs no forecast. What the sensor reads is compared with
//! what the model said of this moment a dead time ago; a share of the difference is taken as an error of the model's whole
//! course since then. While a valve is closed its chamber's estimate moves only with the chamber's growth. All volumes are
//! counted in manifold volumes, so that a pressure rate of the manifold alone (kPa per millisecond) is the only unit of
//! flow.

mod pneumatics;

pub use pneumatics::DeadTicks;
pub use pneumatics::Pneumatics;

use crate::actuation::{Actuation, Passage, PerSegment};
use crate::division::divide;
use crate::units::Pressure;
use fixed::types::I16F16;
pub(crate) use pneumatics::ATMOSPHERE;

/// The model's pressures at one moment, less what had been corrected until it was reached: wrapping bits, because only
/// differences count.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    sensor: i32,
    chambers: PerSegment<i32>,
}

/// What the model says of the moment at which a command given now acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ahead {
    /// Gauge pressure of the manifold.
    pub manifold: Pressure,
    /// Gauge pressure of each chamber.
    pub chambers: PerSegment<Pressure>,
    /// How far each chamber's pressure would still fall, closed, as it grows; negative when it shrinks.
    pub sags: PerSegment<Pressure>,
    /// What the pump, stopped now, would still deliver: pressure of the manifold alone.
    pub coming: Pressure,
}

/// What the model and its correction moved in a tick. Amounts of air are given as pressure of the manifold alone, kPa.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Air {
    /// What the last reading's correction added to manifold and open chambers; negative when it took away.
    pub corrected: I16F16,
    /// What pump and dump moved, by the model; each counts positive.
    pub moved: I16F16,
    /// What the model, uncorrected, lets the reading of this moment move.
    pub expected: Pressure,
    /// What the reading was corrected by.
    pub surprise: Pressure,
}

impl Air {
    /// Nothing moves.
    pub const STILL: Self =
        Self { corrected: I16F16::ZERO, moved: I16F16::ZERO, expected: Pressure::ZERO, surprise: Pressure::ZERO };
}

/// See the module's page.
#[derive(Clone, Debug)]
pub struct Observer {
    pneumatics: Pneumatics,
    /// The model, a dead time ahead.
    ahead_manifold: Pressure,
    ahead_chambers: PerSegment<Pressure>,
    sags: PerSegment<Pressure>,
    /// In manifold volumes, and one over it.
    volumes: PerSegment<I16F16>,
    shares: PerSegment<I16F16>,
    /// 0..=1.
    pump_speed: I16F16,
    sensor: Pressure,
    /// The sum of all corrections.
    shift: Course,
    /// The model's course, the newest at `newest`.
    courses: [Course; COURSES],
    newest: usize,
    /// Whose volume is next.
    turn: usize,
    /// Of this moment.
    manifold: Pressure,
    chambers: PerSegment<Pressure>,
    flows: PerSegment<I16F16>,
    innovation: Pressure,
    air: Air,
    /// The course's sensor at the last reading.
    looked_at: i32,
    /// One bit a tick, the newest lowest: pump on, dump open, segment valves open.
    pump_on: u32,
    dump_open: u32,
    valve_open: PerSegment<u32>,
}

/// One more than the longest dead time.
const COURSES: usize = 32;
/// Share of an innovation that corrects the manifold, and each open chamber, as powers of two.
const MANIFOLD_SHIFT: u32 = 3;
const CHAMBER_SHIFT: u32 = 4;

impl Observer {
    /// All chambers at atmosphere, everything open: a finger that rests.
    #[must_use]
    pub const fn new(pneumatics: Pneumatics) -> Self {
        Self {
            pneumatics,
            ahead_manifold: Pressure::ZERO,
            ahead_chambers: [Pressure::ZERO; 3],
            sags: [Pressure::ZERO; 3],
            volumes: pneumatics.chamber_ratios,
            shares: [I16F16::ONE; 3],
            pump_speed: I16F16::ZERO,
            sensor: Pressure::ZERO,
            shift: Course { sensor: 0, chambers: [0; 3] },
            courses: [Course { sensor: 0, chambers: [0; 3] }; COURSES],
            newest: 0,
            turn: 0,
            manifold: Pressure::ZERO,
            chambers: [Pressure::ZERO; 3],
            flows: [I16F16::ZERO; 3],
            innovation: Pressure::ZERO,
            air: Air::STILL,
            looked_at: 0,
            pump_on: 0,
            dump_open: u32::MAX,
            valve_open: [u32::MAX; 3],
        }
    }

    /// Takes this tick's sensor reading, before the regulator decides.
    pub fn measure(&mut self, manifold: Pressure) {
        self.manifold = self.manifold.low_passed(manifold, 2);
        let dead = self.pneumatics.dead_ticks.get();
        let course = self.course(dead);
        let foretold = self.foretold();
        // A reading that no pressure explains must not throw the model.
        let innovation = (manifold - foretold).clamp(Pressure::ZERO - INNOVATION_LIMIT, INNOVATION_LIMIT);
        self.innovation = innovation;

        let step = innovation.to_bits() >> MANIFOLD_SHIFT;
        self.ahead_manifold = self.ahead_manifold + Pressure::from_bits(step);
        self.sensor = self.sensor + Pressure::from_bits(step);
        self.shift.sensor = self.shift.sensor.wrapping_add(step);
        self.air.expected = Pressure::from_bits(course.sensor.wrapping_sub(self.looked_at));
        self.looked_at = course.sensor;
        self.air.surprise = Pressure::from_bits(step);
        let mut corrected = I16F16::from_bits(step);
        let step = innovation.to_bits() >> CHAMBER_SHIFT;
        let per_chamber =
            self.ahead_chambers.iter_mut().zip(&mut self.shift.chambers).zip(&self.valve_open).zip(&self.volumes);
        for (((chamber, shift), &open), volume) in per_chamber {
            if open >> dead & 1 == 1 {
                *chamber = *chamber + Pressure::from_bits(step);
                *shift = shift.wrapping_add(step);
                corrected = corrected.saturating_add(volume.saturating_mul(I16F16::from_bits(step)));
            }
        }
        self.air.corrected = corrected;
        for (((now, flow), before), shift) in
            self.chambers.iter_mut().zip(&mut self.flows).zip(course.chambers).zip(self.shift.chambers)
        {
            let pressure = Pressure::from_bits(before.wrapping_add(shift));
            *flow = (pressure - *now).to_fixed();
            *now = pressure;
        }
    }

    /// What the model says that the sensor reads now.
    fn foretold(&self) -> Pressure {
        let course = self.course(self.pneumatics.dead_ticks.get());
        Pressure::from_bits(course.sensor.wrapping_add(self.shift.sensor))
    }

    /// Moves the model on by a tick under what was commanded.
    pub fn commanded(&mut self, actuation: &Actuation) {
        let push = |bits: &mut u32, on: bool| *bits = *bits << 1 | u32::from(on);
        push(&mut self.pump_on, actuation.pump);
        push(&mut self.dump_open, actuation.dump == Passage::Open);
        for (bits, passage) in self.valve_open.iter_mut().zip(actuation.segments) {
            push(bits, passage == Passage::Open);
        }

        let model = self.pneumatics;
        let target = if actuation.pump { I16F16::ONE } else { I16F16::ZERO };
        let missing = target.saturating_sub(self.pump_speed);
        self.pump_speed = self.pump_speed.saturating_add(model.pump_spin.saturating_mul(missing));
        let before = self.ahead_manifold;
        let mut flow = model.pump_flow(before).saturating_mul(self.pump_speed);
        self.air.moved = flow;
        if actuation.dump == Passage::Open {
            let out = model.valve_flow(model.dump_rate, before, Pressure::ZERO);
            self.air.moved = flow.saturating_add(out.saturating_abs());
            flow = flow.saturating_sub(out);
        }
        let valves = model.valve_rates.into_iter().zip(actuation.segments);
        for ((chamber, &share), (rate, passage)) in self.ahead_chambers.iter_mut().zip(&self.shares).zip(valves) {
            if passage == Passage::Open {
                let into = model.valve_flow(rate, before, *chamber);
                flow = flow.saturating_sub(into);
                *chamber = *chamber + Pressure::from_fixed(into.saturating_mul(share));
            }
        }
        self.ahead_manifold = before + Pressure::from_fixed(flow);
        let seen = before.midpoint(self.ahead_manifold) - self.sensor;
        self.sensor = self.sensor + seen.scaled(model.sensor_share);
        self.grow();

        self.newest = (self.newest + 1) % COURSES;
        let shift = self.shift;
        if let Some(course) = self.courses.get_mut(self.newest) {
            course.sensor = self.sensor.to_bits().wrapping_sub(shift.sensor);
            for ((course, chamber), shift) in course.chambers.iter_mut().zip(self.ahead_chambers).zip(shift.chambers) {
                *course = chamber.to_bits().wrapping_sub(shift);
            }
        }
    }

    /// One chamber a tick follows its bend's lag: what grows loses pressure.
    fn grow(&mut self) {
        let model = self.pneumatics;
        let index = self.turn;
        self.turn = (index + 1) % 3;
        let (Some(straight), Some(volume), Some(share), Some(chamber), Some(sag)) = (
            model.chamber_ratios.get(index),
            self.volumes.get_mut(index),
            self.shares.get_mut(index),
            self.ahead_chambers.get_mut(index),
            self.sags.get_mut(index),
        ) else {
            return;
        };
        let grown = I16F16::ONE.saturating_add(model.growth(*chamber));
        let missing = straight.saturating_mul(grown).saturating_sub(*volume);
        let change = missing.saturating_mul(model.bending);
        *volume = volume.saturating_add(change).max(const { I16F16::lit("0.1") });
        *share = divide(I16F16::ONE, *volume).unwrap_or(I16F16::ONE);
        let absolute = chamber.to_fixed().saturating_add(ATMOSPHERE);
        let stretch = absolute.saturating_mul(*share);
        *chamber = *chamber - Pressure::from_fixed(stretch.saturating_mul(change));
        *sag = Pressure::from_fixed(stretch.saturating_mul(missing));
    }

    /// The course `ago` ticks before the newest.
    fn course(&self, ago: u8) -> Course {
        let index = (self.newest + COURSES - usize::from(ago)) % COURSES;
        self.courses.get(index).copied().unwrap_or_default()
    }

    /// What the model says of the moment at which a command given now acts.
    #[must_use]
    pub fn ahead(&self) -> Ahead {
        let ticks = self.pump_speed.saturating_mul(self.pneumatics.pump_run_down);
        Ahead {
            manifold: self.ahead_manifold,
            chambers: self.ahead_chambers,
            sags: self.sags,
            coming: Pressure::from_fixed(self.pneumatics.pump_flow(self.ahead_manifold).saturating_mul(ticks)),
        }
    }

    /// Volume of each chamber in manifold volumes.
    #[must_use]
    pub const fn volumes(&self) -> PerSegment<I16F16> {
        self.volumes
    }

    /// Volume of the manifold and `group`, in manifold volumes; at least one.
    #[must_use]
    pub fn volume(&self, group: PerSegment<bool>) -> I16F16 {
        let members = self.volumes.iter().zip(group).filter(|&(_, member)| member);
        members.fold(I16F16::ONE, |sum, (&volume, _)| sum.saturating_add(volume))
    }

    /// What the last reading was off from what had been foretold of it.
    #[must_use]
    pub const fn innovation(&self) -> Pressure {
        self.innovation
    }

    /// Air that the last tick's model and correction moved.
    #[must_use]
    pub const fn air(&self) -> Air {
        self.air
    }

    /// Neither pump nor dump has moved air for a while.
    #[must_use]
    pub const fn air_rests(&self) -> bool {
        self.pump_on & REST_MASK == 0 && self.dump_open & REST_MASK == 0
    }

    /// Estimated gauge pressure of each chamber now.
    #[must_use]
    pub const fn chambers(&self) -> PerSegment<Pressure> {
        self.chambers
    }

    /// Rate of each chamber's pressure now, kPa per ms.
    #[must_use]
    pub const fn flows(&self) -> PerSegment<I16F16> {
        self.flows
    }

    /// The manifold's gauge pressure, filtered over about 4 ms.
    #[must_use]
    pub const fn manifold(&self) -> Pressure {
        self.manifold
    }

    /// Ticks of pump flow that were commanded and have not arrived yet.
    #[must_use]
    pub const fn pump_ticks_pending(&self) -> u32 {
        pending(self.pump_on, self.pneumatics.dead_ticks)
    }

    /// Ticks of dump flow that were commanded and have not arrived yet.
    #[must_use]
    pub const fn dump_ticks_pending(&self) -> u32 {
        pending(self.dump_open, self.pneumatics.dead_ticks)
    }

    /// The pneumatics assumed.
    #[must_use]
    pub const fn pneumatics(&self) -> &Pneumatics {
        &self.pneumatics
    }

    /// The pressure at which manifold and `group` would come to rest if nothing more flowed in or out.
    #[must_use]
    pub fn level(&self, group: PerSegment<bool>) -> Pressure {
        let (mut excess, mut volume) = (I16F16::ZERO, I16F16::ONE);
        for ((&chamber, &ratio), member) in self.chambers.iter().zip(&self.volumes).zip(group) {
            if member {
                excess = excess.saturating_add(ratio.saturating_mul((chamber - self.manifold).to_fixed()));
                volume = volume.saturating_add(ratio);
            }
        }
        let share = divide(excess, volume).unwrap_or(I16F16::ZERO);
        self.manifold + Pressure::from_fixed(share)
    }
}

/// The most by which one reading corrects.
const INNOVATION_LIMIT: Pressure = Pressure::from_kpa(64);

/// The last 24 ticks: dead time, spin-down and the sensor's lag.
const REST_MASK: u32 = 0x00FF_FFFF;

/// How many of the newest `dead_ticks` bits are set.
const fn pending(bits: u32, dead_ticks: DeadTicks) -> u32 {
    (bits & ((1 << dead_ticks.get()) - 1)).count_ones()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: Pneumatics = Pneumatics::NOMINAL;

    /// Everything closed for longer than the dead time, at atmosphere.
    fn held_at_zero() -> Observer {
        let mut observer = Observer::new(MODEL);
        for _ in 0..40 {
            observer.measure(Pressure::ZERO);
            observer.commanded(&Actuation::HOLD);
        }
        observer
    }

    #[test]
    fn dead_times_end_before_the_history_does() {
        assert_eq!(DeadTicks::new(31), Some(DeadTicks::MAX));
        assert_eq!(DeadTicks::new(32), None);
        // The longest counts every tick but the oldest of 32.
        let mut observer = Observer::new(Pneumatics { dead_ticks: DeadTicks::MAX, ..MODEL });
        for _ in 0..40 {
            observer.commanded(&Actuation { pump: true, ..Actuation::HOLD });
        }
        assert_eq!((observer.pump_ticks_pending(), observer.dump_ticks_pending()), (31, 0));
    }

    /// The manifold charged by the pump, everything closed, until it rests; returns what the sensor then reads.
    fn charged(observer: &mut Observer) -> Pressure {
        let mut reading = Pressure::ZERO;
        for tick in 0..200 {
            observer.measure(reading);
            observer.commanded(&Actuation { pump: tick < 60, ..Actuation::HOLD });
            // A machine that does what the model says.
            reading = observer.foretold();
        }
        reading
    }

    #[test]
    fn a_chamber_behind_a_closed_valve_keeps_its_estimate() {
        let mut observer = held_at_zero();
        assert!(charged(&mut observer) > Pressure::from_kpa(30));
        assert_eq!(observer.chambers(), [Pressure::ZERO; 3]);
    }

    #[test]
    fn an_open_chamber_comes_to_the_manifolds_pressure() {
        let mut observer = held_at_zero();
        let open = Actuation { segments: [Passage::Open, Passage::Closed, Passage::Closed], ..Actuation::HOLD };
        for _ in 0..900 {
            observer.commanded(&open);
            observer.measure(Pressure::from_kpa(120));
        }
        let [proximal, middle, _] = observer.chambers();
        assert!((proximal - Pressure::from_kpa(120)).abs() < Pressure::from_milli_kpa(100), "{proximal:?}");
        assert_eq!(middle, Pressure::ZERO);
        assert!(observer.innovation().abs() < Pressure::from_milli_kpa(100));
    }

    #[test]
    fn a_command_acts_in_the_model_at_once_and_in_the_estimate_after_the_dead_time() {
        let mut observer = held_at_zero();
        charged(&mut observer);
        let open = Actuation { segments: [Passage::Open, Passage::Closed, Passage::Closed], ..Actuation::HOLD };
        observer.commanded(&open);
        assert!(observer.ahead().chambers[0] > Pressure::ZERO);
        for _ in 0..10 {
            let reading = observer.foretold();
            observer.measure(reading);
            assert_eq!(observer.chambers()[0], Pressure::ZERO);
            observer.commanded(&open);
        }
        let reading = observer.foretold();
        observer.measure(reading);
        assert!(observer.chambers()[0] > Pressure::ZERO);
    }

    #[test]
    fn what_comes_after_a_stop_is_told_within_a_kilopascal() {
        let mut observer = held_at_zero();
        for _ in 0..60 {
            observer.commanded(&Actuation { pump: true, ..Actuation::HOLD });
        }
        let ahead = observer.ahead();
        for _ in 0..200 {
            observer.commanded(&Actuation::HOLD);
        }
        let came = observer.ahead().manifold - ahead.manifold;
        assert!((came - ahead.coming).abs() < Pressure::from_kpa(1), "{came:?} for {:?}", ahead.coming);
    }

    #[test]
    fn a_chamber_that_was_filled_fast_sags() {
        let mut observer = held_at_zero();
        charged(&mut observer);
        let open = Actuation { segments: [Passage::Open, Passage::Closed, Passage::Closed], ..Actuation::HOLD };
        for _ in 0..30 {
            observer.commanded(&open);
        }
        let filled = observer.ahead();
        assert!(filled.sags[0] > Pressure::from_kpa(1), "{filled:?}");
        for _ in 0..600 {
            observer.commanded(&Actuation::HOLD);
        }
        let rested = observer.ahead();
        assert!(rested.chambers[0] < filled.chambers[0] && rested.sags[0].abs() < Pressure::from_milli_kpa(100));
    }

    #[test]
    fn the_level_conserves_the_gas() {
        let mut observer = held_at_zero();
        charged(&mut observer);
        for _ in 0..30 {
            let reading = observer.foretold();
            observer.measure(reading);
            observer.commanded(&Actuation::HOLD);
        }
        let equal_shares = observer.manifold().to_f64() / (1.0 + observer.volumes()[0].to_num::<f64>());
        assert!((observer.level([true, false, false]).to_f64() - equal_shares).abs() < 0.1);
        assert_eq!(observer.level([false; 3]), observer.manifold());
    }
}
