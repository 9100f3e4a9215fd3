//! The fit with what it is worth: confidence intervals, scatter, what sticks out.
//!
//! The coefficients are those of [`solve`]: least squares of the bend, none below zero. The model of the
//! errors: each measured bend is the curve's plus an error of one spread, independent from point to point.
//!
//! With J the derivatives of the bends by k, c1, c2 at the fit, r the residuals (measured less
//! curve), n points:
//!
//! - Without the bounds at zero the fit would lie at c + Δ, Δ = (JᵀJ)⁻¹ Jᵀ r, one Gauss-Newton step; what is then left
//!   of the residuals, e, has variance s² = Σ e² / (n − 3).
//! - The interval of a coefficient is that point ± t · s · √(JᵀJ)⁻¹ᵢᵢ, t the 97.5 % point of Student's distribution with
//!   n − 3 degrees of freedom, cut at zero, and widened to the estimate where that is outside. The bounds are left out
//!   because an interval that knows them is too narrow when a coefficient rests at one; cutting afterwards costs no coverage.
//! - The curve's own interval is ± t · s · √(g (JᵀJ)⁻¹ gᵀ), g the derivatives of the bend at a pressure.
//!
//! The derivative of the bend by a coefficient is −(its function of α) / (dP/dα): the pressure is linear in them.

use super::measurement::{EMPTY_KPA, Measurement};
use anyhow::{Context, Result};
use model_core::calibration::{basis, bend_deg, pressure_kpa, solve};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};

/// Coefficients that are looked for.
pub const UNKNOWNS: usize = 3;
/// Points closer than this belong to one level, kPa.
const LEVEL_KPA: f64 = 5.0;
/// The chance that any point at all of a sound file is called an outlier.
const OUTLIER_CHANCE: f64 = 0.01;

/// One fitted point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Where it stands: `line 17`, or the time in a recording.
    pub place: String,
    /// Number of the run.
    pub repeat: Option<u32>,
    /// Gauge pressure, kPa.
    pub pressure_kpa: f64,
    /// Measured bend of one segment, degrees.
    pub bend_deg: f64,
    /// Measured bend less the curve's, degrees.
    pub residual_deg: f64,
    /// It is not one of the others' kind.
    pub outlier: bool,
}

/// Points of about one pressure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Level {
    /// Their mean pressure, kPa.
    pub pressure_kpa: f64,
    /// How many.
    pub points: usize,
    /// Mean of their bends, degrees.
    pub bend_deg: f64,
    /// Mean of their residuals, degrees.
    pub residual_deg: f64,
}

/// Whether the levels' means lie on the curve as closely as their scatter lets expect (F test).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LackOfFit {
    /// Mean square of the levels' distance from the curve over mean square of the scatter within levels.
    pub f: f64,
    /// Chance of such an F or more if the curve is right.
    pub chance: f64,
}

/// What a set of measurements says of one scope.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// `all`, `proximal`, `middle` or `distal`.
    pub segment: &'static str,
    /// k, c1, c2, kPa.
    pub coefficients_kpa: [f64; 3],
    /// k, c1, c2 without the bounds at zero, kPa.
    pub unbounded_kpa: [f64; 3],
    /// Their 95 % confidence intervals, kPa; nothing when there are no more points than coefficients.
    pub ci95_kpa: Option<[[f64; 2]; 3]>,
    /// Correlation of the errors of k and c1: near −1, they nearly share their effect.
    pub correlation_k_c1: Option<f64>,
    /// Half the width of the widest 95 % interval of the curve over the measured pressures, degrees.
    pub curve_ci95_deg: Option<f64>,
    /// Points fitted.
    pub points: Vec<Point>,
    /// The same by pressure.
    pub levels: Vec<Level>,
    /// Root mean square of the residuals, degrees.
    pub residual_rms_deg: f64,
    /// Standard deviation s of the errors, degrees.
    pub scatter_deg: Option<f64>,
    /// The F test, where levels have repeats and there are more than three of them.
    pub lack_of_fit: Option<LackOfFit>,
    /// Chance of the residuals' trend from repeat to repeat if there is none; where repeats are numbered.
    pub drift_chance: Option<f64>,
    /// The coefficients without the outliers, kPa, where there are any.
    pub without_outliers_kpa: Option<[f64; 3]>,
    /// Bends measured on the empty segment, farthest from zero first: place and degrees.
    pub empty: Vec<(String, f64)>,
    /// (JᵀJ)⁻¹ s², kPa².
    #[serde(skip)]
    covariance: Option<Matrix3<f64>>,
}

