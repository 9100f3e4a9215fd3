//! Driving force from pressure: the paper's Table 3 with straight lines between its points.
//!
//! A single line through each row's points (their slope and correlation: `host-sim paper`) would miss the finger's at
//! 30 kPa by 6 %; straight lines from point to point meet every one, and the left-out middle of three by the table's own
//! unevenness.
//!
//! [`finger_force`] takes 224 instructions on the Cortex-M4 in the mean and 258 at the worst (`cargo xtask pareto`, docs/kinematics.md).

use crate::actuation::PerSegment;
use crate::units::{Force, Pressure};

/// Pressure from point to point of Table 3.
const SPACING: i32 = 30 << 16;

/// One row of Table 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrivingForce([Force; 6]);

impl DrivingForce {
    /// One chamber without exoskeleton.
    pub const CHAMBER_BARE: Self = Self::of([0, 470, 940, 1420, 1880, 2360]);
    /// One chamber with exoskeleton.
    pub const CHAMBER_EXO: Self = Self::of([0, 1360, 2700, 4070, 5450, 6710]);
    /// The finger of three chambers with exoskeleton.
    pub const FINGER: Self = Self::of([0, 2510, 4500, 6750, 9050, 11_500]);

    /// From the table's values in mN at 0, 30, .. 150 kPa.
    const fn of([a, b, c, d, e, f]: [i32; 6]) -> Self {
        const fn at(value: i32) -> Force {
            Force::from_milli_newtons(value)
        }
        Self([at(a), at(b), at(c), at(d), at(e), at(f)])
    }

    /// The force at a gauge pressure, rounded down to 2⁻¹⁶ N; constant outside 0..=150 kPa.
    #[must_use]
    pub fn at(&self, pressure: Pressure) -> Force {
        let bits = pressure.to_bits().max(0);
        let (index, part) = ((bits / SPACING) as usize, i64::from(bits % SPACING));
        let Self(forces) = self;
        let (Some(low), Some(high)) = (forces.get(index), forces.get(index.saturating_add(1))) else {
            let [.., last] = forces;
            return *last;
        };
        let rise = i64::from(high.to_bits()) - i64::from(low.to_bits());
        *low + Force::from_bits((rise * part / i64::from(SPACING)) as i32)
    }
}

/// The finger's driving force with these pressures: Table 3 in their mean. An estimate where they differ; the paper has
/// measured only equal ones.
#[must_use]
pub fn finger_force(pressures: &PerSegment<Pressure>) -> Force {
    let sum: i64 = pressures.iter().map(|pressure| i64::from(pressure.to_bits())).sum();
    DrivingForce::FINGER.at(Pressure::from_bits((sum / 3) as i32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper;
    use proptest::prelude::*;

    const ROWS: [(DrivingForce, [f64; 6]); 3] = [
        (DrivingForce::CHAMBER_BARE, paper::CHAMBER_BARE_N),
        (DrivingForce::CHAMBER_EXO, paper::CHAMBER_EXO_N),
        (DrivingForce::FINGER, paper::FINGER_N),
    ];

    #[test]
    fn table_3_is_met() {
        for (row, measured) in ROWS {
            for (pressure, measured) in paper::FORCE_PRESSURE_KPA.into_iter().zip(measured) {
                let found = row.at(Pressure::from_f64_kpa(pressure)).to_f64();
                assert!((found - measured).abs() <= 1e-5, "{pressure} kPa: {found} N, {measured} N");
            }
        }
    }

    #[test]
    fn outside_the_table_the_ends_hold() {
        for (row, measured) in ROWS {
            assert_eq!(row.at(Pressure::MIN), Force::ZERO);
            assert!((row.at(Pressure::MAX).to_f64() - measured[5]).abs() <= 1e-5);
        }
    }

    #[test]
    fn the_finger_takes_the_mean() {
        let pressures = [60, 30, 60].map(Pressure::from_kpa);
        assert_eq!(finger_force(&pressures), DrivingForce::FINGER.at(Pressure::from_kpa(50)));
        assert_eq!(finger_force(&[Pressure::MAX; 3]), DrivingForce::FINGER.at(Pressure::MAX));
        assert_eq!(finger_force(&[Pressure::MIN; 3]), Force::ZERO);
    }

    proptest! {
        #[test]
        fn it_lies_on_the_line_and_never_falls(bits in 0..150_i32 << 16) {
            for (row, measured) in ROWS {
                let kpa = f64::from(bits) / 65_536.0;
                let index = (kpa / 30.0) as usize;
                let share = kpa / 30.0 - index as f64;
                let exact = measured[index] + share * (measured[index + 1] - measured[index]);
                let found = row.at(Pressure::from_bits(bits));
                prop_assert!((found.to_f64() - exact).abs() < 4e-5, "{} {}", found.to_f64(), exact);
                prop_assert!(row.at(Pressure::from_bits(bits + 1)) >= found);
            }
        }
    }
}
