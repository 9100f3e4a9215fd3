//! Dual-mode sliding mode with hysteresis between the modes.
//!
//! arXiv 2605.12804 (`BiPneu`) was at hand as its abstract only: a sliding mode controller with two modes, inflation and
//! deflation, whose selection a hysteresis supervises, designed on a hybrid model of asymmetric filling and emptying. The rest is
//! built from what is usual for sliding modes with on/off valves: the surface `s = e + lambda integral of e`; the rate wanted is
//! the reference's plus `k s + eta sat(s / phi)`; divided by the rate that ISO 6358 gives for the open valve in the mode at
//! hand it is the equivalent duty, which a PWM hands to the valve. A chamber takes up a mode when |s| passes the outer
//! threshold and leaves it at the inner one; from one mode to the other it goes through rest.

use super::front::{Front, FrontGains, Wish};
use super::pwm::Pwm;
use crate::compare::trial::Contender;
use model_core::actuation::{Actuation, PerSegment};
use model_core::observer::Pneumatics;
use model_core::units::Pressure;

/// Its own figures.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// lambda, 1/s.
    pub surface_per_s: f64,
    /// k, 1/s.
    pub reaching_per_s: f64,
    /// eta, kPa/s.
    pub switching_kpa_per_s: f64,
    /// phi, kPa.
    pub layer_kpa: f64,
    /// Outer threshold of |s|, kPa.
    pub enter_kpa: f64,
    /// Inner threshold as a share of the outer.
    pub leave_share: f64,
    /// Period of the modulation, ms.
    pub period_ms: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Channel {
    integral_kpa_s: f64,
    mode: i8,
    pwm: Pwm,
}

/// See the module's page.
pub struct SlidingMode {
    front: Front,
    law: Law,
    channels: [Channel; 3],
}

impl SlidingMode {
    /// Vented.
    #[must_use]
    pub fn new(front: FrontGains, law: Law) -> Self {
        Self { front: Front::new(front), law, channels: [Channel::default(); 3] }
    }
}

/// Errors beyond it are the reaching phase: they are not integrated, kPa.
const REACHING_KPA: f64 = 5.0;
/// Limit of the integral's part of s, kPa.
const INTEGRAL_KPA: f64 = 3.0;
/// No valve is taken to be slower, kPa/ms.
const SLOWEST: f64 = 0.02;

impl Contender for SlidingMode {
    fn know(&mut self, pneumatics: Pneumatics) {
        self.front.know(pneumatics);
    }

    fn step(&mut self, references: PerSegment<Pressure>, manifold: Pressure) -> Actuation {
        let view = self.front.observe(references, manifold);
        let law = self.law;
        let wishes: [Wish; 3] = core::array::from_fn(|i| {
            let channel = &mut self.channels[i];
            let error = view.references_kpa[i] - view.ahead_kpa[i];
            if error.abs() < REACHING_KPA {
                let limit = INTEGRAL_KPA / law.surface_per_s.max(1e-3);
                channel.integral_kpa_s = (channel.integral_kpa_s + 1e-3 * error).clamp(-limit, limit);
            } else {
                channel.integral_kpa_s = 0.0;
            }
            let s = error + law.surface_per_s * channel.integral_kpa_s;
            let leave = law.leave_share * law.enter_kpa;
            if channel.mode != 0 && s * f64::from(channel.mode) < leave {
                channel.mode = 0;
            }
            if channel.mode == 0 && s.abs() > law.enter_kpa {
                channel.mode = if s > 0.0 { 1 } else { -1 };
            }
            let reaching = law.reaching_per_s * s + law.switching_kpa_per_s * (s / law.layer_kpa).clamp(-1.0, 1.0);
            let rate = view.reference_rates[i] + 1e-3 * reaching;
            let duty =
                f64::from(channel.mode) * (f64::from(channel.mode) * rate / view.open_rates[i].max(SLOWEST)).max(0.0);
            channel.pwm.step(law.period_ms, view.served[i], duty)
        });
        self.front.act(&view, wishes)
    }

    fn estimates_kpa(&self) -> [f64; 3] {
        self.front.estimates_kpa()
    }
}
