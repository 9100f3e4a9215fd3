//! Bends asked for in degrees: the model says which pressure makes them, the bend sensor trims what the model gets wrong.
//!
//! ```text
//! bends asked for ──▶ × (1 + trim) ──▶ P(α) ──▶ setpoints ──▶ regulator, chambers ──▶ finger
//!                          ▲                                        │ estimates           │ bend (BF350)
//!                          │                                        ▼                     │
//!                          └── limit ◀── integral ◀── (+) ◀── Σ α(P), lagged like a finger │
//!                                                      ▲ −                                │
//!                                                      └──────────────────────────────────┘
//! ```
//!
//! The sensor tells the sum of three bends, so what it shows is shared out: the trim of each segment is a share of its own
//! bend, and of all trims that explain the sum the smallest is taken (a normalised gradient step: a segment that bends more
//! takes more). With one segment away from zero all of it is that segment's.
//!
//! The model's bend is taken at the *estimated* pressures, not at the setpoints: the regulator's own errors, a setpoint
//! that cannot be reached and the way there are no model error, so nothing winds up. The integral stands still while the
//! model's bend moves faster than a finger with the lag of [`LAG_UPDATES`] follows, while air flows, and without a sensor.
//! A trim is published at most once a second and only when it is worth 0.3 degree: each costs the regulator a service.
//!
//! Trims end at ±15 %, start at none when the finger is vented, and go back to none when the sensor fails: then pressure
//! alone, by the model, holds the finger. The pressure limit comes after the trim.

use crate::actuation::PerSegment;
use crate::inverse::bend_from_pressure;
use crate::units::{Bend, Coefficients, Pressure};
use fixed::types::I16F16;

/// Ticks from one update of the trims to the next.
const UPDATE_TICKS: u8 = 16;
/// The finger's lag in updates: 80 ms.
const LAG_UPDATES: i32 = 5;
/// Updates for which the model's bend must have stood still: five times the lag.
const STILL_UPDATES: u8 = 25;
/// The model's bend stands still while it differs by less than this from what a finger with lag has: 0.5 degree, a rate of
/// 6 degrees a second.
const STILL: i32 = 1 << 15;
/// An update takes this power of one half of what is missing: half a second in all.
const GAIN_SHIFT: u32 = 5;
/// The largest trim, 15 % in 2⁻²⁴: three times the gap to experiment that the paper reports for its model.
const MOST_TRIM: i32 = (0.15 * (1 << 24) as f64) as i32;
/// A sum of bends below this is not trimmed: the sensor's own errors are worth more.
const LEAST_SUM: Bend = Bend::from_deg(10);
/// The most that one update looks at, 64 degrees.
const MOST_MISSING: i32 = 64 << 16;
/// Updates between two changes of the trims in use: one second.
const PUBLISH_UPDATES: u8 = 63;
/// The least change, 0.3 degree of the sum.
const PUBLISH: i32 = 19_661;
/// Updates without a reading after which the sensor counts as failed.
const MISSING_UPDATES: u8 = 3;

/// What a tick shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observation {
    /// What is asked for in degrees; none when nothing is, or in pressures.
    pub bends: Option<PerSegment<Bend>>,
    /// Each chamber's estimated pressure.
    pub estimates: PerSegment<Pressure>,
    /// The finger's bend; none while its sensor fails.
    pub bend: Option<Bend>,
    /// Neither pump nor dump valve has moved air for a while.
    pub air_rests: bool,
}

/// See the module's text.
#[derive(Clone, Debug)]
pub struct BendLoop {
    slot: u8,
    /// The model's bend of each segment, and what a finger with lag has of the sum, 2⁻¹⁶ degree.
    modelled: PerSegment<Bend>,
    lagged: i32,
    /// The sensor's, filtered over 16 ticks, 2⁻²⁰ degree.
    measured: i64,
    /// Trims as they are known and as they are used, as a share of the bend, 2⁻²⁴.
    known: PerSegment<i32>,
    used: PerSegment<i32>,
    still_updates: u8,
    since_published: u8,
    missing_updates: u8,
}

impl BendLoop {
    /// No trim.
    pub(crate) const fn new() -> Self {
        Self {
            slot: 0,
            modelled: [Bend::ZERO; 3],
            lagged: 0,
            measured: 0,
            known: [0; 3],
            used: [0; 3],
            still_updates: 0,
            since_published: PUBLISH_UPDATES,
            missing_updates: 0,
        }
    }

