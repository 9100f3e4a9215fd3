//! Newton in f64 with libm's sine and cosine: what a desk would do, and what the tables of the other methods are built
//! with.
//!
//! With μ = sin α / α, t = 1 − μ, λ = 1/μ and w = λ t (1 + μ) nothing cancels: A = 4 w (1 + μ² + μ⁴), I1 − 3 = w² (2 + μ²),
//! dλ/dα = λ² dt/dα. Below 1 rad t and dt/dα come from their series, above from sine and cosine. Newton starts from
//! `nodes`, inside a bracket, and ends when a step moves the bend by less than 1e-8 of itself, because
//! the step after that would be below f64's resolution.
//!
//! Worst error over 0..1000 kPa and 0..170 degrees, eight calibrations: 3e-13 degree, 2e-12 kPa
//! (`cargo test -p model-core f64_newton -- --nocapture`).

use super::nodes::Nodes;
use super::{BEND_LIMIT_DEG, Method, PRESSURE_LIMIT_KPA, coefficients_kpa, within};
use crate::units::Coefficients;

/// Below this angle in radians the series.
const SERIES_BELOW: f64 = 1.0;
/// More steps than any input takes; it keeps the loop finite whatever happens.
const MOST_STEPS: u32 = 20;
/// The last step, relative to the bend.
const LAST_STEP: f64 = 1e-8;

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct F64Newton {
    k: f64,
    c1: f64,
    c2: f64,
    nodes: Nodes<f64>,
}

/// t = 1 − sin α / α and, where asked for, dt/dα.
fn shortening<const SLOPE: bool>(alpha: f64) -> (f64, f64) {
    if alpha >= SERIES_BELOW {
        if !SLOPE {
            return (1.0 - libm::sin(alpha) / alpha, 0.0);
        }
        let (sin, cos) = libm::sincos(alpha);
        return (1.0 - sin / alpha, (sin - alpha * cos) / (alpha * alpha));
    }
    let x = alpha * alpha;
    // Each term of t is the one before times −x / (n (n + 1)), of dt/dα times −x / ((n − 2) (n + 1)), n = 4, 6, 8 ...
    let (mut t, mut slope) = (1.0, 1.0);
    for n in (2..=9).rev() {
        let n = f64::from(2 * n);
        t = 1.0 - x / (n * (n + 1.0)) * t;
        if SLOPE {
            slope = 1.0 - x / ((n - 2.0) * (n + 1.0)) * slope;
        }
    }
    (x / 6.0 * t, alpha / 3.0 * slope)
}

impl F64Newton {
    /// P in kPa and, where asked for, dP/dα in kPa per radian at 0 < `alpha` < π.
    fn pressure_and_slope<const SLOPE: bool>(&self, alpha: f64) -> (f64, f64) {
        let (t, t_slope) = shortening::<SLOPE>(alpha);
        let mu = 1.0 - t;
        let mu2 = mu * mu;
        let mu4 = mu2 * mu2;
        let lambda = 1.0 / mu;
        let w = lambda * t * (1.0 + mu);
        let a = 4.0 * w * (1.0 + mu2 + mu4);
        let excess = w * w * (2.0 + mu2);
        let pressure = self.k * alpha + a * (self.c1 + 2.0 * self.c2 * excess);
        if !SLOPE {
            return (pressure, 0.0);
        }
        let a_slope = 4.0 + 20.0 * mu4 * mu2;
        let stretch_slope = self.c1 * a_slope + 2.0 * self.c2 * (a_slope * excess + a * a);
        (pressure, self.k + lambda * lambda * t_slope * stretch_slope)
    }

    /// √(k² + 16 c1 P) − k without cancellation; zero for P = 0.
    pub(super) fn s(&self, pressure: f64) -> f64 {
        let rise = 16.0 * self.c1 * pressure;
        let root = libm::sqrt(self.k * self.k + rise);
        if root > 0.0 { rise / (root + self.k) } else { 0.0 }
    }

    /// The bend in degrees at a pressure in kPa, and not above `limit_deg`. The other methods' tables go a little beyond
    /// the domain's ends with it, so that their last interval is as good as the others.
    pub(super) fn solve(&self, pressure: f64, limit_deg: f64) -> f64 {
        if pressure <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high) = (0.0, limit_deg.to_radians());
        let mut alpha = within(self.nodes.start_deg(self.s(pressure)).to_radians(), low, high);
        for _ in 0..MOST_STEPS {
            let (here, slope) = self.pressure_and_slope::<true>(alpha);
            if here < pressure {
                low = alpha;
            } else {
                high = alpha;
            }
            let next = within(alpha - (here - pressure) / slope, low, high);
            let step = (next - alpha).abs();
            alpha = next;
            if step <= LAST_STEP * alpha {
                break;
            }
        }
        alpha.to_degrees()
    }

    /// dα/dP in degrees per kPa at a bend in degrees: infinite at zero without stiffness.
    pub(super) fn slope_deg_per_kpa(&self, bend_deg: f64) -> f64 {
        1.0 / self.slope_kpa_per_deg(bend_deg)
    }

    /// dP/dα in kPa per degree at a bend in degrees.
    pub(super) fn slope_kpa_per_deg(&self, bend_deg: f64) -> f64 {
        self.pressure_and_slope::<true>(bend_deg.to_radians()).1.to_radians()
    }
}

impl Method for F64Newton {
    const NAME: &'static str = "f64-newton";
    const SUMMARY: &'static str = "f64, libm's sine and cosine, Newton to convergence";
    type Pressure = f64;
    type Bend = f64;

    fn prepare(coefficients: &Coefficients) -> Self {
        let [k, c1, c2] = coefficients_kpa(coefficients);
        let mut method = Self { k, c1, c2, nodes: Nodes::<f64>::new(|_| 0.0) };
        method.nodes = Nodes::<f64>::new(|bend| method.s(method.pressure_from_bend(bend)));
        method
    }

    fn bend_from_pressure(&self, pressure: f64) -> f64 {
        self.solve(within(pressure, 0.0, PRESSURE_LIMIT_KPA), BEND_LIMIT_DEG)
    }

    fn pressure_from_bend(&self, bend: f64) -> f64 {
        // At 0 every term is 0.
        self.pressure_and_slope::<false>(within(bend, 0.0, BEND_LIMIT_DEG).to_radians()).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{Limits, check, check_float_edges};

    #[test]
    fn errors_against_f64() {
        check::<F64Newton>(&[Limits { bend_deg: 1e-12, pressure_kpa: 3e-12 }; 3]);
        check_float_edges::<F64Newton>();
    }
}
