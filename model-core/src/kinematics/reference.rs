//! The chain in f64 by another route, for the tests: each arc by its radius and the directions at its ends, not by its chord.

use super::Chain;
use crate::units::Length;

/// The paper's finger, three rigid links, and one of unequal parts.
pub(super) const CHAINS: [Chain; 3] =
    [Chain::PAPER, chain(0, [0; 3], [44, 44, 42]), chain(12, [60, 35, 20], [3, 0, 11])];

const fn chain(base: i16, [a, b, c]: [i16; 3], [d, e, f]: [i16; 3]) -> Chain {
    const fn mm(value: i16) -> Length {
        Length::from_mm(value)
    }
    match Chain::new(mm(base), [mm(a), mm(b), mm(c)], [mm(d), mm(e), mm(f)]) {
        Ok(chain) => chain,
        Err(_) => panic!("no finger"),
    }
}

/// The fingertip in mm for bends in radians.
pub(super) fn fingertip(chain: &Chain, bends: [f64; 3]) -> [f64; 2] {
    let (mut x, mut y, mut direction) = (chain.base().to_f64(), 0.0, 0.0_f64);
    for ((bend, arc), link) in bends.into_iter().zip(chain.arcs()).zip(chain.links()) {
        let arc = arc.to_f64();
        let after = direction + bend;
        if bend.abs() < 1e-7 {
            x += arc * direction.cos();
            y += arc * direction.sin();
        } else {
            let radius = arc / bend;
            x += radius * (after.sin() - direction.sin());
            y += radius * (direction.cos() - after.cos());
        }
        direction = after;
        x += link.to_f64() * direction.cos();
        y += link.to_f64() * direction.sin();
    }
    [x, y]
}

/// All parts together, mm.
pub(super) fn length(chain: &Chain) -> f64 {
    chain.arcs().into_iter().chain(chain.links()).fold(chain.base(), |sum, part| sum + part).to_f64()
}

/// Between two places.
pub(super) fn distance([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    (a - c).hypot(b - d)
}

/// A grid of bends in degrees, 0 to `most`, with `steps` steps on each axis.
pub(super) fn postures(most: f64, steps: u32) -> impl Iterator<Item = [f64; 3]> {
    let at = move |index: u32| most * f64::from(index) / f64::from(steps);
    let all = move || 0..=steps;
    all().flat_map(move |a| all().flat_map(move |b| all().map(move |c| [at(a), at(b), at(c)])))
}
