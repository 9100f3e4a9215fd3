//! The default calibration and, on the host, the fit it comes from.
//!
//! The model `P(α) = k·α + c1·A(α) + c2·B(α)` is fitted in the least-squares sense of **bend**: the sum of the squared
//! differences in degrees between the model's bend at each pressure and the measured one is the smallest that k, c1
//! and c2, none of them negative, can give. Bend is what the table measured and what the finger is asked for; a fit in
//! relative pressure would weight the 30 kPa point most and leave up to 1.7 % of pressure at 90 kPa.
//!
//! `cargo test -p model-core calibration -- --nocapture` prints the fits of all three rows of the paper's Table 2.

use crate::units::Coefficients;
use fixed::types::I8F24;

/// The paper's chamber with exoskeleton (Table 2), as `fit` gives it.
pub const DEFAULT: Coefficients =
    match Coefficients::new(I8F24::lit("0"), I8F24::lit("13.835501"), I8F24::lit("0.335610")) {
        Ok(coefficients) => coefficients,
        Err(_) => panic!("the default calibration lies outside the admitted range"),
    };

#[cfg(any(test, feature = "host"))]
pub use host::{Fit, FitError, basis, bend_deg, fit, pressure_kpa, solve};

#[cfg(any(test, feature = "host"))]
mod host {
    use core::fmt;
    use nalgebra::{DMatrix, DVector};

    /// The largest bend of the model's domain, in degrees.
    const MAX_DEG: f64 = 170.0;
    /// The coefficients that are not zero, by index: every choice that the constraint k, c1, c2 >= 0 can leave.
    const ACTIVE_SETS: [&[usize]; 7] = [&[0], &[1], &[2], &[0, 1], &[0, 2], &[1, 2], &[0, 1, 2]];
    /// Coefficients to be found, and so the fewest points that determine them.
    const UNKNOWNS: usize = 3;
    const MAX_ITERATIONS: usize = 100;

