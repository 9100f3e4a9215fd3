//! Integrators of the gas: how the contents of the four volumes follow their rates over one step.
//!
//! Every method adds a weighted sum of rates, or solves a linear system whose columns sum to the same: air that leaves
//! one volume arrives in another, so the sum of the contents changes by what passes pump, dump valve and leaks, to
//! rounding.

use super::network::{Contents, Factored, Network};
use serde::{Deserialize, Serialize};

/// How the gas is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Explicit Euler: order 1.
    Euler,
    /// Heun's method, an explicit predictor and the mean of both ends: order 2.
    Heun,
    /// The classical explicit Runge-Kutta method: order 4 for fixed volumes.
    RungeKutta4,
    /// Linearly implicit Euler: order 1, stable at any stiffness (L-stable).
    RosenbrockEuler,
    /// Linearly implicit midpoint rule: one evaluation, order 2, stable at any stiffness (A-stable). Where a volume settles so
    /// fast that it would swing, and while a leak is open, a step of [`Method::Rosenbrock2`] is taken instead.
    LinearlyImplicitMidpoint,
    /// Two-stage Rosenbrock method ROS2 with gamma = 1 - 1/sqrt(2), and 1 + 1/sqrt(2) where that is too fast to be followed:
    /// order 2, L-stable. Source: Verwer, Spee, Blom,
    /// Hundsdorfer, A second-order Rosenbrock method applied to photochemical dispersion problems (SIAM J. Sci. Comput. 20,
    /// 1999).
    Rosenbrock2,
    /// The explicit pair of Bogacki and Shampine, orders 3 and 2, that halves and doubles its step so that its estimate
    /// of a step's error stays below the tolerance.
    Adaptive {
        /// Largest error of a step in any pressure, kPa, above 0.
        tolerance_kpa: f64,
    },
}

impl Method {
    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Euler => "Euler",
            Self::Heun => "Heun",
            Self::RungeKutta4 => "Runge-Kutta 4",
            Self::RosenbrockEuler => "Rosenbrock-Euler",
            Self::LinearlyImplicitMidpoint => "implicit midpoint",
            Self::Rosenbrock2 => "ROS2",
            Self::Adaptive { .. } => "Bogacki-Shampine 3(2)",
        }
    }
}

/// Where a step ends, and how far off its own estimate puts it.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Contents at its end, NL.
    pub contents: Contents,
    /// Evaluations of the flows that it took.
    pub evaluations: u32,
    /// Largest estimated error of a pressure, kPa; 0 where the method has no estimate.
    pub error_kpa: f64,
}

#[inline]
fn plus(contents: &Contents, weighted: &[(f64, &Contents)]) -> Contents {
    core::array::from_fn(|i| weighted.iter().fold(contents[i], |sum, (weight, rates)| sum + weight * rates[i]))
}

/// One step of `seconds` from `contents`.
#[inline]
#[must_use]
pub fn step(method: Method, network: &Network<'_>, contents: &Contents, seconds: f64) -> Step {
    let (contents, evaluations) = match method {
        Method::Euler => (plus(contents, &[(seconds, &network.rates(contents))]), 1),
        Method::Heun => {
            let start = network.rates(contents);
            let end = network.rates(&plus(contents, &[(seconds, &start)]));
            (plus(contents, &[(0.5 * seconds, &start), (0.5 * seconds, &end)]), 2)
        }
        Method::RungeKutta4 => {
            let half = 0.5 * seconds;
            let start = network.rates(contents);
            let early = network.rates(&plus(contents, &[(half, &start)]));
            let late = network.rates(&plus(contents, &[(half, &early)]));
            let end = network.rates(&plus(contents, &[(seconds, &late)]));
            let (outer, inner) = (seconds / 6.0, seconds / 3.0);
            (plus(contents, &[(outer, &start), (inner, &early), (inner, &late), (outer, &end)]), 4)
        }
        Method::RosenbrockEuler => {
            let (rates, jacobian) = network.rates_and_jacobian(contents);
            (plus(contents, &[(seconds, &Factored::new(&jacobian, seconds).solve(&rates))]), 1)
        }
        Method::LinearlyImplicitMidpoint => match network.midpoint_change(contents, seconds) {
            Some(change) => (plus(contents, &[(1.0, &change)]), 1),
            None => (rosenbrock_2(network, contents, seconds), 3),
        },
        Method::Rosenbrock2 => (rosenbrock_2(network, contents, seconds), 2),
        Method::Adaptive { .. } => return bogacki_shampine(network, contents, seconds),
    };
    Step { contents, evaluations, error_kpa: 0.0 }
}

/// `(1 - gamma h J) k1 = f(y)`, `(1 - gamma h J) k2 = f(y + h k1) - 2 k1`, `y + h (3 k1 + k2) / 2`.
///
/// The order is 2 for any gamma; both roots of `gamma^2 - 2 gamma + 1/2` make it L-stable. The small one errs less, but where a
/// volume settles faster than `1/(1 - 2 gamma)` steps a step swings past the end; the large one never does, nor does its
/// first stage.
#[inline]
fn rosenbrock_2(network: &Network<'_>, contents: &Contents, seconds: f64) -> Contents {
    const SMALL: f64 = 1.0 - core::f64::consts::FRAC_1_SQRT_2;
    const LARGE: f64 = 1.0 + core::f64::consts::FRAC_1_SQRT_2;
    let (rates, jacobian) = network.rates_and_jacobian(contents);
    let swings = seconds * jacobian.fastest_per_s() > 1.0 / (1.0 - 2.0 * SMALL);
    let factored = Factored::new(&jacobian, if swings { LARGE } else { SMALL } * seconds);
    let first = factored.solve(&rates);
    let end = network.rates(&plus(contents, &[(seconds, &first)]));
    let second = factored.solve(&plus(&end, &[(-2.0, &first)]));
    plus(contents, &[(1.5 * seconds, &first), (0.5 * seconds, &second)])
}

/// Source: Bogacki, Shampine, A 3(2) pair of Runge-Kutta formulas (Appl. Math. Lett. 2, 1989).
#[inline]
fn bogacki_shampine(network: &Network<'_>, contents: &Contents, seconds: f64) -> Step {
    let k1 = network.rates(contents);
    let k2 = network.rates(&plus(contents, &[(seconds / 2.0, &k1)]));
    let k3 = network.rates(&plus(contents, &[(seconds * 0.75, &k2)]));
    let end = plus(contents, &[(seconds * 2.0 / 9.0, &k1), (seconds / 3.0, &k2), (seconds * 4.0 / 9.0, &k3)]);
    let k4 = network.rates(&end);
    let error: Contents = core::array::from_fn(|i| {
        seconds * (-5.0 / 72.0 * k1[i] + k2[i] / 12.0 + k3[i] / 9.0 - k4[i] / 8.0) * network.kpa_per_nl[i]
    });
    Step {
        contents: end,
        evaluations: 4,
        error_kpa: error.into_iter().fold(0.0, |worst, error| worst.max(error.abs())),
    }
}
