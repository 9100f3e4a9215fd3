//! The model in both directions, in fixed point: bend from pressure and pressure from bend.
//!
//! ```text
//! P(α) = k·α + c1·A + c2·B      λ = α / sin α,  A = 4 (λ − λ⁻⁵),  B = 2 A (I1 − 3),  I1 = 2 λ² + λ⁻⁴
//! ```
//!
//! ```
//! use model_core::calibration;
//! use model_core::inverse::{bend_from_pressure, pressure_from_bend};
//! use model_core::units::{Bend, Pressure};
//!
//! let pressure = Pressure::from_kpa(150);
//! let bend = bend_from_pressure(&calibration::DEFAULT, pressure);
//! assert!(bend > Bend::from_deg(112) && bend < Bend::from_deg(114)); // 113 degrees in the paper's Table 2
//! let again = pressure_from_bend(&calibration::DEFAULT, bend);
//! assert!((again - pressure).abs() <= Pressure::from_milli_kpa(1));
//! ```
//!
//! Two ways, for two uses; `docs/inverse.md` has them beside fourteen others, and says why these:
//!
//! | | [`bend_from_pressure`], [`pressure_from_bend`] | [`Tabulated`] |
//! |---|---|---|
//! | Calibration | given with each call | prepared, in some 120,000 instructions |
//! | Instructions on a Cortex-M4, bend / pressure | at most 200 / 95 | at most 45 / 50 below 256 kPa and 164 degrees |
//! | Tables | 2 KiB of flash for both | 3 KiB of RAM for both |
//! | Worst error, 0..150 kPa | 3.4e-5 degree, 3.9e-5 kPa | 1.8e-5 degree, 2.6e-5 kPa |
//!
//! Rounding to the last bit alone is 7.6e-6. Instructions: `cargo xtask pareto`. Errors: every input of thirteen
//! calibrations, `cargo xtask exhaustive -- --calibrations all`.
//!
//! The first is what the controller uses: a change of calibration takes effect at once and leaves nothing to be
//! rebuilt. The second pays where one calibration is asked for thousands of times.
//!
//! # Near rest, near the pole
//! A and B are products of positive terms where the tables are made, so that nothing cancels at α → 0, where λ is 0/0.
//! There P ≈ 4 c1 α² (for k = 0), and α(P) starts like a square root: the first segment is solved in a scaled variable,
//! and the prepared table's segments shrink with the pressure, octave by octave. At α → 180 degrees λ has its pole; the
//! model ends at 170 degrees.
//!
//! # Monotone
//! Neither direction ever falls, whatever is given: checked over every input of thirteen calibrations, and around random
//! inputs of random ones. Within a segment the steps from one input to the next are larger than what rounding can take
//! back; from one segment to the next the coefficients are rounded so that the left one ends at or below where the right
//! one starts (see `segments.rs`).
//!
//! # Outside
//! Up to 0 kPa the bend is 0: the exoskeleton stops extension, and the model has no branch there. Above
//! [`PRESSURE_LIMIT`] it is the bend at that limit, and nowhere above [`BEND_LIMIT`]. Likewise the pressure, which saturates
//! at [`Pressure::MAX`].

// One function each, called from one place: their calls would cost what the formats save.
#![allow(clippy::inline_always)]

mod direct;
mod floating;
pub(crate) mod segments;
mod tabulated;

pub use tabulated::Tabulated;

use crate::units::{Bend, Coefficients, Pressure};
use direct::Model;

/// Beyond this bend the model's pole at 180 degrees is near and the finger cannot follow: the model ends here.
pub const BEND_LIMIT: Bend = Bend::from_deg(170);

/// Beyond this pressure the inverse saturates: the end of the pressure sensor's range.
pub const PRESSURE_LIMIT: Pressure = Pressure::from_kpa(1000);

