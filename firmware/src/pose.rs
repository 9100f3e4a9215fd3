//! What is shown, not decided on: the fingertip's place and the driving force, both from the chambers' pressures.

use micromath::F32Ext;
use model_core::actuation::PerSegment;
use model_core::inverse::bend_from_pressure;
use model_core::units::{Coefficients, Pressure};

/// Lengths of the three segments in mm: the actuator's 130 mm (paper, Table 1) in three. Assumed: the paper gives no link
/// lengths.
pub const LINKS_MM: [f32; 3] = [44.0, 44.0, 42.0];

/// Driving force of the finger at 0, 30, .. 150 kPa in all chambers, mN (paper, Table 3, physical test).
const FORCE_MN: [i32; 6] = [0, 2510, 4500, 6750, 9050, 11_500];

/// Where the fingertip is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fingertip {
    /// Along the straight finger, micrometres.
    pub x_um: i32,
    /// Towards the bend, micrometres.
    pub y_um: i32,
    /// Direction, thousandths of a degree from straight.
    pub direction_millideg: i32,
}

/// The planar chain of the paper's eq. (21)-(23): each segment's link turned by the sum of the bends up to it.
///
/// In f32 with micromath, for a display: worst 0.15 mm from f64 over 0..=150 kPa in each chamber (this file's test).
#[must_use]
pub fn fingertip(coefficients: &PerSegment<Coefficients>, pressures: PerSegment<Pressure>) -> Fingertip {
    let (mut x, mut y, mut angle) = (0.0_f32, 0.0_f32, 0.0_f32);
    for ((own, pressure), link) in coefficients.iter().zip(pressures).zip(LINKS_MM) {
        let bend = bend_from_pressure(own, pressure.max(Pressure::ZERO));
        angle += bend.to_bits() as f32 / 65_536.0;
        let radians = angle * (core::f32::consts::PI / 180.0);
        // Named in full: on a host with the standard library its own functions would win.
        x += link * F32Ext::cos(radians);
        y += link * F32Ext::sin(radians);
    }
    Fingertip { x_um: (x * 1000.0) as i32, y_um: (y * 1000.0) as i32, direction_millideg: (angle * 1000.0) as i32 }
}

/// Driving force in mN, by straight lines between the paper's points in the mean pressure: an estimate, measured only
/// with the same pressure in all chambers. Rounded down; constant outside 0..=150 kPa.
#[must_use]
pub fn force_mn(pressures: PerSegment<Pressure>) -> i32 {
    let sum: i64 = pressures.iter().map(|pressure| i64::from(pressure.to_bits())).sum();
    let mean = (sum / 3).clamp(0, 150 << 16);
    let step = 30_i64 << 16;
    let index = (mean / step) as usize;
    let at = |index: usize| FORCE_MN.get(index).or(FORCE_MN.last()).copied().map_or(0, i64::from);
    (at(index) + (at(index + 1) - at(index)) * (mean % step) / step) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::calibration;

    #[test]
    fn the_fingertip_is_right_for_a_display() {
        let mut worst = 0.0_f64;
        for [p, m, d] in (0..=15).flat_map(|p| (0..=15).flat_map(move |m| (0..=15).map(move |d| [p, m, d]))) {
            let pressures = [p, m, d].map(|tens: i16| Pressure::from_kpa(10 * tens));
            let (mut x, mut y, mut angle) = (0.0, 0.0, 0.0_f64);
            for (pressure, link) in pressures.into_iter().zip(LINKS_MM) {
                let bend = bend_from_pressure(&calibration::DEFAULT, pressure);
                angle += (f64::from(bend.to_bits()) / 65_536.0).to_radians();
                x += f64::from(link) * angle.cos();
                y += f64::from(link) * angle.sin();
            }
            let tip = fingertip(&[calibration::DEFAULT; 3], pressures);
            let [dx, dy] = [f64::from(tip.x_um) / 1000.0 - x, f64::from(tip.y_um) / 1000.0 - y];
            worst = worst.max(dx.hypot(dy));
        }
        println!("worst {worst} mm");
        assert!(worst < 0.15, "{worst}");
    }

    #[test]
    fn the_force_is_the_papers_at_its_points() {
        for (index, expected) in FORCE_MN.into_iter().enumerate() {
            assert_eq!(force_mn([Pressure::from_kpa(30 * index as i16); 3]), expected);
        }
        assert_eq!(force_mn([Pressure::from_kpa(15); 3]), 1255);
        assert_eq!(force_mn([Pressure::MIN; 3]), 0);
        assert_eq!(force_mn([Pressure::MAX; 3]), 11_500);
    }
}
