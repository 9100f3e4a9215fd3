//! PWM of the segment valves with a PID each, feed-forward of the reference's rate, and anti-windup.

use super::front::{Front, FrontGains, Wish};
use super::pwm::Pwm;
use crate::compare::trial::Contender;
use model_core::actuation::{Actuation, PerSegment};
use model_core::observer::Pneumatics;
use model_core::units::Pressure;

/// Its own figures.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// Duty for a kPa.
    pub proportional_per_kpa: f64,
    /// Duty for a kPa and second.
    pub integral_per_kpa_s: f64,
    /// Duty for a kPa/ms.
    pub derivative_ms_per_kpa: f64,
    /// Share of the reference's rate over the rate an open valve gives that is added to the duty.
    pub feed_forward: f64,
    /// Period of the modulation, ms.
    pub period_ms: f64,
    /// Errors below it are none, kPa.
    pub dead_band_kpa: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Loop {
    integral: f64,
    last_ahead_kpa: f64,
    slope: f64,
    pwm: Pwm,
}

/// See the module's page.
pub struct PwmPid {
    front: Front,
    law: Law,
    loops: [Loop; 3],
}

impl PwmPid {
    /// Vented.
    #[must_use]
    pub fn new(front: FrontGains, law: Law) -> Self {
        Self { front: Front::new(front), law, loops: [Loop::default(); 3] }
    }
}

/// A larger integral than full duty would only overshoot.
const INTEGRAL_LIMIT: f64 = 1.0;
/// Time constant of the derivative's filter, ms.
const DERIVATIVE_FILTER_MS: f64 = 5.0;

impl Contender for PwmPid {
    fn know(&mut self, pneumatics: Pneumatics) {
        self.front.know(pneumatics);
    }

    fn step(&mut self, references: PerSegment<Pressure>, manifold: Pressure) -> Actuation {
        let view = self.front.observe(references, manifold);
        let law = self.law;
        let wishes: [Wish; 3] = core::array::from_fn(|i| {
            let one = &mut self.loops[i];
            let error = view.references_kpa[i] - view.ahead_kpa[i];
            // On the measurement, so that a jump of the reference does not kick.
            let slope = view.ahead_kpa[i] - one.last_ahead_kpa;
            one.last_ahead_kpa = view.ahead_kpa[i];
            one.slope += (slope - one.slope) / DERIVATIVE_FILTER_MS;
            let forward = law.feed_forward * view.reference_rates[i] / view.open_rates[i].max(0.02);
            let duty =
                law.proportional_per_kpa * error + one.integral - law.derivative_ms_per_kpa * one.slope + forward;
            let saturated = duty.abs() >= 1.0 && duty * error > 0.0;
            if error.abs() < law.dead_band_kpa {
                // Within the band nothing is wanted, and what was gathered on the way is not wanted either.
                one.integral *= 0.99;
            } else if !saturated {
                one.integral =
                    (one.integral + 1e-3 * law.integral_per_kpa_s * error).clamp(-INTEGRAL_LIMIT, INTEGRAL_LIMIT);
            }
            let wanted = if error.abs() < law.dead_band_kpa { 0.0 } else { duty };
            one.pwm.step(law.period_ms, view.served[i], wanted)
        });
        self.front.act(&view, wishes)
    }

    fn estimates_kpa(&self) -> [f64; 3] {
        self.front.estimates_kpa()
    }
}
