//! One segment of the finger: its bend follows its pressure, and its volume follows its bend.

use super::gas::{GasVolume, REFERENCE_KPA};
use crate::mechanics::{angle_from_pressure_rad, pressure_and_slope};
use core::f64::consts::PI;

/// A bend that follows its static value with a first-order lag: `d alpha/dt = (alpha_static(P) - alpha) / tau`.
///
/// The lag acts on the bend and not as a damper on the pressure (`d alpha/dt = (P - P_model(alpha)) / d`): the model's
/// stiffness vanishes at alpha = 0, so a damped finger would creep back to straight as 1/t and never arrive.
#[derive(Clone, Debug)]
pub struct Bend {
    coefficients: [f64; 3],
    /// Share of the difference that a tick takes away; 1 without lag.
    share: f64,
    rest_volume_l: f64,
    /// Volume per bend, L/rad.
    growth_l_per_rad: f64,
    alpha: f64,
    /// The static bend of the last tick, where the next search starts.
    goal: f64,
}

impl Bend {
    /// Straight. `growth_l_per_rad` and `lag_ms` may be zero.
    #[must_use]
    pub fn new(coefficients_kpa: [f64; 3], rest_volume_l: f64, growth_l_per_rad: f64, lag_ms: f64) -> Self {
        Self {
            coefficients: coefficients_kpa,
            share: if lag_ms > 0.0 { -(-1.0 / lag_ms).exp_m1() } else { 1.0 },
            rest_volume_l,
            growth_l_per_rad,
            alpha: 0.0,
            goal: 0.0,
        }
    }

    /// The bend in radians.
    #[must_use]
    pub fn rad(&self) -> f64 {
        self.alpha
    }

    /// One tick: bends, and sets the gas's volume to fit.
    ///
    /// Bend, volume and pressure are solved together (backward Euler). Taken one after another they would chatter
    /// near P = 0, where alpha(P) has infinite slope: a trace of pressure bends the finger by degrees, its volume
    /// grows, and the pressure is below zero.
    pub fn step(&mut self, gas: &mut GasVolume, atmosphere_kpa: f64) {
        self.goal = self.solve(gas.content_nl(), atmosphere_kpa);
        self.alpha += (self.goal - self.alpha) * self.share;
        // The tail of the exponential, far below anything measurable, would end in slow denormal numbers.
        if self.goal <= 0.0 && self.alpha < 1e-12 {
            self.alpha = 0.0;
        }
        if self.growth_l_per_rad > 0.0 {
            gas.set_volume_l(self.rest_volume_l + self.growth_l_per_rad * self.alpha);
        }
    }

    /// The static bend whose model pressure is the gas's pressure at the bend that the lag makes of it.
    fn solve(&self, content_nl: f64, atmosphere_kpa: f64) -> f64 {
        // Excess of the model's pressure over the gas's, and its slope: strictly increasing, so one zero at most.
        let excess = |goal: f64| {
            let (model, slope) = pressure_and_slope(&self.coefficients, goal);
            let volume = self.rest_volume_l + self.growth_l_per_rad * (self.alpha + (goal - self.alpha) * self.share);
            let absolute = content_nl * REFERENCE_KPA / volume;
            (model - (absolute - atmosphere_kpa), slope + absolute / volume * self.growth_l_per_rad * self.share)
        };
        // A vented chamber's gauge pressure is rounding, about 1e-14 kPa: nothing to search in.
        if excess(0.0).0 >= -1e-11 {
            return 0.0;
        }
        // Newton from the last bend, a bracket around it for the cases where it would leave.
        let (mut low, mut high) = (0.0, PI);
        let mut goal = self.goal.max(1e-5);
        for _ in 0..60 {
            let (value, slope) = excess(goal);
            if value < 0.0 {
                low = goal;
            } else {
                high = goal;
            }
            let newton = goal - value / slope;
            // The ends belong to it: at the root Newton's step is zero, and must not be taken for one that leaves.
            let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            let moved = (next - goal).abs();
            goal = next;
            // Newton squares its error: after a step of 1e-8 what remains is rounding.
            if moved <= 1e-8 * goal {
                break;
            }
        }
        goal
    }

    /// The bend in radians that a constant gauge pressure in kPa would end in.
    #[must_use]
    pub fn static_rad(&self, gauge_kpa: f64) -> f64 {
        angle_from_pressure_rad(&self.coefficients, gauge_kpa)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COEFFICIENTS: [f64; 3] = [0.0, 13.84, 0.336];
    const ATMOSPHERE: f64 = 101.325;
    const REST_L: f64 = 0.0068;
    const GROWTH: f64 = 0.3 * REST_L / 2.0;

    #[test]
    fn without_lag_bend_and_gas_agree_at_once() {
        for gauge in [1e-9, 1e-6, 1e-3, 0.1, 5.0, 30.0, 150.0, 240.0] {
            let mut bend = Bend::new(COEFFICIENTS, REST_L, GROWTH, 0.0);
            let mut gas = GasVolume::at_pressure(REST_L, ATMOSPHERE + gauge);
            bend.step(&mut gas, ATMOSPHERE);
            let left = gas.absolute_kpa() - ATMOSPHERE;
            assert!(left >= -1e-12 && left < gauge, "{gauge}: {left}");
            let model = pressure_and_slope(&COEFFICIENTS, bend.rad()).0;
            assert!((model - left).abs() < 1e-10, "{gauge}: {model} {left}");
            // And again: it stays.
            let before = bend.rad();
            bend.step(&mut gas, ATMOSPHERE);
            assert!((bend.rad() - before).abs() < 1e-9);
        }
    }

    #[test]
    fn lags_by_its_time_constant() {
        let mut bend = Bend::new(COEFFICIENTS, REST_L, 0.0, 80.0);
        let mut gas = GasVolume::at_pressure(REST_L, ATMOSPHERE + 100.0);
        for _ in 0..80 {
            bend.step(&mut gas, ATMOSPHERE);
        }
        let share = bend.rad() / bend.static_rad(100.0);
        assert!((share - (1.0 - (-1.0_f64).exp())).abs() < 1e-9, "{share}");
    }

    #[test]
    fn vacuum_is_straight() {
        let mut bend = Bend::new(COEFFICIENTS, REST_L, GROWTH, 80.0);
        let mut gas = GasVolume::at_pressure(REST_L, ATMOSPHERE - 60.0);
        bend.step(&mut gas, ATMOSPHERE);
        assert!(bend.rad().abs() <= 0.0);
    }
}
