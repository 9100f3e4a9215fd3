//! Bends to fingertip, with the slopes that the inverse needs.

use super::Chain;
use super::arc::{direction, sinc_of_half};
use crate::actuation::PerSegment;
use crate::units::Length;

/// A vector in 2⁻¹⁶ mm.
pub(super) type Vector = [i64; 2];

/// The fingertip, and how far it moves for each bend.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    /// The fingertip.
    pub tip: Vector,
    /// Per radian of each bend.
    pub slopes: PerSegment<Vector>,
}

/// A length times a unit vector.
fn along(length: i64, [cos, sin]: [i64; 2]) -> Vector {
    let round = |product: i64| (product + (1 << 30)) >> 31;
    [round(length * cos), round(length * sin)]
}

fn sum([a, b]: Vector, [c, d]: Vector) -> Vector {
    [a + c, b + d]
}

/// A quarter turn towards the bend.
fn turned([x, y]: Vector) -> Vector {
    [-y, x]
}

impl Pose {
    /// Of bends in radians, Q28, each 0 to 170 degrees.
    pub fn of(chain: &Chain, bends: &PerSegment<i32>) -> Self {
        let bits = |length: Length| i64::from(length.to_bits());
        let mut tip = [bits(chain.base()), 0];
        let mut angle = 0_i64;
        let mut slopes = [[0; 2]; 3];
        let mut ends = [[0; 2]; 3];
        let parts = bends.iter().zip(chain.arcs()).zip(chain.links()).zip(slopes.iter_mut().zip(&mut ends));
        for (((&bend, arc), link), (slope, end)) in parts {
            let half = direction(angle + i64::from(bend >> 1));
            let (sinc, sinc_slope) = sinc_of_half(bend);
            let chord = (bits(arc) * sinc + (1 << 29)) >> 30;
            let chord_slope = (bits(arc) * sinc_slope) >> 30;
            // The chord turns by half the bend.
            *slope = sum(along(chord_slope, half), turned(along(chord >> 1, half)));
            tip = sum(tip, along(chord, half));
            *end = tip;
            angle += i64::from(bend);
            tip = sum(tip, along(bits(link), direction(angle)));
        }
        // All that is behind a segment turns about its end.
        for (slope, [x, y]) in slopes.iter_mut().zip(ends) {
            let [tip_x, tip_y] = tip;
            *slope = sum(*slope, turned([tip_x - x, tip_y - y]));
        }
        Self { tip, slopes }
    }
}

#[cfg(test)]
mod tests {
    use super::super::arc::radians;
    use super::super::{Fingertip, fingertip, reference};
    use super::*;
    use crate::inverse::BEND_LIMIT;
    use crate::units::Bend;

    fn place(tip: Fingertip) -> [f64; 2] {
        [tip.point.x.to_f64(), tip.point.y.to_f64()]
    }

    #[test]
    fn errors_against_f64() {
        let mut worst = 0.0_f64;
        for chain in reference::CHAINS {
            for bends in reference::postures(110.0, 23).chain(reference::postures(170.0, 7)) {
                let bends = bends.map(Bend::from_f64_deg);
                let exact = reference::fingertip(&chain, bends.map(|bend| bend.to_f64().to_radians()));
                let found = fingertip(&chain, &bends);
                worst = worst.max(reference::distance(place(found), exact) / reference::length(&chain));
                let direction: f64 = bends.iter().map(|bend| bend.to_f64()).sum();
                assert!((found.direction.to_f64() - direction).abs() < 1e-9);
            }
        }
        println!("worst error {:.2} um for a finger of 130 mm", worst * 130e3);
        assert!(worst * 130e3 < 3.0, "{worst}");
    }

    #[test]
    fn slopes_are_those_of_the_place() {
        const STEP: f64 = 1e-6;
        for chain in reference::CHAINS {
            for bends in reference::postures(109.0, 6) {
                let pose = Pose::of(&chain, &bends.map(|deg| radians(Bend::from_f64_deg(deg))));
                for (joint, slope) in pose.slopes.into_iter().enumerate() {
                    let at = |by: f64| {
                        let mut moved = bends.map(f64::to_radians);
                        moved[joint] += by;
                        reference::fingertip(&chain, moved)
                    };
                    let (after, before) = (at(STEP), at(-STEP));
                    for (axis, found) in slope.into_iter().enumerate() {
                        let exact = (after[axis] - before[axis]) / (2.0 * STEP);
                        assert!((found as f64 / 65_536.0 - exact).abs() < 0.02, "{bends:?} {joint} {found} {exact}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_straight_finger_lies_along_x_and_bends_outside_the_range_are_those_of_its_ends() {
        let [x, y] = place(fingertip(&Chain::PAPER, &[Bend::MIN; 3]));
        assert!((x - 130.0).abs() < 3e-3 && y.abs() < 3e-3, "{x} {y}");
        assert_eq!(fingertip(&Chain::PAPER, &[Bend::MAX; 3]), fingertip(&Chain::PAPER, &[BEND_LIMIT; 3]));
    }
}
