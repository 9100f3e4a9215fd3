//! Where the fingertip is for three bends, and which bends bring it to a place.
//!
//! A planar Denavit-Hartenberg chain (the paper's eq. (21)-(23)) with three rows a segment: a joint of half the bend, the
//! chord of the segment's arc, a joint of the other half and a straight link.
//!
//! ```text
//! ψ = α₁ + .. + αᵢ₋₁                      direction at the segment's start
//! p ← p + sᵢ · sinc(αᵢ/2) · u(ψ + αᵢ/2)   the arc, of length sᵢ
//! p ← p + lᵢ · u(ψ + αᵢ)                  the stiff part behind it
//! ```
//!
//! With all arcs zero it is the chain of three rigid links, each turned by the sum of the bends up to it. Which of the two
//! the paper means is not known from the facts at hand; its points A, B and C fit the arcs (`docs/kinematics.md`).
//!
//! | | Error against f64, a finger of 130 mm | Instructions on the Cortex-M4 |
//! |---|---|---|
//! | [`fingertip`], fixed point | at most 3 µm | 1,342 |
//! | `micromath::fingertip`, f32, for a display | at most 0.15 mm | 349 |
//! | [`bends`], fixed point | within [`REACHED`] of the place | 36,300 in the mean, 78,390 at the worst; 2.8 million for a place out of reach |
//!
//! Counted by `cargo xtask pareto` (`docs/kinematics.md`).
//!
//! x runs along the straight finger from the hand, y towards the side that the finger bends to.

mod arc;
mod chain;
mod forward;
mod inverse;
#[cfg(any(test, feature = "micromath"))]
pub mod micromath;
#[cfg(test)]
mod reference;
mod step;

pub use chain::Chain;
pub use chain::ChainError;
pub use inverse::Limit;
pub use inverse::Unreachable;

use crate::actuation::PerSegment;
use crate::inverse::BEND_LIMIT;
use crate::units::{Bend, Length};
use arc::radians;
use forward::Pose;

/// A place in the finger's plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Point {
    /// Along the straight finger, from the hand.
    pub x: Length,
    /// Towards the side that the finger bends to.
    pub y: Length,
}

/// Where the fingertip is and where it points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fingertip {
    /// Its place.
    pub point: Point,
    /// Its direction: the sum of the bends, 0 for a straight finger.
    pub direction: Bend,
}

/// The fingertip of a finger with these bends, each taken as 0 below zero and as [`BEND_LIMIT`] beyond it.
///
/// Worst error 3 µm for a finger of 130 mm, in proportion for others: that of the sine and cosine, 9e-6 (idsp's `cossin`),
/// over the finger's parts.
#[must_use]
pub fn fingertip(chain: &Chain, bends: &PerSegment<Bend>) -> Fingertip {
    let bends = bends.map(|bend| bend.clamp(Bend::ZERO, BEND_LIMIT));
    let [x, y] = Pose::of(chain, &bends.map(radians)).tip;
    let length = |bits: i64| Length::from_bits(bits as i32);
    let [proximal, middle, distal] = bends;
    Fingertip { point: Point { x: length(x), y: length(y) }, direction: proximal + middle + distal }
}

/// How near to the place the fingertip has to come: 20 µm, a tenth of what 0.1 degree, the bend sensor's resolution, moves it.
pub const REACHED: Length = Length::from_um(20);

/// The bends, each within 0..=[`MAX_BEND`](crate::sequence::MAX_BEND), that bring the fingertip to `target`, within [`REACHED`].
///
/// Of the many that do, those nearest to `from` in the sum of squares that can be reached from there without a turn
/// away; when `from` leads into a corner of the limits, some others.
///
/// # Errors
/// [`Unreachable`] says by how much the place is missed and with which bends.
pub fn bends(chain: &Chain, target: Point, from: &PerSegment<Bend>) -> Result<PerSegment<Bend>, Unreachable> {
    inverse::search(chain, target, from)
}