/// The bend at which the segment rests under `pressure`.
///
/// From 0 to 1000 kPa the solution of P(α) = `pressure`, at most [`BEND_LIMIT`]; above 1000 kPa the value there; 0 at or
/// below 0 kPa. Rounded to nearest; worst error 3.4e-5 degree, at most 200 instructions on a Cortex-M4 (see the
/// [module](self)'s text). Non-decreasing.
#[must_use]
#[inline(always)]
pub fn bend_from_pressure(coefficients: &Coefficients, pressure: Pressure) -> Bend {
    let bits = pressure.min(PRESSURE_LIMIT).to_bits();
    if bits <= 0 {
        return Bend::ZERO;
    }
    let angle = Model::new(coefficients).angle::<0>((bits as u32) << 6);
    Bend::from_bits(((angle + 128) >> 8) as i32)
}

/// The pressure that holds the segment at `bend`.
///
/// From 0 to 170 degrees P(α), saturated at [`Pressure::MAX`]; 0 at or below 0 degrees, and beyond [`BEND_LIMIT`] the value
/// there. Rounded to nearest; worst error over 0..150 kPa 3.9e-5 kPa, up to saturation 4e-6 of the value, at most 95
/// instructions on a Cortex-M4 (see the [module](self)'s text). Non-decreasing.
#[must_use]
#[inline(always)]
pub fn pressure_from_bend(coefficients: &Coefficients, bend: Bend) -> Pressure {
    let bits = bend.min(BEND_LIMIT).to_bits();
    if bits <= 0 {
        return Pressure::ZERO;
    }
    let (wide, fraction_bits) = Model::new(coefficients).pressure((bits as u32) << 8);
    // To Q17, then rounded.
    let rounded = ((wide >> (fraction_bits + 15)) + 1) >> 1;
    Pressure::from_bits(i32::try_from(rounded).unwrap_or(i32::MAX))
}

