//! Table 3 beside the controller's driving force, and the straight line through each row.

use model_core::force::DrivingForce;
use model_core::paper;
use model_core::units::Pressure;
use serde::Serialize;

/// A force that Table 3 gives is to be met within this share of it, percent.
pub const TARGET_PERCENT: f64 = 3.0;

/// One row of Table 3.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What pushes.
    pub name: &'static str,
    /// The points from 30 kPa on; at zero both are zero.
    pub points: Vec<Point>,
    /// The largest error of the controller's function in percent of the measured force.
    pub worst_percent: f64,
    /// Whether that is within [`TARGET_PERCENT`].
    pub passed: bool,
    /// Pearson's correlation of force with pressure, zero included.
    pub correlation_r: f64,
    /// Slope of the least-squares line.
    pub slope_n_per_kpa: f64,
    /// That line at zero pressure.
    pub intercept_n: f64,
    /// The largest error of that line in percent of the measured force.
    pub line_worst_percent: f64,
    /// The paper's finite elements at 150 kPa.
    pub fem_150_n: f64,
    /// Finite elements against its own measurement, percent.
    pub fem_against_measured_percent: f64,
}

/// One measured force.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Gauge pressure.
    pub pressure_kpa: f64,
    /// Table 3.
    pub measured_n: f64,
    /// The controller's driving force.
    pub ours_n: f64,
    /// Ours less the measured one, percent of it.
    pub error_percent: f64,
    /// The least-squares line less the measured one, percent of it.
    pub line_error_percent: f64,
    /// A straight line between the neighbours less the measured one, percent of it; none at the ends.
    pub left_out_error_percent: Option<f64>,
}

/// Slope and value at zero of the least-squares line, and Pearson's correlation.
fn line(points: &[(f64, f64)]) -> [f64; 3] {
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (mean_x, mean_y) = (mean(|point| point.0), mean(|point| point.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|&(x, y)| of(x - mean_x, y - mean_y)).sum::<f64>();
    let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
    let slope = xy / xx;
    [slope, mean_y - slope * mean_x, xy / (xx * yy).sqrt()]
}

/// The rows that Table 3 has.
#[must_use]
pub fn rows() -> Vec<Row> {
    [
        ("chamber, bare", DrivingForce::CHAMBER_BARE, paper::CHAMBER_BARE_N, paper::FEM_CHAMBER_BARE_N),
        ("chamber, exoskeleton", DrivingForce::CHAMBER_EXO, paper::CHAMBER_EXO_N, paper::FEM_CHAMBER_EXO_N),
        ("finger", DrivingForce::FINGER, paper::FINGER_N, paper::FEM_FINGER_N),
    ]
    .into_iter()
    .map(|(name, force, measured, fem)| row(name, &force, &measured, fem))
    .collect()
}

fn row(name: &'static str, force: &DrivingForce, measured: &[f64; 6], fem_150_n: f64) -> Row {
    let table: Vec<(f64, f64)> = paper::FORCE_PRESSURE_KPA.into_iter().zip(*measured).collect();
    let [slope, intercept, correlation] = line(&table);
    let percent = |found: f64, measured: f64| 100.0 * (found - measured) / measured;
    let points: Vec<Point> = table
        .iter()
        .enumerate()
        .skip(1)
        .map(|(index, &(pressure_kpa, measured_n))| {
            let ours_n = force.at(Pressure::from_f64_kpa(pressure_kpa)).to_f64();
            let after = table.get(index + 1);
            Point {
                pressure_kpa,
                measured_n,
                ours_n,
                error_percent: percent(ours_n, measured_n),
                line_error_percent: percent(slope * pressure_kpa + intercept, measured_n),
                // The points are equally far apart.
                left_out_error_percent: after
                    .map(|after| percent(f64::midpoint(table[index - 1].1, after.1), measured_n)),
            }
        })
        .collect();
    let worst = |of: fn(&Point) -> f64| points.iter().map(|point| of(point).abs()).fold(0.0, f64::max);
    let worst_percent = worst(|point| point.error_percent);
    let [.., measured_150] = *measured;
    Row {
        name,
        worst_percent,
        passed: worst_percent <= TARGET_PERCENT,
        correlation_r: correlation,
        slope_n_per_kpa: slope,
        intercept_n: intercept,
        line_worst_percent: worst(|point| point.line_error_percent),
        fem_150_n,
        fem_against_measured_percent: percent(fem_150_n, measured_150),
        points,
    }
}

/// How many times the force of one chamber with exoskeleton the finger's is, measured.
#[derive(Clone, Debug, Serialize)]
pub struct Ratio {
    /// At 150 kPa: the 1.71 of Table 3's last column.
    pub at_150_kpa: f64,
    /// Of the two rows' slopes.
    pub of_slopes: f64,
}

/// Finger to chamber.
#[must_use]
pub fn ratio(chamber: &Row, finger: &Row) -> Ratio {
    let [.., finger_n] = paper::FINGER_N;
    let [.., chamber_n] = paper::CHAMBER_EXO_N;
    Ratio { at_150_kpa: finger_n / chamber_n, of_slopes: finger.slope_n_per_kpa / chamber.slope_n_per_kpa }
}