    /// What [`fit`] found.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Fit {
        /// k, c1, c2 in kPa.
        pub coefficients_kpa: [f64; 3],
        /// The model's pressure at each measured bend, less the measured pressure.
        pub residuals_kpa: Vec<f64>,
        /// The model's bend at each measured pressure, less the measured bend.
        pub residuals_deg: Vec<f64>,
        /// The largest bend residual in proportion to the measured bend.
        pub worst_relative_error: f64,
        /// For each point, the bend that a fit to the others predicts at its pressure, less the measured one. Empty
        /// when the others would not determine the coefficients.
        pub leave_one_out_deg: Vec<f64>,
    }

    /// Why [`fit`] found nothing.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum FitError {
        /// Fewer than three different bends: this many.
        TooFewPoints(usize),
        /// A pressure that is not finite or not above zero.
        Pressure(f64),
        /// A bend that is not finite or not between 0 and 170 degrees.
        Bend(f64),
        /// The iteration did not settle: the points are nothing like the model.
        NoConvergence,
    }

    impl fmt::Display for FitError {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            match self {
                Self::TooFewPoints(n) => write!(f, "a calibration needs three different bends, there are {n}"),
                Self::Pressure(p) => write!(f, "{p} kPa: pressures must be finite and above zero"),
                Self::Bend(a) => write!(f, "{a} degrees: bends must lie between 0 and {MAX_DEG} degrees"),
                Self::NoConvergence => write!(f, "the fit does not settle: check the points"),
            }
        }
    }

    impl core::error::Error for FitError {}

    /// α, A and B at a bend in degrees: the pressure per unit of k, c1 and c2.
    #[must_use]
    pub fn basis(deg: f64) -> [f64; 3] {
        basis_and_slope(deg).0
    }

    /// The basis and its derivative by α in radians.
    fn basis_and_slope(deg: f64) -> ([f64; 3], [f64; 3]) {
        let alpha = deg.to_radians();
        if alpha == 0.0 {
            return ([0.0; 3], [1.0, 0.0, 0.0]);
        }
        let (sin, cos) = alpha.sin_cos();
        let lambda = alpha / sin;
        let lambda_slope = (sin - alpha * cos) / (sin * sin);
        let a = 4.0 * (lambda - lambda.powi(-5));
        let strain = 2.0 * lambda * lambda + lambda.powi(-4) - 3.0;
        let a_by_lambda = 4.0 + 20.0 * lambda.powi(-6);
        let b_by_lambda = 2.0 * (a_by_lambda * strain + a * a);
        ([alpha, a, 2.0 * a * strain], [1.0, a_by_lambda * lambda_slope, b_by_lambda * lambda_slope])
    }

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a.iter().zip(b).map(|(x, y)| x * y).sum()
    }

    /// The model's pressure in kPa at a bend in degrees.
    #[must_use]
    pub fn pressure_kpa(coefficients_kpa: [f64; 3], deg: f64) -> f64 {
        dot(coefficients_kpa, basis(deg))
    }

    /// The model's bend in degrees at a pressure in kPa, by bisection of 0..170 degrees.
    #[must_use]
    pub fn bend_deg(coefficients_kpa: [f64; 3], kpa: f64) -> f64 {
        let (mut low, mut high) = (0.0, MAX_DEG);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if pressure_kpa(coefficients_kpa, middle) < kpa { low = middle } else { high = middle }
        }
        f64::midpoint(low, high)
    }

    /// Fits k, c1 and c2 to points (kPa, degrees of one segment).
    ///
    /// # Errors
    /// See [`FitError`]; the offending value is named.
    pub fn fit(points: &[(f64, f64)]) -> Result<Fit, FitError> {
        let coefficients_kpa = solve(points)?;
        let residuals_deg: Vec<f64> = points.iter().map(|&(p, deg)| bend_deg(coefficients_kpa, p) - deg).collect();
        let leave_one_out: Result<Vec<f64>, FitError> = (0..points.len())
            .map(|out| {
                let others: Vec<_> =
                    points.iter().enumerate().filter(|&(i, _)| i != out).map(|(_, &point)| point).collect();
                let (p, deg) = points[out];
                solve(&others).map(|found| bend_deg(found, p) - deg)
            })
            .collect();
        Ok(Fit {
            coefficients_kpa,
            residuals_kpa: points.iter().map(|&(p, deg)| pressure_kpa(coefficients_kpa, deg) - p).collect(),
            worst_relative_error: points
                .iter()
                .zip(&residuals_deg)
                .map(|((_, a), r)| (r / a).abs())
                .fold(0.0, f64::max),
            residuals_deg,
            leave_one_out_deg: match leave_one_out {
                Ok(differences) => differences,
                Err(FitError::TooFewPoints(_)) => Vec::new(),
                Err(error) => return Err(error),
            },
        })
    }

    /// The coefficients of [`fit`] alone, k, c1, c2 in kPa: Gauss-Newton in bend, each step a constrained linear
    /// least-squares problem.
    ///
    /// # Errors
    /// As [`fit`].
    pub fn solve(points: &[(f64, f64)]) -> Result<[f64; 3], FitError> {
        for &(p, deg) in points {
            if !p.is_finite() || p <= 0.0 {
                return Err(FitError::Pressure(p));
            }
            if !(deg > 0.0 && deg < MAX_DEG) {
                return Err(FitError::Bend(deg));
            }
        }
        let mut bends: Vec<f64> = points.iter().map(|&(_, deg)| deg).collect();
        bends.sort_by(f64::total_cmp);
        bends.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        if bends.len() < UNKNOWNS {
            return Err(FitError::TooFewPoints(bends.len()));
        }
        // Start: least squares of relative pressure, which is linear.
        let rows: Vec<_> = points.iter().map(|&(p, deg)| (basis(deg).map(|b| b / p), 1.0)).collect();
        let mut found = non_negative(&rows).ok_or(FitError::NoConvergence)?;
        for _ in 0..MAX_ITERATIONS {
            // With α the model's bend at P and α' the measured one: P + P'(α)·(α - α') = basis(α)·c, over P'(α).
            let rows: Vec<_> = points
                .iter()
                .map(|&(p, deg)| {
                    let model_deg = bend_deg(found, p);
                    let (basis, slopes) = basis_and_slope(model_deg);
                    let slope = dot(found, slopes);
                    (basis.map(|b| b / slope), p / slope + (model_deg - deg).to_radians())
                })
                .collect();
            let next = non_negative(&rows).ok_or(FitError::NoConvergence)?;
            let change = next.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            found = next;
            if change < 1e-10 {
                return Ok(found);
            }
        }
        Err(FitError::NoConvergence)
    }

    /// Least squares of `row · c = value` over c >= 0: the best of all active sets whose solution is not negative.
    fn non_negative(rows: &[([f64; 3], f64)]) -> Option<[f64; 3]> {
        let values = DVector::from_iterator(rows.len(), rows.iter().map(|&(_, value)| value));
        let mut best: Option<(f64, [f64; 3])> = None;
        for set in ACTIVE_SETS {
            let matrix = DMatrix::from_fn(rows.len(), set.len(), |i, j| rows[i].0[set[j]]);
            if matrix.iter().chain(values.iter()).any(|x| !x.is_finite()) {
                return None;
            }
            let Ok(solution) = matrix.clone().svd(true, true).solve(&values, 1e-12) else { continue };
            let cost = (&matrix * &solution - &values).norm_squared();
            if solution.iter().all(|&c| c >= 0.0) && best.is_none_or(|(least, _)| cost < least) {
                let mut coefficients = [0.0; 3];
                for (&index, &value) in set.iter().zip(solution.iter()) {
                    coefficients[index] = value;
                }
                best = Some((cost, coefficients));
            }
        }
        best.map(|(_, coefficients)| coefficients)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper;

    fn table_2(deg: &[f64; 5], segments: f64) -> Vec<(f64, f64)> {
        paper::PRESSURE_KPA.iter().zip(deg).map(|(&p, &a)| (p, a / segments)).collect()
    }

    #[test]
    fn default_is_the_fit_to_the_chamber_with_exoskeleton() {
        let found = fit(&table_2(&paper::CHAMBER_EXO_DEG, 1.0)).unwrap();
        for (default, fitted) in DEFAULT.to_f64_kpa().into_iter().zip(found.coefficients_kpa) {
            assert!((default - fitted).abs() < 1e-4, "DEFAULT has {default} kPa, the fit gives {fitted} kPa");
        }
    }

    #[test]
    fn every_row_of_table_2_is_met_within_one_percent() {
        let rows = [
            ("chamber with exoskeleton", table_2(&paper::CHAMBER_EXO_DEG, 1.0), [0.0, 13.84, 0.336], 0.0081),
            ("finger / 3", table_2(&paper::FINGER_DEG, paper::CHAMBERS), [0.0, 13.79, 0.323], 0.0059),
            ("bare chamber", table_2(&paper::CHAMBER_BARE_DEG, 1.0), [35.3, 7.24, 0.831], 0.0047),
        ];
        for (name, points, design, worst) in rows {
            let found = fit(&points).unwrap();
            let [k, c1, c2] = found.coefficients_kpa;
            println!(
                "{name}: k {k:.7}, c1 {c1:.7}, c2 {c2:.7} kPa; worst {:.2} % of bend",
                found.worst_relative_error * 1e2
            );
            println!("  pressure residuals, kPa: {:.2?}", found.residuals_kpa);
            println!(
                "  bend residuals, degrees: {:.2?}; each left out: {:.2?}",
                found.residuals_deg, found.leave_one_out_deg
            );
            assert!(found.worst_relative_error <= 0.01, "{name}: {}", found.worst_relative_error);
            assert!((found.worst_relative_error - worst).abs() < 1e-4, "{name}: {}", found.worst_relative_error);
            assert!(found.leave_one_out_deg.iter().all(|d| d.abs() < 1.6), "{name}: {:?}", found.leave_one_out_deg);
            assert_eq!(found.leave_one_out_deg.len(), points.len());
            for (coefficient, expected) in found.coefficients_kpa.into_iter().zip(design) {
                assert!((coefficient - expected).abs() <= 0.006 * expected, "{name}: {coefficient}, not {expected}");
            }
        }
    }

    #[test]
    fn points_of_the_model_itself_give_its_coefficients_back() {
        for coefficients in [[0.0, 13.84, 0.336], [35.3, 7.24, 0.831], [12.0, 20.0, 0.0], [5.0, 6.0, 1.9]] {
            let points: Vec<_> =
                [20.0, 45.0, 70.0, 95.0, 120.0].into_iter().map(|deg| (pressure_kpa(coefficients, deg), deg)).collect();
            let found = fit(&points).unwrap();
            for (a, b) in found.coefficients_kpa.into_iter().zip(coefficients) {
                assert!((a - b).abs() < 1e-6, "{found:?}");
            }
            assert!(found.leave_one_out_deg.iter().all(|d| d.abs() < 1e-6), "{found:?}");
        }
    }

    #[test]
    fn no_small_change_of_the_coefficients_is_better() {
        let points = table_2(&paper::CHAMBER_BARE_DEG, 1.0);
        let best = fit(&points).unwrap().coefficients_kpa;
        let cost = |c| points.iter().map(|&(p, deg)| (bend_deg(c, p) - deg).powi(2)).sum::<f64>();
        for (index, change) in [(0, 0.01), (1, 0.01), (2, 0.001)] {
            for sign in [-1.0, 1.0] {
                let mut other = best;
                other[index] += sign * change;
                assert!(cost(other) > cost(best), "{other:?} is better than {best:?}");
            }
        }
    }

    #[test]
    fn bad_points_are_named() {
        let good = table_2(&paper::CHAMBER_EXO_DEG, 1.0);
        let with = |point| fit(&[good.clone(), vec![point]].concat());
        assert_eq!(fit(&good[..2]), Err(FitError::TooFewPoints(2)));
        assert_eq!(fit(&[good[0]; 5]), Err(FitError::TooFewPoints(1)));
        assert_eq!(fit(&[]), Err(FitError::TooFewPoints(0)));
        assert_eq!(with((0.0, 20.0)), Err(FitError::Pressure(0.0)));
        assert_eq!(with((f64::INFINITY, 20.0)), Err(FitError::Pressure(f64::INFINITY)));
        assert!(matches!(with((f64::NAN, 20.0)), Err(FitError::Pressure(p)) if p.is_nan()));
        assert_eq!(with((20.0, 0.0)), Err(FitError::Bend(0.0)));
        assert_eq!(with((20.0, 170.0)), Err(FitError::Bend(170.0)));
        assert!(matches!(with((20.0, f64::NAN)), Err(FitError::Bend(a)) if a.is_nan()));
        assert!(FitError::Pressure(-3.0).to_string().contains("-3 kPa"));
        assert_eq!(fit(&good[..3]).unwrap().leave_one_out_deg, Vec::<f64>::new());
    }
}