/// What the model multiplies its coefficients with at `bend`, 0..=130 degrees: A/8, B/128 and α/2, each in 2⁻²⁸.
///
/// So scaled all three are about one at 113 degrees. Below 0 and above 130 degrees they are those of the end.
#[must_use]
pub(crate) fn regressors(bend: Bend) -> [i32; 3] {
    const END: i32 = 130 << 16;
    let bits = bend.to_bits().clamp(0, END);
    direct::regressors((bits as u32) << 8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::reference::{self, CALIBRATIONS, Limits};
    use crate::methods::{FloatingQuartic, SegmentNewton};
    use core::ops::RangeInclusive;
    use fixed::types::I8F24;
    use proptest::prelude::*;

    const LSB: f64 = 1.0 / 65_536.0;
    const DOMAIN_PRESSURE: i32 = 1000 << 16;
    const DOMAIN_BEND: i32 = 170 << 16;

    /// Both ways at one calibration, from bits to bits.
    struct Ways {
        coefficients: Coefficients,
        tabulated: Tabulated,
    }

    impl Ways {
        fn new(coefficients: Coefficients) -> Self {
            Self { coefficients, tabulated: Tabulated::new(&coefficients) }
        }

        fn of((k, c1, c2): (f64, f64, f64)) -> Self {
            Self::new(Coefficients::from_f64_kpa(k, c1, c2).unwrap())
        }

        fn bends(&self, bits: i32) -> [i32; 2] {
            let pressure = Pressure::from_bits(bits);
            [bend_from_pressure(&self.coefficients, pressure), self.tabulated.bend_from_pressure(pressure)]
                .map(Bend::to_bits)
        }

        fn pressures(&self, bits: i32) -> [i32; 2] {
            let bend = Bend::from_bits(bits);
            [pressure_from_bend(&self.coefficients, bend), self.tabulated.pressure_from_bend(bend)]
                .map(Pressure::to_bits)
        }
    }

    /// Neither way's output falls over the inputs of `range` in order.
    fn assert_never_falls(range: impl Iterator<Item = i32>, of: impl Fn(i32) -> [i32; 2]) {
        let mut last = [i32::MIN; 2];
        for bits in range {
            let value = of(bits);
            assert!(value[0] >= last[0] && value[1] >= last[1], "falls from {last:?} to {value:?} at {bits}");
            last = value;
        }
    }

    fn around(center: i32, radius: i32) -> RangeInclusive<i32> {
        center.saturating_sub(radius)..=center.saturating_add(radius)
    }

    #[test]
    fn errors_over_the_whole_domain() {
        reference::check::<SegmentNewton>(&[Limits { bend_deg: 4e-5, pressure_kpa: 3e-4 }; 3]);
        reference::check::<FloatingQuartic>(&[Limits { bend_deg: 2.5e-5, pressure_kpa: 3e-4 }; 3]);
    }

    /// The design's target is 0.001 degree and 0.001 kPa.
    #[test]
    fn errors_over_the_working_range() {
        let mut worst = [[0.0_f64; 2]; 2];
        for calibration in CALIBRATIONS {
            let ways = Ways::of(calibration);
            let c = &ways.coefficients;
            for bits in (1..3000).chain((1..=150 << 16).step_by(997)) {
                let exact = reference::bend_deg(c, f64::from(bits) * LSB);
                for (worst, found) in worst.iter_mut().zip(ways.bends(bits)) {
                    worst[0] = worst[0].max((f64::from(found) * LSB - exact).abs());
                }
            }
            for bits in (1..DOMAIN_BEND).step_by(97) {
                let exact = reference::pressure_kpa(c, f64::from(bits) * LSB);
                if exact > 150.0 {
                    break;
                }
                for (worst, found) in worst.iter_mut().zip(ways.pressures(bits)) {
                    worst[1] = worst[1].max((f64::from(found) * LSB - exact).abs());
                }
            }
        }
        println!(
            "0..150 kPa, any of the calibrations, degrees and kPa: for any calibration {:?}, tabulated {:?}",
            worst[0], worst[1]
        );
        assert!(worst[0][0] < 5e-5 && worst[1][0] < 2.5e-5 && worst[0][1] < 5e-5 && worst[1][1] < 5e-5, "{worst:?}");
    }

    #[test]
    fn the_first_bits_of_pressure_bend_by_the_square_root() {
        for calibration in CALIBRATIONS {
            let ways = Ways::of(calibration);
            assert_eq!((ways.bends(0), ways.pressures(0)), ([0; 2], [0; 2]));
            for bits in 1..100 {
                let exact = reference::bend_deg(&ways.coefficients, f64::from(bits) * LSB);
                for found in ways.bends(bits) {
                    assert!((f64::from(found) * LSB - exact).abs() < 3e-5, "{calibration:?} {bits}: {found} {exact}");
                }
            }
        }
    }

    #[test]
    fn saturates_outside_the_domain() {
        for calibration in CALIBRATIONS {
            let ways = Ways::of(calibration);
            let (most, end) = (ways.bends(DOMAIN_PRESSURE), ways.pressures(DOMAIN_BEND));
            for bits in [i32::MIN, i32::MIN + 1, -(100 << 16), -1, 0] {
                assert_eq!((ways.bends(bits), ways.pressures(bits)), ([0; 2], [0; 2]));
            }
            for bits in [DOMAIN_PRESSURE + 1, 2000 << 16, i32::MAX - 1, i32::MAX] {
                assert_eq!(ways.bends(bits), most);
            }
            for bits in [DOMAIN_BEND + 1, 180 << 16, 360 << 16, i32::MAX] {
                assert_eq!(ways.pressures(bits), end);
            }
            // Where 1000 kPa would bend further than the model goes.
            let reachable = reference::pressure_kpa(&ways.coefficients, 170.0);
            assert_eq!(most == [DOMAIN_BEND; 2], reachable <= 1000.0);
            assert_eq!(end == [i32::MAX; 2], reachable >= 32_768.0);
        }
    }

    #[test]
    fn never_falls() {
        for calibration in CALIBRATIONS {
            let ways = Ways::of(calibration);
            let (forward, inverse) = (|bits| ways.pressures(bits), |bits| ways.bends(bits));
            assert_never_falls((0..=DOMAIN_BEND).step_by(53), forward);
            assert_never_falls((0..=DOMAIN_PRESSURE).step_by(211), inverse);
            assert_never_falls(-10..100_000, forward);
            assert_never_falls(-10..100_000, inverse);
            assert_never_falls(around(DOMAIN_BEND, 50_000), forward);
            assert_never_falls(around(DOMAIN_PRESSURE, 50_000), inverse);
            assert_never_falls(around(256 << 16, 50_000), inverse);
            assert_never_falls(i32::MIN..i32::MIN + 1000, inverse);
            assert_never_falls(i32::MAX - 1000..=i32::MAX, forward);
            for degrees in (2..=170).step_by(2) {
                assert_never_falls(around(degrees << 16, 500), forward);
                assert_never_falls(around(ways.pressures(degrees << 16)[0], 500), inverse);
            }
            for part in 8..16 {
                for octave in 0..26 {
                    assert_never_falls(around((part << octave) >> 3, 500), inverse);
                }
            }
        }
    }

    #[test]
    fn regressors_are_the_functions_scaled() {
        for bits in (0..=130 << 16).step_by(9973) {
            let [alpha, a, b] = crate::calibration::basis(f64::from(bits) * LSB);
            let exact = [a / 8.0, b / 128.0, alpha / 2.0];
            for (found, exact) in regressors(Bend::from_bits(bits)).into_iter().zip(exact) {
                let found = f64::from(found) / f64::from(1 << 28);
                assert!((found - exact).abs() < 2e-6 * exact + 1e-8, "{bits}: {found} {exact}");
            }
        }
        assert_eq!(regressors(Bend::MIN), [0; 3]);
        assert_eq!(regressors(Bend::MAX), regressors(Bend::from_deg(130)));
    }

    #[test]
    fn the_table_of_one_calibration_takes_three_kilobytes() {
        assert!(size_of::<Tabulated>() <= 3072, "{}", size_of::<Tabulated>());
    }

    fn admitted() -> impl Strategy<Value = Coefficients> {
        (0..=60_i32 << 24, 5 << 24..=40_i32 << 24, 0..=2_i32 << 24).prop_map(|(k, c1, c2)| {
            Coefficients::new(I8F24::from_bits(k), I8F24::from_bits(c1), I8F24::from_bits(c2)).unwrap()
        })
    }

    /// Any pressure of the domain, small ones as often as large ones.
    fn any_pressure() -> impl Strategy<Value = i32> {
        (1..=DOMAIN_PRESSURE, 0..26_u32).prop_map(|(bits, shift)| (bits >> shift).max(1))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn any_calibration_matches_f64(c in admitted(), bits in any_pressure(), angle in 0..=DOMAIN_BEND) {
            let ways = Ways::new(c);
            let exact = reference::bend_deg(&c, f64::from(bits) * LSB);
            for found in ways.bends(bits) {
                prop_assert!((f64::from(found) * LSB - exact).abs() < 5e-5, "{found} {exact}");
            }
            let exact = reference::pressure_kpa(&c, f64::from(angle) * LSB);
            for found in ways.pressures(angle) {
                let found = f64::from(found) * LSB;
                if exact <= 150.0 {
                    prop_assert!((found - exact).abs() < 6e-5, "{found} {exact}");
                }
                // The formats of the last segments leave room for the stiffest finger.
                prop_assert!((found - exact.min(32_768.0)).abs() < 2e-4 + 4e-6 * exact, "{found} {exact}");
            }
        }

        #[test]
        fn any_calibration_never_falls(c in admitted(), bits in any_pressure(), angle in 0..DOMAIN_BEND) {
            let ways = Ways::new(c);
            assert_never_falls(around(bits, 50), |bits| ways.bends(bits));
            assert_never_falls(around(angle, 50), |bits| ways.pressures(bits));
        }

        #[test]
        fn there_and_back(c in admitted(), bits in any_pressure()) {
            // Pressure to bend to pressure: off by what five LSBs of bend are worth, and their like of pressure.
            let ways = Ways::new(c);
            for (way, found) in ways.bends(bits).into_iter().enumerate() {
                prop_assume!(found < DOMAIN_BEND);
                let degrees = f64::from(found) * LSB;
                let worth = reference::pressure_kpa(&c, degrees + 5.0 * LSB)
                    - reference::pressure_kpa(&c, (degrees - 5.0 * LSB).max(0.0));
                let back = ways.pressures(found)[way];
                prop_assert!(f64::from(back.abs_diff(bits)) <= worth / LSB + 5.0, "{bits} {found} {back}");
            }
        }
    }
}
