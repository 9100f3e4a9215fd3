//! What is shown, not decided on: the fingertip's place and the driving force, both from the chambers' pressures.

use model_core::actuation::PerSegment;
use model_core::force::finger_force;
use model_core::inverse::bend_from_pressure;
use model_core::kinematics::{Chain, micromath};
use model_core::units::{Coefficients, Pressure};

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

/// The fingertip of the paper's finger ([`Chain::PAPER`]) with these pressures.
///
/// In f32 with micromath, for a display: worst 0.15 mm from f64 (`model_core::kinematics`).
#[must_use]
pub fn fingertip(coefficients: &PerSegment<Coefficients>, pressures: PerSegment<Pressure>) -> Fingertip {
    let [p, m, d] = coefficients;
    let [at_p, at_m, at_d] = pressures;
    let bends = [bend_from_pressure(p, at_p), bend_from_pressure(m, at_m), bend_from_pressure(d, at_d)];
    let tip = micromath::fingertip(&Chain::PAPER, &bends);
    let thousandths = |value: f32| (value * 1000.0) as i32;
    Fingertip {
        x_um: thousandths(tip.x_mm),
        y_um: thousandths(tip.y_mm),
        direction_millideg: thousandths(tip.direction_deg),
    }
}

/// Driving force in mN, to the nearest ([`finger_force`]).
#[must_use]
pub fn force_mn(pressures: PerSegment<Pressure>) -> i32 {
    ((i64::from(finger_force(&pressures).to_bits()) * 1000 + (1 << 15)) >> 16) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::calibration;

    #[test]
    fn a_straight_finger_is_as_long_as_the_actuator() {
        let tip = fingertip(&[calibration::DEFAULT; 3], [Pressure::ZERO; 3]);
        assert!((tip.x_um - 130_000).abs() <= 150 && tip.y_um.abs() <= 150, "{tip:?}");
        assert_eq!(tip.direction_millideg, 0);
    }

    #[test]
    fn each_pressure_bends_its_own_segment_with_its_own_calibration() {
        let bare = Coefficients::new("35.3".parse().unwrap(), "7.24".parse().unwrap(), "0.831".parse().unwrap());
        let coefficients = [bare.unwrap(), calibration::DEFAULT, calibration::DEFAULT];
        let pressures = [90, 0, 60].map(Pressure::from_kpa);
        let degrees = |bits: i32| f64::from(bits) / 65_536.0;
        let [p, d] = [(0, 0), (2, 2)].map(|(i, j)| {
            let (coefficients, pressure): (&Coefficients, Pressure) = (&coefficients[i], pressures[j]);
            degrees(bend_from_pressure(coefficients, pressure).to_bits())
        });
        // Arc by radius: another way than the chord.
        let (s, p, whole) = (38.0, p.to_radians(), (p + d).to_radians());
        let mut place = [7.0 + s / p * p.sin(), s / p * (1.0 - p.cos())];
        let along = |place: &mut [f64; 2], length: f64, at: f64| {
            place[0] += length * at.cos();
            place[1] += length * at.sin();
        };
        along(&mut place, 1.0 + s + 1.0, p);
        let bend = whole - p;
        place[0] += s / bend * (whole.sin() - p.sin());
        place[1] += s / bend * (p.cos() - whole.cos());
        along(&mut place, 7.0, whole);
        let tip = fingertip(&coefficients, pressures);
        let [dx, dy] = [f64::from(tip.x_um) / 1e3 - place[0], f64::from(tip.y_um) / 1e3 - place[1]];
        assert!(dx.hypot(dy) < 0.15, "{tip:?} {place:?}");
        assert!((f64::from(tip.direction_millideg) / 1e3 - whole.to_degrees()).abs() < 0.01);
    }

    #[test]
    fn the_force_is_the_papers_at_its_points() {
        for (index, expected) in [0, 2510, 4500, 6750, 9050, 11_500].into_iter().enumerate() {
            assert_eq!(force_mn([Pressure::from_kpa(30 * index as i16); 3]), expected);
        }
        assert_eq!(force_mn([Pressure::from_kpa(15); 3]), 1255);
        assert_eq!(force_mn([Pressure::MIN; 3]), 0);
        assert_eq!(force_mn([Pressure::MAX; 3]), 11_500);
    }
}
