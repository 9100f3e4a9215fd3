//! The air pump behind its relay and its check valve.

use super::delay::Delay;
use super::parameters::PumpParameters;

/// The pump: relay dead time, spin-up, and a flow that falls linearly to zero at the stall pressure.
#[derive(Clone, Debug)]
pub struct Pump {
    relay: Delay<bool>,
    /// Share of full speed at the start, in the middle and at the end of this tick, 0..=1.
    start_speed: f64,
    middle_speed: f64,
    speed: f64,
    /// What remains of a speed difference after half a tick.
    half_tick_decay: f64,
    free_flow_nl_per_s: f64,
    /// The same of the pump as it should be.
    whole_flow_nl_per_s: f64,
    /// 1/stall pressure, per kPa.
    per_stall_kpa: f64,
}

impl Pump {
    /// At rest. `dead_time_ticks` and `lag_ms` are given apart because a scene may leave them out (zero).
    #[must_use]
    pub fn new(parameters: &PumpParameters, dead_time_ticks: u32, lag_ms: f64) -> Self {
        Self {
            relay: Delay::new(dead_time_ticks, false),
            start_speed: 0.0,
            middle_speed: 0.0,
            speed: 0.0,
            half_tick_decay: if lag_ms > 0.0 { (-0.5 / lag_ms).exp() } else { 0.0 },
            free_flow_nl_per_s: parameters.free_flow_nl_per_min / 60.0,
            whole_flow_nl_per_s: parameters.free_flow_nl_per_min / 60.0,
            per_stall_kpa: 1.0 / parameters.stall_kpa,
        }
    }

    /// Leaves it a share (0..=1) of its flow at every pressure.
    pub fn weaken(&mut self, share: f64) {
        self.free_flow_nl_per_s = self.whole_flow_nl_per_s * share;
    }

    /// One tick: takes the relay's command; `stuck` overrides the relay's contact.
    #[inline]
    pub fn step(&mut self, command: bool, stuck: Option<bool>) {
        let contact = self.relay.step(command);
        let target = if stuck.unwrap_or(contact) { 1.0 } else { 0.0 };
        if target <= 0.0 && self.rests() {
            return;
        }
        // Without lag the speed has jumped when the tick starts.
        self.start_speed = if self.half_tick_decay > 0.0 { self.speed } else { target };
        self.middle_speed = target + (self.start_speed - target) * self.half_tick_decay;
        self.speed = target + (self.middle_speed - target) * self.half_tick_decay;
        // An exponential never ends; a rotor does, and a still pump lets the plant skip the gas.
        if self.speed < 1e-6 {
            self.speed = 0.0;
        }
    }

    /// True while it gives no flow at all in this tick.
    #[inline]
    #[must_use]
    pub fn rests(&self) -> bool {
        self.speed <= 0.0 && self.start_speed <= 0.0
    }

    /// Share of full speed, 0..=1.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Its flow at a share of this tick, 0..=1.
    ///
    /// The exponential of the speed is taken as the parabola through the tick's start, middle and end: with a time
    /// constant of 15 ms it is within 3e-6 of it.
    #[inline]
    #[must_use]
    pub fn delivery(&self, tick_share: f64) -> Delivery {
        let x = 2.0 * tick_share - 1.0;
        let half_rise = 0.5 * (self.speed - self.start_speed);
        let bow = 0.5 * (self.speed + self.start_speed) - self.middle_speed;
        let free_nl_per_s = (self.middle_speed + x * (half_rise + x * bow)) * self.free_flow_nl_per_s;
        Delivery { free_nl_per_s, slope_nl_per_s_kpa: free_nl_per_s * self.per_stall_kpa }
    }
}

/// The pump's flow over the manifold's pressure, at one speed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Delivery {
    /// Flow against no pressure, NL/s.
    free_nl_per_s: f64,
    /// What a kPa takes of it, NL/(s kPa).
    slope_nl_per_s_kpa: f64,
}

impl Delivery {
    /// Flow in NL/s into a manifold at a gauge pressure in kPa, and its slope, NL/(s kPa). Never negative: the check
    /// valve.
    #[inline]
    #[must_use]
    pub fn flow_and_slope(&self, gauge_kpa: f64) -> (f64, f64) {
        let flow = self.free_nl_per_s - self.slope_nl_per_s_kpa * gauge_kpa;
        if flow > 0.0 { (flow, -self.slope_nl_per_s_kpa) } else { (0.0, 0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flow_falls_linearly_and_never_reverses() {
        let mut pump = Pump::new(&PumpParameters::default(), 0, 0.0);
        assert!(pump.rests());
        pump.step(true, None);
        // 3 NL/min is 0.05 NL/s; stall at 250 kPa.
        for (gauge, expected) in [(0.0, 0.05), (125.0, 0.025), (150.0, 0.02), (250.0, 0.0), (400.0, 0.0)] {
            assert!((pump.delivery(0.5).flow_and_slope(gauge).0 - expected).abs() < 1e-15, "{gauge}");
        }
    }

    #[test]
    fn within_a_tick_the_flow_follows_the_speed() {
        let mut pump = Pump::new(&PumpParameters::default(), 0, 15.0);
        pump.step(true, None);
        for share in [0.0, 0.1, 0.25, 0.5, 0.8, 1.0] {
            let exact = 0.05 * (1.0 - (-share / 15.0_f64).exp());
            let flow = pump.delivery(share).flow_and_slope(0.0).0;
            assert!((flow - exact).abs() < 0.05 * 3e-6, "{share}: {flow} {exact}");
        }
    }

    #[test]
    fn speed_follows_after_the_dead_time() {
        let parameters = PumpParameters::default();
        let mut pump = Pump::new(&parameters, 10, 15.0);
        for _ in 0..10 {
            pump.step(true, None);
            assert!(pump.rests());
        }
        for _ in 0..15 {
            pump.step(true, None);
        }
        assert!((pump.speed() - (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
        for _ in 0..10 {
            pump.step(false, None);
        }
        assert!(pump.speed() > 0.8);
        for _ in 0..300 {
            pump.step(false, None);
        }
        assert!(pump.rests());
        pump.step(false, Some(true));
        assert!(!pump.rests());
    }
}