    /// What the model is asked for, so that the finger has these bends.
    pub(crate) fn trimmed(&self, bends: PerSegment<Bend>) -> PerSegment<Bend> {
        let mut trimmed = bends;
        for (bend, &trim) in trimmed.iter_mut().zip(&self.used) {
            *bend = *bend + Bend::from_bits(((i64::from(bend.to_bits()) * i64::from(trim)) >> 24) as i32);
        }
        trimmed
    }

    /// The trims in use, as a share of each segment's bend; within ±0.15.
    #[must_use]
    pub fn trims(&self) -> PerSegment<I16F16> {
        self.used.map(|trim| I16F16::from_bits(trim >> 8))
    }

    /// The sensor fails, and bends are made by pressure alone.
    #[must_use]
    pub const fn falls_back(&self) -> bool {
        self.missing_updates >= MISSING_UPDATES
    }

    /// Looks at a tick. At most some 230 instructions. True in the ticks in which it has little to do itself.
    pub(crate) fn step(&mut self, seen: &Observation, coefficients: &PerSegment<Coefficients>) -> bool {
        if let Some(bend) = seen.bend {
            self.measured += i64::from(bend.to_bits()) - (self.measured >> 4);
        }
        self.slot = if self.slot + 1 < UPDATE_TICKS { self.slot + 1 } else { 0 };
        let ours = usize::from(self.slot);
        let parts = (coefficients.get(ours), seen.estimates.get(ours), self.modelled.get_mut(ours));
        if let (Some(own), Some(&pressure), Some(modelled)) = parts {
            *modelled = bend_from_pressure(own, pressure);
            return false;
        }
        if ours == 3 {
            self.update(seen);
            return false;
        }
        true
    }

    fn update(&mut self, seen: &Observation) {
        self.since_published = self.since_published.saturating_add(1).min(PUBLISH_UPDATES);
        let modelled: i32 = self.modelled.iter().fold(0, |sum, bend| sum + bend.to_bits());
        let behind = modelled - self.lagged;
        self.lagged += behind / LAG_UPDATES;
        let still = behind.saturating_abs() < STILL && seen.air_rests;
        self.still_updates = if still { self.still_updates.saturating_add(1) } else { 0 };

        self.missing_updates = if seen.bend.is_some() { 0 } else { self.missing_updates.saturating_add(1) };
        let Some(bends) = seen.bends else {
            // The next command starts without a trim.
            (self.known, self.used) = ([0; 3], [0; 3]);
            return;
        };
        if self.falls_back() {
            for (known, used) in self.known.iter_mut().zip(&mut self.used) {
                // Over a quarter of a second; what is left at the end is below 1e-6.
                *used -= *used / 16;
                *known = *used;
            }
            return;
        }
        if self.missing_updates > 0 || self.still_updates < STILL_UPDATES {
            return;
        }
        self.learn(&bends);
    }

    fn learn(&mut self, bends: &PerSegment<Bend>) {
        // Bends asked for lie within 0..=110 degrees: their squares add up to no more than 36,300.
        let degrees = bends.map(|bend| (bend.to_bits() >> 16).max(0).min(180));
        let (sum, squares) = degrees.iter().fold((0, 0), |(sum, squares), &d| (sum + d, squares + d * d));
        if sum < LEAST_SUM.to_bits() >> 16 {
            return;
        }
        let explained = |trims: &PerSegment<i32>| -> i32 {
            trims.iter().zip(&degrees).map(|(&trim, &d)| ((i64::from(trim) * i64::from(d)) >> 8) as i32).sum()
        };
        let measured = (self.measured >> 4).max(i64::from(-MOST_MISSING)).min(1 << 26) as i32;
        let (known, used) = (explained(&self.known), explained(&self.used));
        let missing = (self.lagged - measured - known).max(-MOST_MISSING).min(MOST_MISSING);
        // In 2⁻²⁴ per degree.
        let step = (missing << 8).checked_div(squares).unwrap_or(0);
        for (trim, &d) in self.known.iter_mut().zip(&degrees) {
            *trim = (*trim + ((step * d) >> GAIN_SHIFT)).max(-MOST_TRIM).min(MOST_TRIM);
        }
        if self.since_published >= PUBLISH_UPDATES && (known - used).saturating_abs() > PUBLISH {
            (self.used, self.since_published) = (self.known, 0);
        }
    }
}
