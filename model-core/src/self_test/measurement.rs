//! What the self test's own flows tell of pump, valves and chambers.
//!
//! - **Pump.** What the manifold alone has gained over a charge, by the ticks for which the pump was commanded: what is missing
//!   while it spins up comes while it runs down, and a dead time delays both ends alike.
//! - **Chambers.** Air is conserved when the charged manifold opens to a straight chamber at atmosphere.
//! - **Valves.** While the charged manifold empties, its loss against the time integral of what ISO 6358 lets through for the
//!   pressures on both sides: the slope of a straight line by least squares, which no dead time moves.
//!
//! What cannot be told stays nominal, and nothing leaves the bounds in which a machine passes the self test.
//! `cargo test -p finger-tests --test measurement -- --nocapture` prints the errors over a thousand drawn machines.

use crate::actuation::PerSegment;
use crate::division::divide;
use crate::observer::{ATMOSPHERE, Pneumatics};
use crate::units::Pressure;
use fixed::types::I16F16;

/// Ticks of a valve's opening that are kept: twice the nominal dead time and the better part of the flow.
const TRACE: usize = 96;
/// Kept samples that are worked through in a tick.
const PER_TICK: usize = 4;
/// The line is fitted where the manifold has lost from this share of its pressure, in 256ths, ...
const FROM_256THS: i64 = 20;
/// ... to this, for a chamber ...
const TO_CHAMBER_256THS: i64 = 90;
/// ... and for the atmosphere, towards which the flow goes on as it began.
const TO_ATMOSPHERE_256THS: i64 = 160;
/// Fewer samples tell nothing.
const SAMPLES: i64 = 6;
/// A chamber's growth is counted by this share: the bend has not come to its rest by the end of the opening, and the rest of the
/// loss is the gas's.
const GROWN: I16F16 = I16F16::lit("0.77");
/// Nothing is taken to be less than a third or more than three times the nominal.
const BOUND: I16F16 = I16F16::lit("3");

/// What a trace is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Passing {
    Nothing,
    /// Index of the segment.
    Chamber(usize),
    Dump,
}

/// See the module's page.
#[derive(Clone, Debug)]
pub(super) struct Measurement {
    measured: Pneumatics,
    /// The reading, filtered over 8 ms.
    level: Pressure,
    /// What it is at atmosphere.
    zero: Pressure,
    /// Where the charge began, and for how many ticks the pump was commanded.
    from: Pressure,
    pumped: u16,
    /// Gains of all charges, in kPa, and the ticks of full flow that they took.
    gained: I16F16,
    ticks: I16F16,
    /// A valve's opening: readings above atmosphere, kPa in 2^-8.
    trace: [i16; TRACE],
    kept: usize,
    passing: Passing,
    /// What was there before, above atmosphere.
    before: Pressure,
    line: Line,
}

/// Sums of a fit by least squares: x in kPa ms, y in kPa 2^-8.
#[derive(Clone, Copy, Debug)]
struct Line {
    cursor: usize,
    x: I16F16,
    n: i64,
    sum_x: i64,
    sum_y: i64,
    sum_xx: i64,
    sum_xy: i64,
}

impl Line {
    const NONE: Self = Self { cursor: 0, x: I16F16::ZERO, n: 0, sum_x: 0, sum_y: 0, sum_xx: 0, sum_xy: 0 };

    const fn add(&mut self, y: i64) {
        let x = (self.x.to_bits() >> 16) as i64;
        self.n += 1;
        self.sum_x += x;
        self.sum_y += y;
        self.sum_xx += x * x;
        self.sum_xy += x * y;
    }

    /// kPa per ms and kPa.
    fn slope(&self) -> Option<I16F16> {
        if self.n < SAMPLES {
            return None;
        }
        let over = self.n * self.sum_xy - self.sum_x * self.sum_y;
        let under = self.n * self.sum_xx - self.sum_x * self.sum_x;
        let bits = (over << 8).checked_div(under)?;
        Some(I16F16::from_bits(i32::try_from(bits).ok()?))
    }
}

impl Measurement {
    pub(super) const fn new() -> Self {
        Self {
            measured: Pneumatics::NOMINAL,
            level: Pressure::ZERO,
            zero: Pressure::ZERO,
            from: Pressure::ZERO,
            pumped: 0,
            gained: I16F16::ZERO,
            ticks: I16F16::ZERO,
            trace: [0; TRACE],
            kept: 0,
            passing: Passing::Nothing,
            before: Pressure::ZERO,
            line: Line::NONE,
        }
    }

    /// Each tick's reading, before anything else.
    pub(super) fn read(&mut self, reading: Pressure) {
        let off = i64::from(reading.to_bits()) - i64::from(self.level.to_bits());
        self.level = self.level + Pressure::from_bits((off >> 3) as i32);
    }

    /// The finger has rested at atmosphere.
    pub(super) const fn rests(&mut self) {
        self.zero = self.level;
    }