/// Derivatives of the bend by k, c1, c2 at a pressure, degrees per kPa.
fn gradient(coefficients_kpa: [f64; 3], kpa: f64) -> Vector3<f64> {
    const STEP_DEG: f64 = 1e-4;
    let deg = bend_deg(coefficients_kpa, kpa);
    let across = pressure_kpa(coefficients_kpa, deg + STEP_DEG) - pressure_kpa(coefficients_kpa, deg - STEP_DEG);
    -Vector3::from(basis(deg)) * (2.0 * STEP_DEG / across)
}

/// The fit's neighbourhood, in which bends are linear in the coefficients.
struct Linearised {
    /// Derivatives, a row a point.
    jacobian: DMatrix<f64>,
    inverse: Matrix3<f64>,
    /// To the unbounded fit.
    step: Vector3<f64>,
    /// Residuals (measured less curve) there.
    left: DVector<f64>,
}

impl Linearised {
    /// Nothing when the points do not determine the coefficients.
    fn at(coefficients_kpa: [f64; 3], points: &[(f64, f64)]) -> Option<Self> {
        let gradients: Vec<Vector3<f64>> = points.iter().map(|&(kpa, _)| gradient(coefficients_kpa, kpa)).collect();
        let jacobian = DMatrix::from_fn(points.len(), UNKNOWNS, |row, column| gradients[row][column]);
        let residuals = DVector::from_iterator(
            points.len(),
            points.iter().map(|&(kpa, deg)| deg - bend_deg(coefficients_kpa, kpa)),
        );
        // Scaled to columns of length one: k, c1 and c2 differ by orders of magnitude in effect.
        let scales: Vector3<f64> = Vector3::from_fn(|column, _| jacobian.column(column).norm());
        let normal = Matrix3::from_fn(|a, b| jacobian.column(a).dot(&jacobian.column(b)) / (scales[a] * scales[b]));
        let singular = normal.svd(false, false).singular_values;
        // Below this the rounding of the pressures' last digit decides.
        let (least, most) = (singular.min(), singular.max());
        if least.is_nan() || least <= 1e-9 * most {
            return None;
        }
        let scaled = normal.try_inverse()?;
        let inverse = Matrix3::from_fn(|a, b| scaled[(a, b)] / (scales[a] * scales[b]));
        let moved = jacobian.transpose() * &residuals;
        let step = inverse * Vector3::new(moved[0], moved[1], moved[2]);
        let left = residuals - &jacobian * DVector::from_iterator(UNKNOWNS, step.iter().copied());
        Some(Self { jacobian, inverse, step, left })
    }

    /// s², degrees²; nothing when no degree of freedom is left.
    fn variance(&self) -> Option<f64> {
        let freedom = self.left.len().checked_sub(UNKNOWNS).filter(|&freedom| freedom > 0)?;
        Some(self.left.norm_squared() / freedom as f64)
    }

    /// How much the curve follows a point: its diagonal element of J (JᵀJ)⁻¹ Jᵀ.
    fn leverage(&self, row: usize) -> f64 {
        let row = Vector3::from_fn(|column, _| self.jacobian[(row, column)]);
        row.dot(&(self.inverse * row)).min(1.0)
    }
}

/// Student's two-sided limit for a chance outside.
fn student(outside: f64, freedom: usize) -> Option<f64> {
    Some(StudentsT::new(0.0, 1.0, freedom as f64).ok()?.inverse_cdf(1.0 - outside / 2.0))
}

/// Chance of a trend of the values by their order, two-sided, from the correlation coefficient.
fn trend_chance(pairs: &[(f64, f64)]) -> Option<f64> {
    let freedom = pairs.len().checked_sub(2).filter(|&freedom| freedom > 0)? as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
    let (x, y) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|&(a, b)| of(a - x, b - y)).sum::<f64>();
    let (xx, xy, yy) = (sum(&|a, _| a * a), sum(&|a, b| a * b), sum(&|_, b| b * b));
    if xx <= 0.0 || yy <= 0.0 {
        return None;
    }
    let r2 = (xy * xy / (xx * yy)).min(1.0 - 1e-12);
    let t = (r2 * freedom / (1.0 - r2)).sqrt();
    Some(2.0 * StudentsT::new(0.0, 1.0, freedom).ok()?.sf(t))
}

