//! Division that suits the Cortex-M4: its divider takes 32 bits, and a 64-bit division costs it a hundred instructions and
//! more.

use fixed::types::I16F16;

/// The quotient, rounded towards zero; `None` for a zero divisor or a quotient beyond the type. The same as
/// [`I16F16::checked_div`] for every pair of operands, in five hardware divisions when the divisor is positive and below
/// 2048.
#[must_use]
pub fn divide(dividend: I16F16, divisor: I16F16) -> Option<I16F16> {
    let divisor_bits = divisor.to_bits();
    if !(1..1 << 27).contains(&divisor_bits) {
        return dividend.checked_div(divisor);
    }
    let d = divisor_bits.unsigned_abs();
    let n = dividend.to_bits().unsigned_abs();
    let whole = n / d;
    // Long division: five bits at a time, because a remainder below 2^27 shifted by five still has 32 bits.
    let (mut rest, mut fraction) = (n % d, 0);
    for bits in [5, 5, 5, 1] {
        let shifted = rest << bits;
        fraction = (fraction << bits) | (shifted / d);
        rest = shifted % d;
    }
    if whole >= 1 << 15 {
        // At the edge of the type the sign decides.
        return dividend.checked_div(divisor);
    }
    let magnitude = ((whole << 16) | fraction) as i32;
    Some(I16F16::from_bits(if dividend.is_negative() { -magnitude } else { magnitude }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn corners() {
        let corners = [i32::MIN, i32::MIN + 1, -65_536, -1, 0, 1, 2, 65_535, 65_536, (1 << 27) - 1, 1 << 27, i32::MAX];
        for n in corners.map(I16F16::from_bits) {
            for d in corners.map(I16F16::from_bits) {
                assert_eq!(divide(n, d), n.checked_div(d), "{n:?} / {d:?}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100_000))]
        #[test]
        fn the_same_as_the_wide_division(n: i32, d: i32, shift in 0_u32..31) {
            let (n, d) = (I16F16::from_bits(n), I16F16::from_bits(d >> shift));
            prop_assert_eq!(divide(n, d), n.checked_div(d));
        }
    }
}