    /// The pump is commanded from now on.
    pub(super) const fn charging(&mut self) {
        (self.from, self.pumped) = (self.level, 0);
    }

    /// A tick of the pump.
    pub(super) const fn pumps(&mut self) {
        self.pumped = self.pumped.saturating_add(1);
    }

    /// The pump has long stopped, and nothing was open: the next opening begins.
    pub(super) fn charged(&mut self) {
        let gain = self.level - self.from;
        let mean = self.from.midpoint(self.level) - self.zero;
        let share = I16F16::ONE.saturating_sub(self.measured.pump_fade.saturating_mul(mean.to_fixed()));
        self.gained = self.gained.saturating_add(gain.to_fixed());
        self.ticks = self.ticks.saturating_add(I16F16::from_num(self.pumped.min(1000)).saturating_mul(share));
        if let Some(rate) = divide(self.gained, self.ticks) {
            self.measured.pump_rate = within(rate, Pneumatics::NOMINAL.pump_rate);
        }
        self.before = self.level - self.zero;
        (self.kept, self.passing) = (0, Passing::Nothing);
    }

    /// A tick of an opening: kept for later.
    pub(super) fn opens(&mut self, reading: Pressure) {
        if let Some(sample) = self.trace.get_mut(self.kept) {
            let bits = (reading - self.zero).to_bits() >> 8;
            *sample = bits.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16;
            self.kept += 1;
        }
    }

    /// The charged manifold, alone before, has emptied into this chamber, straight and at atmosphere before.
    pub(super) fn filled(&mut self, segment: usize) {
        let after = self.level - self.zero;
        let growth = self.measured.growth(after).saturating_mul(GROWN);
        // The chamber's air in chamber volumes: its pressure, and what grew, filled from nothing.
        let taken = after.to_fixed().saturating_add(growth.saturating_mul(after.to_fixed().saturating_add(ATMOSPHERE)));
        let ratio = divide((self.before - after).to_fixed(), taken);
        if let (Some(own), Some(ratio)) = (self.measured.chamber_ratios.get_mut(segment), ratio) {
            *own = within(ratio, NOMINAL_RATIO);
        }
        (self.passing, self.line) = (Passing::Chamber(segment), Line::NONE);
    }

    /// The charged manifold has emptied through the dump valve.
    pub(super) const fn dumped(&mut self) {
        (self.passing, self.line) = (Passing::Dump, Line::NONE);
    }

    /// Works through a part of what was kept; to be called in each tick in which nothing is kept.
    pub(super) fn work(&mut self) {
        let (inverse, to) = match self.passing {
            Passing::Nothing => return,
            Passing::Chamber(segment) => {
                let ratio = self.measured.chamber_ratios.get(segment).copied().unwrap_or(NOMINAL_RATIO);
                (divide(I16F16::ONE, ratio).unwrap_or(I16F16::ZERO), TO_CHAMBER_256THS)
            }
            Passing::Dump => (I16F16::ZERO, TO_ATMOSPHERE_256THS),
        };
        let before = i64::from(self.before.to_bits()) >> 8;
        for _ in 0..PER_TICK {
            let sample = self.trace.get(self.line.cursor).filter(|_| self.line.cursor < self.kept);
            let Some(&sample) = sample else {
                self.end();
                return;
            };
            self.line.cursor += 1;
            let lost = before - i64::from(sample);
            let manifold = Pressure::from_bits(i32::from(sample) << 8);
            let chamber = Pressure::from_fixed((self.before - manifold).to_fixed().saturating_mul(inverse));
            if lost << 8 >= before * FROM_256THS && lost << 8 <= before * to {
                self.line.add(lost);
            }
            if lost << 8 >= before * (FROM_256THS / 2) {
                let effective = self.measured.effective_pressure(manifold, chamber.max(Pressure::ZERO));
                self.line.x = self.line.x.saturating_add(effective);
            }
        }
    }

    fn end(&mut self) {
        if let Some(rate) = self.line.slope() {
            let rate = within(rate, Pneumatics::NOMINAL.dump_rate);
            match self.passing {
                Passing::Chamber(segment) => {
                    if let Some(own) = self.measured.valve_rates.get_mut(segment) {
                        *own = rate;
                    }
                }
                Passing::Dump => self.measured.dump_rate = rate,
                Passing::Nothing => {}
            }
        }
        self.passing = Passing::Nothing;
    }

    pub(super) const fn measured(&self) -> Pneumatics {
        self.measured
    }
}

const NOMINAL_RATIO: I16F16 = {
    let [ratio, _, _]: PerSegment<I16F16> = Pneumatics::NOMINAL.chamber_ratios;
    ratio
};

/// Within the bounds of what a machine may have.
fn within(value: I16F16, nominal: I16F16) -> I16F16 {
    let lowest = divide(nominal, BOUND).unwrap_or(nominal);
    value.max(lowest).min(nominal.saturating_mul(BOUND))
}
