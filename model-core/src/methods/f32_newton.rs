//! What the three Newton methods in f32 share: the model without cancellation, the start, the steps.
//!
//! As in `f64_newton`, but in f32 and from the bend in degrees rather than radians: 180 degrees less the bend is exact in f32,
//! so that no digit is lost near the pole. Newton ends after a step of less than 5e-5 of the bend: the next would move it by
//! a few times the square of that, below f32's resolution.

use super::nodes::Nodes;
use super::{BEND_LIMIT_DEG, F64Newton, Method, PRESSURE_LIMIT_KPA, coefficients_kpa, within};
use crate::units::Coefficients;
use core::marker::PhantomData;

/// Radians a degree.
pub const RADIANS: f32 = core::f32::consts::PI / 180.0;
/// More steps than any input takes.
const MOST_STEPS: u32 = 8;
/// The last step, relative to the bend.
const LAST_STEP: f32 = 5e-5;
/// Below this angle in radians, the series rather than sine and cosine.
const SERIES_BELOW: f32 = 1.0;

/// What depends on the bend alone: of the two, each without cancellation.
pub struct Shortening {
    /// sin α / α.
    pub mu: f32,
    /// 1 − μ.
    pub t: f32,
}

/// What the three methods differ in.
pub trait Arithmetic {
    /// On command lines and in tables.
    const NAME: &'static str;
    /// One line for people.
    const SUMMARY: &'static str;
    /// The square root, for the start: an error of a few per cent costs a step.
    fn sqrt(value: f32) -> f32;
    /// At a bend in degrees, 0 < `bend` <= 170.
    fn shortening(bend: f32) -> Shortening;
    /// dt/dα at a bend in degrees whose μ is known; for Newton's steps, not for the result.
    fn t_slope(bend: f32, mu: f32) -> f32;
}

/// [`Shortening`] from the sine; from the series below 1 rad.
pub fn shortening_from(bend: f32, sin: impl Fn(f32) -> f32) -> Shortening {
    let alpha = bend * RADIANS;
    if alpha < SERIES_BELOW {
        let x = alpha * alpha;
        let t = x * (1.0 / 6.0 - x * (1.0 / 120.0 - x * (1.0 / 5040.0 - x * (1.0 / 362_880.0))));
        return Shortening { mu: 1.0 - t, t };
    }
    // From the pole's side the argument's rounding shrinks with the sine.
    let mu = sin(if bend > 90.0 { (180.0 - bend) * RADIANS } else { alpha }) / alpha;
    Shortening { mu, t: 1.0 - mu }
}

/// dt/dα from the cosine; from the series below 1 rad.
pub fn t_slope_from(bend: f32, mu: f32, cos: impl Fn(f32) -> f32) -> f32 {
    let alpha = bend * RADIANS;
    if alpha < SERIES_BELOW {
        let x = alpha * alpha;
        return alpha * (1.0 / 3.0 - x * (1.0 / 30.0 - x * (1.0 / 840.0 - x * (1.0 / 45_360.0))));
    }
    (mu - cos(alpha)) / alpha
}

/// Newton in f32.
#[derive(Clone, Copy, Debug)]
pub struct F32Newton<A> {
    k: f32,
    c1: f32,
    c2: f32,
    nodes: Nodes<f32>,
    arithmetic: PhantomData<A>,
}

impl<A: Arithmetic> F32Newton<A> {
    /// P in kPa and, per degree, its slope (where asked for) at 0 < `bend` <= 170 degrees.
    fn pressure_and_slope<const SLOPE: bool>(&self, bend: f32) -> (f32, f32) {
        let Shortening { mu, t } = A::shortening(bend);
        let mu2 = mu * mu;
        let mu4 = mu2 * mu2;
        let lambda = 1.0 / mu;
        let w = lambda * t * (1.0 + mu);
        let a = 4.0 * w * (1.0 + mu2 + mu4);
        let excess = w * w * (2.0 + mu2);
        let pressure = self.k * (bend * RADIANS) + a * (self.c1 + 2.0 * self.c2 * excess);
        if !SLOPE {
            return (pressure, 0.0);
        }
        let a_slope = 4.0 + 20.0 * mu4 * mu2;
        let stretch_slope = self.c1 * a_slope + 2.0 * self.c2 * (a_slope * excess + a * a);
        (pressure, (self.k + lambda * lambda * A::t_slope(bend, mu) * stretch_slope) * RADIANS)
    }

    fn s(&self, pressure: f32) -> f32 {
        let rise = 16.0 * self.c1 * pressure;
        let root = A::sqrt(self.k * self.k + rise);
        if root > 0.0 { rise / (root + self.k) } else { 0.0 }
    }
}

impl<A: Arithmetic> Method for F32Newton<A> {
    const NAME: &'static str = A::NAME;
    const SUMMARY: &'static str = A::SUMMARY;
    type Pressure = f32;
    type Bend = f32;

    fn prepare(coefficients: &Coefficients) -> Self {
        let [k, c1, c2] = coefficients_kpa(coefficients);
        let exact = F64Newton::prepare(coefficients);
        let s = |pressure: f64| {
            let rise = 16.0 * c1 * pressure;
            if rise > 0.0 { rise / (libm::sqrt(k * k + rise) + k) } else { 0.0 }
        };
        Self {
            k: k as f32,
            c1: c1 as f32,
            c2: c2 as f32,
            nodes: Nodes::<f32>::new(|bend| s(exact.pressure_from_bend(bend))),
            arithmetic: PhantomData,
        }
    }

    fn bend_from_pressure(&self, pressure: f32) -> f32 {
        let pressure = within(pressure, 0.0, PRESSURE_LIMIT_KPA as f32);
        if pressure <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high) = (0.0, BEND_LIMIT_DEG as f32);
        let mut bend = within(self.nodes.start_deg(self.s(pressure)), low, high);
        for _ in 0..MOST_STEPS {
            let (here, slope) = self.pressure_and_slope::<true>(bend);
            if here < pressure {
                low = bend;
            } else {
                high = bend;
            }
            let next = within(bend - (here - pressure) / slope, low, high);
            let step = (next - bend).abs();
            bend = next;
            if step <= LAST_STEP * bend {
                break;
            }
        }
        bend
    }

    fn pressure_from_bend(&self, bend: f32) -> f32 {
        // At 0 every term is 0.
        self.pressure_and_slope::<false>(within(bend, 0.0, BEND_LIMIT_DEG as f32)).0
    }
}
