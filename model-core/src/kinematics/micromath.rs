//! The fingertip in f32 with micromath's sine and cosine, which are good to 1e-3: for a display.

use super::Chain;
use crate::actuation::PerSegment;
use crate::inverse::BEND_LIMIT;
use crate::units::{Bend, Length};
use micromath::F32Ext;

/// Where the fingertip is and where it points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fingertip {
    /// Along the straight finger from the hand, mm.
    pub x_mm: f32,
    /// Towards the side that the finger bends to, mm.
    pub y_mm: f32,
    /// The sum of the bends, degrees.
    pub direction_deg: f32,
}

/// As [`super::fingertip`], in f32: worst error 0.15 mm for a finger of 130 mm.
#[must_use]
pub fn fingertip(chain: &Chain, bends: &PerSegment<Bend>) -> Fingertip {
    let mm = |length: Length| length.to_bits() as f32 / 65_536.0;
    let (mut x_mm, mut y_mm, mut direction_deg) = (mm(chain.base()), 0.0, 0.0);
    let mut along = |length: f32, degrees: f32| {
        let radians = degrees * (core::f32::consts::PI / 180.0);
        // Named in full: on a host with the standard library its own functions would win.
        x_mm += length * F32Ext::cos(radians);
        y_mm += length * F32Ext::sin(radians);
    };
    for ((bend, arc), link) in bends.iter().zip(chain.arcs()).zip(chain.links()) {
        let degrees = bend.min(&BEND_LIMIT).max(&Bend::ZERO).to_bits() as f32 / 65_536.0;
        along(mm(arc) * sinc(degrees * (core::f32::consts::PI / 360.0)), direction_deg + degrees / 2.0);
        direction_deg += degrees;
        along(mm(link), direction_deg);
    }
    Fingertip { x_mm, y_mm, direction_deg }
}

/// Up to 1.5 rad, to 1e-5. From its series: micromath's sine over a small angle would be off by its error over the angle.
fn sinc(radians: f32) -> f32 {
    let square = radians * radians;
    1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))
}

#[cfg(test)]
mod tests {
    use super::super::reference;
    use super::*;

    #[test]
    fn errors_against_f64() {
        let mut worst = 0.0_f64;
        for chain in reference::CHAINS {
            for bends in reference::postures(110.0, 23) {
                let bends = bends.map(Bend::from_f64_deg);
                let exact = reference::fingertip(&chain, bends.map(|bend| bend.to_f64().to_radians()));
                let found = fingertip(&chain, &bends);
                let place = [found.x_mm, found.y_mm].map(f64::from);
                worst = worst.max(reference::distance(place, exact) / reference::length(&chain));
            }
        }
        println!("worst error {:.3} mm for a finger of 130 mm", worst * 130.0);
        assert!(worst * 130.0 < 0.15 && worst * 130.0 > 0.01, "{worst}");
    }
}
