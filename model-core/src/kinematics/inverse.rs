//! Fingertip to bends.
//!
//! Two coordinates are asked for and three bends can be chosen: of all that bring the fingertip there, the ones nearest to
//! those it starts from are taken (least sum of squares of the changes). Newton's method in fixed point, damped, within
//! the limits of each joint; where it does not get there from the present posture, it starts from others.

use super::arc::{bend, radians};
use super::forward::{Pose, Vector};
use super::step::{Aim, step, tamed};
use super::{Chain, Point, REACHED};
use crate::actuation::PerSegment;
use crate::sequence::MAX_BEND;
use crate::units::{Bend, Length};

/// Halvings, nearly, of an edge of the range in search of its nearest point: (2/3)³² of 110 degrees is 2⁻¹² degree.
const THIRDS: u32 = 32;
/// Steps from each start.
const STEPS: u32 = 20;
/// Postures to start from, in degrees, when the present one does not lead there: the middle of the range, and of each of its
/// edges, where the places that come nearest to what cannot be reached lie.
const STARTS: [[i16; 3]; 13] = [
    [55, 55, 55],
    [55, 0, 0],
    [55, 0, 110],
    [55, 110, 0],
    [55, 110, 110],
    [0, 55, 0],
    [0, 55, 110],
    [110, 55, 0],
    [110, 55, 110],
    [0, 0, 55],
    [0, 110, 55],
    [110, 0, 55],
    [110, 110, 55],
];
/// Damping, mm² in Q32: at the start, at least, at most.
const DAMPING: [i64; 3] = [1 << 32, 1 << 25, 1 << 44];
/// Squares of distances in 2⁻¹² mm: settled (2 µm), reached, and as far as the pull may lead away again (2 mm).
const SETTLED: i64 = 8 * 8;
const NEAR: i64 = {
    let reached = (REACHED.to_bits() >> 4) as i64;
    reached * reached
};
const ASTRAY: i64 = (2 << 12) * (2 << 12);
/// A change of the bends that no longer counts, 1e-5 rad in Q28.
const STILL: i64 = 2700;

/// Where a bend cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// At 0 degrees.
    Straight,
    /// At [`MAX_BEND`].
    Bent,
}

/// A place that no bends within their limits bring the fingertip to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unreachable {
    /// How far from it the fingertip stays.
    pub distance: Length,
    /// The bends that come that near.
    pub nearest: PerSegment<Bend>,
}

impl Unreachable {
    /// Which of the nearest bends are at a limit.
    #[must_use]
    pub fn limits(&self) -> PerSegment<Option<Limit>> {
        // What the bend sensor resolves.
        let margin = Bend::from_milli_deg(100);
        self.nearest.map(|bend| {
            if bend <= margin {
                Some(Limit::Straight)
            } else if bend >= MAX_BEND - margin {
                Some(Limit::Bent)
            } else {
                None
            }
        })
    }
}

/// What [`super::bends`] does.
pub(super) fn search(chain: &Chain, target: Point, from: &PerSegment<Bend>) -> Result<PerSegment<Bend>, Unreachable> {
    let search = Search {
        chain,
        target: [i64::from(target.x.to_bits()), i64::from(target.y.to_bits())],
        from: from.map(|bend| radians(bend.clamp(Bend::ZERO, MAX_BEND))),
        limit: radians(MAX_BEND),
    };
    let mut best = search.run(search.from, true);
    if best.squared > NEAR {
        let here = best.bends;
        for start in core::iter::once(here).chain(STARTS.map(|start| start.map(|deg| radians(Bend::from_deg(deg))))) {
            let found = search.run(start, false);
            if found.squared < best.squared {
                best = found;
            }
            if best.squared <= NEAR {
                break;
            }
        }
    }
    if best.squared > NEAR {
        // Newton's straight line says little far from the place; what comes nearest lies on an edge, or nearly always.
        best =
            search.edges().into_iter().fold(best, |best, edge| if edge.squared < best.squared { edge } else { best });
    }
    let bends = best.bends.map(|radians| bend(radians).clamp(Bend::ZERO, MAX_BEND));
    if best.squared <= NEAR {
        return Ok(bends);
    }
    let distance = best.squared.unsigned_abs().isqrt() << 4;
    let distance = Length::from_bits(i32::try_from(distance).unwrap_or(i32::MAX));
    Err(Unreachable { distance, nearest: bends })
}

struct Search<'a> {
    chain: &'a Chain,
    target: Vector,
    /// Rad in Q28, as all bends here.
    from: PerSegment<i32>,
    limit: i32,
}

/// A posture and the square of its distance from the target, in 2⁻²⁴ mm².
#[derive(Clone, Copy)]
struct Found {
    bends: PerSegment<i32>,
    squared: i64,
}

