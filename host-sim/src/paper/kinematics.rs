//! The kinematics' errors: fixed point and f32 against f64, and there and back.

use super::points;
use model_core::kinematics::{Chain, Point, bends, fingertip, micromath};
use model_core::units::{Bend, Length};
use serde::Serialize;

/// Bends of the grid, degrees, in steps of this.
const STEP_DEG: u32 = 5;
const LAST_DEG: u32 = 110;

/// Worst and mean errors over a grid of bends, the paper's finger.
#[derive(Clone, Debug, Serialize)]
pub struct Errors {
    /// Postures of the grid.
    pub postures: usize,
    /// Fixed-point fingertip against f64, micrometres.
    pub fixed_worst_um: f64,
    /// The same, mean.
    pub fixed_mean_um: f64,
    /// f32 with micromath against f64, micrometres.
    pub micromath_worst_um: f64,
    /// The same, mean.
    pub micromath_mean_um: f64,
    /// From the place of each posture back to bends, and in f64 to a place: the largest distance, micrometres.
    pub inverse_worst_um: f64,
    /// The same, mean.
    pub inverse_mean_um: f64,
    /// Places of the grid that the inverse did not find.
    pub inverse_lost: usize,
    /// Middle and largest difference between the fingertips of the arcs and of three rigid links of the same length,
    /// millimetres: what the choice of the chain decides.
    pub arcs_against_links_mean_mm: f64,
    /// The largest.
    pub arcs_against_links_worst_mm: f64,
}

/// The fingertip in f64: arcs by their radius, not by their chord as the core does.
#[must_use]
pub fn exact_mm(chain: &Chain, bends_deg: [f64; 3]) -> [f64; 2] {
    let (mut x, mut y, mut direction) = (chain.base().to_f64(), 0.0, 0.0_f64);
    for ((bend, arc), link) in bends_deg.into_iter().map(f64::to_radians).zip(chain.arcs()).zip(chain.links()) {
        let (arc, link) = (arc.to_f64(), link.to_f64());
        let after = direction + bend;
        if bend.abs() < 1e-7 {
            x += arc * direction.cos();
            y += arc * direction.sin();
        } else {
            x += arc / bend * (after.sin() - direction.sin());
            y += arc / bend * (direction.cos() - after.cos());
        }
        direction = after;
        x += link * direction.cos();
        y += link * direction.sin();
    }
    [x, y]
}

fn apart_um([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    1e3 * (a - c).hypot(b - d)
}

/// Every posture of a grid of 5 degrees over 0 to 110 in each segment.
#[must_use]
pub fn errors() -> Errors {
    let all = || (0..=LAST_DEG).step_by(STEP_DEG as usize).map(f64::from);
    let grid: Vec<[f64; 3]> = all().flat_map(|p| all().flat_map(move |m| all().map(move |d| [p, m, d]))).collect();
    let chain = Chain::PAPER;
    let mm = |value: i32| Length::from_um(1000 * value);
    // The same length in three rigid links: 130 mm as 44, 44 and 42.
    let rigid = Chain::new(Length::ZERO, [Length::ZERO; 3], [mm(44), mm(44), mm(42)]).unwrap_or(chain);
    let [mut fixed, mut float, mut back, mut readings] = [const { Vec::<f64>::new() }; 4];
    let mut lost = 0;
    for posture in &grid {
        let fixed_bends = posture.map(Bend::from_f64_deg);
        let exact = exact_mm(&chain, *posture);
        let tip = fingertip(&chain, &fixed_bends);
        fixed.push(apart_um([tip.point.x.to_f64(), tip.point.y.to_f64()], exact));
        let shown = micromath::fingertip(&chain, &fixed_bends);
        float.push(apart_um([shown.x_mm, shown.y_mm].map(f64::from), exact));
        let target = Point { x: Length::from_f64_mm(exact[0]), y: Length::from_f64_mm(exact[1]) };
        match bends(&chain, target, &[Bend::from_deg(30); 3]) {
            Ok(found) => back.push(apart_um(exact_mm(&chain, found.map(Bend::to_f64)), exact)),
            Err(_) => lost += 1,
        }
        readings.push(apart_um(exact_mm(&rigid, *posture), exact) / 1e3);
    }
    let worst = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    Errors {
        postures: grid.len(),
        fixed_worst_um: worst(&fixed),
        fixed_mean_um: mean(&fixed),
        micromath_worst_um: worst(&float),
        micromath_mean_um: mean(&float),
        inverse_worst_um: worst(&back),
        inverse_mean_um: mean(&back),
        inverse_lost: lost,
        arcs_against_links_mean_mm: mean(&readings),
        arcs_against_links_worst_mm: worst(&readings),
    }
}

/// The kinematics beside the points that the paper gives.
#[derive(Clone, Debug, Serialize)]
pub struct Kinematics {
    /// The core's errors.
    pub errors: Errors,
    /// What the points say by themselves.
    pub legs: Vec<points::Legs>,
    /// The turn at B that equal arcs, links turned by the sum, and links before their joint have.
    pub turns_at_b_deg: [f64; 3],
    /// Every reading fitted to each set of points.
    pub fits: Vec<points::Fit>,
}