/// Numbers of the points that are not of the others' kind, the farthest first: as long as the largest deletion residual is
/// beyond Student's limit for [`OUTLIER_CHANCE`] shared by all points, that point is taken out and the rest looked at anew.
fn outliers(points: &[(f64, f64)]) -> Vec<usize> {
    let mut found = Vec::new();
    let mut rest: Vec<usize> = (0..points.len()).collect();
    // More than a fifth is no longer a matter of single points.
    while found.len() < points.len() / 5 {
        let kept: Vec<(f64, f64)> = rest.iter().map(|&index| points[index]).collect();
        let Some(freedom) = kept.len().checked_sub(UNKNOWNS + 1).filter(|&freedom| freedom > 0) else { break };
        let Some(linear) = solve(&kept).ok().and_then(|c| Linearised::at(c, &kept)) else { break };
        let total = linear.left.norm_squared();
        let deleted = |row: usize| {
            let own = linear.left[row] * linear.left[row] / (1.0 - linear.leverage(row)).max(1e-12);
            let others = ((total - own) / freedom as f64).max(f64::MIN_POSITIVE);
            (own / others).sqrt()
        };
        let Some((row, largest)) = (0..kept.len()).map(|row| (row, deleted(row))).max_by(|a, b| a.1.total_cmp(&b.1))
        else {
            break;
        };
        match student(OUTLIER_CHANCE / kept.len() as f64, freedom) {
            Some(limit) if largest > limit => found.push(rest.remove(row)),
            _ => break,
        }
    }
    found
}

/// Groups of about one pressure, by rising pressure, as numbers of points.
fn levels_of(points: &[(f64, f64)]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0));
    let mut levels: Vec<Vec<usize>> = Vec::new();
    for index in order {
        match levels.last_mut() {
            Some(level) if points[index].0 - points[level[0]].0 <= LEVEL_KPA => level.push(index),
            _ => levels.push(vec![index]),
        }
    }
    levels
}

fn mean(level: &[usize], of: impl Fn(usize) -> f64) -> f64 {
    level.iter().map(|&index| of(index)).sum::<f64>() / level.len() as f64
}

fn lack_of_fit(left: &DVector<f64>, levels: &[Vec<usize>]) -> Option<LackOfFit> {
    let between = levels.len().checked_sub(UNKNOWNS).filter(|&freedom| freedom > 0)?;
    let within = left.len().checked_sub(levels.len()).filter(|&freedom| freedom > 0)?;
    let pure: f64 = levels
        .iter()
        .map(|level| {
            let middle = mean(level, |index| left[index]);
            level.iter().map(|&index| (left[index] - middle).powi(2)).sum::<f64>()
        })
        .sum();
    let lack = (left.norm_squared() - pure).max(0.0) / between as f64;
    let f = lack / (pure / within as f64).max(1e-12);
    let chance = FisherSnedecor::new(between as f64, within as f64).ok()?.sf(f);
    Some(LackOfFit { f, chance })
}