impl Search<'_> {
    fn missed(&self, pose: &Pose) -> (Vector, i64) {
        let ([target_x, target_y], [x, y]) = (self.target, pose.tip);
        let error = [target_x - x, target_y - y];
        // Below 2²⁹ each: their squares have room.
        let squared = error.map(|part| (part >> 4) * (part >> 4)).into_iter().sum();
        (error, squared)
    }

    fn at(&self, bends: PerSegment<i32>) -> Found {
        Found { bends, squared: self.missed(&Pose::of(self.chain, &bends)).1 }
    }

    /// The nearest posture on each edge of the range: two bends at a limit, the third by ternary search.
    fn edges(&self) -> [Found; 12] {
        let limit = self.limit;
        let along = |edge: fn(i32, i32, i32) -> PerSegment<i32>| {
            [(0, 0), (0, limit), (limit, 0), (limit, limit)].map(|(one, other)| {
                let (mut low, mut high) = (0, limit);
                for _ in 0..THIRDS {
                    let third = (high - low) / 3;
                    let (left, right) = (low + third, high - third);
                    if self.at(edge(left, one, other)).squared <= self.at(edge(right, one, other)).squared {
                        high = right;
                    } else {
                        low = left;
                    }
                }
                self.at(edge(i32::midpoint(low, high), one, other))
            })
        };
        let [a, b, c, d] = along(|free, one, other| [free, one, other]);
        let [e, f, g, h] = along(|free, one, other| [one, free, other]);
        let [i, j, k, l] = along(|free, one, other| [one, other, free]);
        [a, b, c, d, e, f, g, h, i, j, k, l]
    }

    /// With the pull, on the way to the posture nearest to `from`; without, only to the target.
    fn run(&self, start: PerSegment<i32>, pulled: bool) -> Found {
        let [mut damping, least, most] = DAMPING;
        let mut at = start;
        let mut pose = Pose::of(self.chain, &at);
        let (mut error, mut squared) = self.missed(&pose);
        for _ in 0..STEPS {
            let mut pull = [0; 3];
            if pulled {
                for ((pull, from), at) in pull.iter_mut().zip(self.from).zip(at) {
                    *pull = i64::from(from) - i64::from(at);
                }
            }
            let aim = Aim { error, pull, damping, limit: i64::from(self.limit) };
            let (change, largest) = tamed(step(&pose, &at, &aim));
            let mut next = at;
            for (next, change) in next.iter_mut().zip(change) {
                *next = (i64::from(*next) + change).max(0).min(i64::from(self.limit)) as i32;
            }
            let next_pose = Pose::of(self.chain, &next);
            let (next_error, next_squared) = self.missed(&next_pose);
            if next_squared < if pulled { squared.max(ASTRAY) } else { squared } {
                (at, pose, error, squared) = (next, next_pose, next_error, next_squared);
                damping = (damping >> 3).max(least);
            } else {
                damping = (damping << 3).min(most);
            }
            if squared <= SETTLED && (largest <= STILL || !pulled) {
                break;
            }
        }
        Found { bends: at, squared }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{bends, fingertip, reference};
    use super::*;
    use proptest::prelude::*;

    const LIMIT_DEG: f64 = 110.0;

    fn point([x, y]: [f64; 2]) -> Point {
        Point { x: Length::from_f64_mm(x), y: Length::from_f64_mm(y) }
    }

    fn exact_place(chain: &Chain, degrees: [f64; 3]) -> [f64; 2] {
        reference::fingertip(chain, degrees.map(f64::to_radians))
    }

    /// From the target to where the bends bring the fingertip in f64, mm; the bends must lie within their limits.
    fn missed(chain: &Chain, target: [f64; 2], bends: PerSegment<Bend>) -> f64 {
        assert!(bends.iter().all(|bend| (Bend::ZERO..=MAX_BEND).contains(bend)), "{bends:?}");
        reference::distance(exact_place(chain, bends.map(Bend::to_f64)), target)
    }

    /// The sum of the squares of two postures' differences, its root in degrees.
    fn change(a: [f64; 3], b: [f64; 3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }

    /// Any bend, the limits as often as not.
    fn any_bend() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), Just(LIMIT_DEG), 0.0..=LIMIT_DEG, 0.0..=LIMIT_DEG]
    }

    fn any_posture() -> impl Strategy<Value = [f64; 3]> {
        [any_bend(), any_bend(), any_bend()]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn what_the_finger_reaches_is_found(posture in any_posture(), from in any_posture()) {
            for chain in reference::CHAINS {
                let target = exact_place(&chain, posture);
                let found = bends(&chain, point(target), &from.map(Bend::from_f64_deg));
                let found = found.map_err(|error| TestCaseError::fail(format!("{chain:?} {target:?}: {error:?}")))?;
                let off = missed(&chain, target, found);
                // REACHED, and the fixed-point forward's own error.
                prop_assert!(off < 0.028, "{off} mm");
            }
        }

        #[test]
        fn nothing_leaves_the_limits_wherever_the_target(x in any::<i32>(), y in any::<i32>(), from in any::<[i32; 3]>()) {
            let target = Point { x: Length::from_bits(x), y: Length::from_bits(y) };
            let from = from.map(Bend::from_bits);
            let found = match bends(&Chain::PAPER, target, &from) {
                Ok(found) => found,
                Err(error) => {
                    let off = missed(&Chain::PAPER, [target.x.to_f64(), target.y.to_f64()], error.nearest);
                    prop_assert!((off - error.distance.to_f64()).abs() < 0.01 || error.distance == Length::MAX, "{off} {error:?}");
                    error.nearest
                }
            };
            prop_assert!(found.iter().all(|bend| (Bend::ZERO..=MAX_BEND).contains(bend)));
        }
    }

    /// A local search: of 47 it takes 7 by another way, none of them much longer.
    #[test]
    fn the_change_is_hardly_longer_than_the_least_of_a_dense_grid() {
        let chain = Chain::PAPER;
        let grid: Vec<([f64; 3], [f64; 2])> =
            reference::postures(LIMIT_DEG, 110).map(|posture| (posture, exact_place(&chain, posture))).collect();
        let (mut longer, mut tried) = (0, 0);
        for (from, there) in reference::postures(LIMIT_DEG, 3).zip(reference::postures(LIMIT_DEG, 3).skip(17)) {
            let target = exact_place(&chain, there.map(|bend| 0.9 * bend + 4.0));
            let found =
                bends(&chain, point(target), &from.map(Bend::from_f64_deg)).expect("reachable").map(Bend::to_f64);
            // A grid of one degree has a posture within 1 mm of the target beside nearly each that reaches it.
            let least = grid
                .iter()
                .filter(|(_, place)| reference::distance(*place, target) < 1.0)
                .map(|(posture, _)| change(*posture, from))
                .fold(f64::INFINITY, f64::min);
            let excess = change(found, from) - least;
            tried += 1;
            longer += u32::from(excess > 2.5);
            assert!(
                excess < 10.0,
                "from {from:?} to {target:?}: {found:?}, {excess} degrees more than the grid's least"
            );
        }
        println!("{longer} of {tried} changes are longer than the grid's least by more than 2.5 degrees");
        assert!(tried > 40 && longer <= 8, "{longer} of {tried}");
    }

    #[test]
    fn what_a_dense_grid_does_not_reach_is_said_to_be_unreachable_and_by_how_much() {
        for chain in reference::CHAINS {
            let reach = reference::length(&chain);
            let grid: Vec<[f64; 2]> =
                reference::postures(LIMIT_DEG, 110).map(|posture| exact_place(&chain, posture)).collect();
            let (mut unreachable, mut reachable) = (0, 0);
            for (i, j) in (-8_i32..=8).flat_map(|i| (-8_i32..=8).map(move |j| (i, j))) {
                let target = [f64::from(i) / 7.0 * reach, f64::from(j) / 7.0 * reach];
                let grid_distance =
                    grid.iter().map(|place| reference::distance(*place, target)).fold(f64::INFINITY, f64::min);
                match bends(&chain, point(target), &[Bend::from_deg(30); 3]) {
                    Ok(found) => {
                        reachable += 1;
                        assert!(missed(&chain, target, found) < 0.028);
                        assert!(grid_distance < 3.0, "{target:?}: the grid comes no nearer than {grid_distance} mm");
                    }
                    Err(error) => {
                        unreachable += 1;
                        let distance = error.distance.to_f64();
                        assert!((missed(&chain, target, error.nearest) - distance).abs() < 0.01);
                        assert!(distance < grid_distance + 0.02, "{target:?}: {error:?}, the grid {grid_distance} mm");
                        assert!(distance > grid_distance - 3.0, "{target:?}: {error:?}, the grid {grid_distance} mm");
                        assert!(error.limits().iter().any(Option::is_some), "{error:?}");
                    }
                }
            }
            println!("{reachable} reachable, {unreachable} not");
            assert!(reachable > 15 && unreachable > 100);
        }
    }

    #[test]
    fn a_place_beyond_the_straight_finger_is_missed_by_the_difference() {
        let target = point([150.0, 0.0]);
        let error = bends(&Chain::PAPER, target, &[Bend::from_deg(20); 3]).expect_err("130 mm long");
        assert!((error.distance.to_f64() - 20.0).abs() < 0.01, "{error:?}");
        assert_eq!(error.limits(), [Some(Limit::Straight); 3], "{error:?}");
    }

    #[test]
    fn the_present_posture_is_kept_where_it_is_right() {
        let from = [70, 20, 45].map(Bend::from_deg);
        let found = bends(&Chain::PAPER, fingertip(&Chain::PAPER, &from).point, &from).expect("reachable");
        for (found, from) in found.into_iter().zip(from) {
            assert!((found - from).abs() <= Bend::from_milli_deg(2), "{found:?} {from:?}");
        }
    }
}