/// Fits the measurements of one scope.
///
/// # Errors
/// When they do not determine the coefficients, or are nothing like the model.
pub fn estimate(segment: &'static str, measurements: &[Measurement]) -> Result<Estimate> {
    let (empty, filled): (Vec<Measurement>, Vec<Measurement>) =
        measurements.iter().partition(|m| m.pressure_kpa < EMPTY_KPA);
    let points: Vec<(f64, f64)> = filled.iter().map(|m| (m.pressure_kpa, m.bend_deg)).collect();
    let coefficients_kpa = solve(&points).with_context(|| format!("segment {segment}"))?;
    let linear = Linearised::at(coefficients_kpa, &points);
    let unbounded_kpa = linear
        .as_ref()
        .map_or(coefficients_kpa, |linear| core::array::from_fn(|index| coefficients_kpa[index] + linear.step[index]));
    let covariance = linear.as_ref().and_then(|linear| Some(linear.inverse * linear.variance()?));
    let limit = points.len().checked_sub(UNKNOWNS).filter(|&freedom| freedom > 0).and_then(|f| student(0.05, f));
    let spread = covariance.zip(limit);
    let interval = |(covariance, limit): (Matrix3<f64>, f64)| {
        core::array::from_fn(|index| {
            let half = limit * covariance[(index, index)].sqrt();
            let [low, high] = [-half, half].map(|side| (unbounded_kpa[index] + side).max(0.0));
            [low.min(coefficients_kpa[index]), high.max(coefficients_kpa[index])]
        })
    };
    let residual_deg = |index: usize| points[index].1 - bend_deg(coefficients_kpa, points[index].0);
    let out = outliers(&points);
    let levels = levels_of(&points);
    let sound: Vec<(f64, f64)> = (0..points.len()).filter(|index| !out.contains(index)).map(|i| points[i]).collect();
    let trend: Vec<(f64, f64)> =
        (0..points.len()).filter_map(|index| Some((f64::from(filled[index].repeat?), residual_deg(index)))).collect();
    let mut empty: Vec<(String, f64)> = empty.iter().map(|m| (m.place.to_string(), m.bend_deg)).collect();
    empty.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let square = (0..points.len()).map(|index| residual_deg(index).powi(2)).sum::<f64>();
    let mut estimate = Estimate {
        segment,
        coefficients_kpa,
        unbounded_kpa,
        ci95_kpa: spread.map(interval),
        correlation_k_c1: covariance.map(|c| c[(0, 1)] / (c[(0, 0)] * c[(1, 1)]).sqrt()).filter(|r| r.is_finite()),
        curve_ci95_deg: None,
        points: filled
            .iter()
            .enumerate()
            .map(|(index, m)| Point {
                place: m.place.to_string(),
                repeat: m.repeat,
                pressure_kpa: m.pressure_kpa,
                bend_deg: m.bend_deg,
                residual_deg: residual_deg(index),
                outlier: out.contains(&index),
            })
            .collect(),
        residual_rms_deg: (square / points.len() as f64).sqrt(),
        scatter_deg: linear.as_ref().and_then(Linearised::variance).map(f64::sqrt),
        lack_of_fit: linear.as_ref().and_then(|linear| lack_of_fit(&linear.left, &levels)),
        levels: levels
            .iter()
            .map(|level| Level {
                pressure_kpa: mean(level, |index| points[index].0),
                points: level.len(),
                bend_deg: mean(level, |index| points[index].1),
                residual_deg: mean(level, residual_deg),
            })
            .collect(),
        drift_chance: trend_chance(&trend),
        without_outliers_kpa: if out.is_empty() { None } else { solve(&sound).ok() },
        empty,
        covariance,
    };
    estimate.curve_ci95_deg = estimate.widest_deg();
    Ok(estimate)
}

impl Estimate {
    /// Half the width of the curve's 95 % interval at a pressure, degrees.
    #[must_use]
    pub fn half_width_deg(&self, kpa: f64) -> Option<f64> {
        let limit = student(0.05, self.points.len().checked_sub(UNKNOWNS).filter(|&freedom| freedom > 0)?)?;
        let gradient = gradient(self.coefficients_kpa, kpa);
        Some(limit * gradient.dot(&(self.covariance? * gradient)).max(0.0).sqrt())
    }

    /// The lowest and the highest level's pressure, kPa.
    #[must_use]
    pub fn range_kpa(&self) -> [f64; 2] {
        let ends = [self.levels.first(), self.levels.last()];
        ends.map(|level| level.map_or(0.0, |level| level.pressure_kpa))
    }

    /// The point farthest from the curve.
    #[must_use]
    pub fn worst(&self) -> Option<&Point> {
        self.points.iter().max_by(|a, b| a.residual_deg.abs().total_cmp(&b.residual_deg.abs()))
    }

    fn widest_deg(&self) -> Option<f64> {
        const PARTS: u32 = 40;
        let [low, high] = self.range_kpa();
        (0..=PARTS)
            .map(|part| self.half_width_deg(low + (high - low) * f64::from(part) / f64::from(PARTS)))
            .try_fold(0.0, |widest, half| Some(half?.max(widest)))
    }
}

#[cfg(test)]
#[path = "estimate_tests.rs"]
mod tests;
