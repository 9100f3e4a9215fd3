//! The lengths of the finger's parts.

use crate::actuation::PerSegment;
use crate::units::Length;

/// Lengths of a finger's parts, hand first: a stiff base, then for each segment an arc that bends and a stiff link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chain {
    base: Length,
    arcs: PerSegment<Length>,
    links: PerSegment<Length>,
}

/// Lengths that make no finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChainError {
    /// This length is below zero.
    Negative(Length),
    /// All together are this long, more than [`Chain::LONGEST`].
    TooLong(Length),
}

impl Chain {
    /// The longest finger that the fixed-point formats hold, 500 mm.
    pub const LONGEST: Length = Length::from_mm(500);

    /// The paper's finger (Table 1): tail 7 mm, three chambers of 38 mm with 1 mm between them, head 7 mm.
    ///
    /// Together the 130 mm that Table 1 gives for the actuator, a check that they are to be read so.
    pub const PAPER: Self = {
        const fn mm(value: i16) -> Length {
            Length::from_mm(value)
        }
        match Self::new(mm(7), [mm(38); 3], [mm(1), mm(1), mm(7)]) {
            Ok(chain) => chain,
            Err(_) => panic!("the paper's lengths make no finger"),
        }
    };

    /// Checks the lengths.
    ///
    /// # Errors
    /// Names a length below zero, or the sum when it is above [`Chain::LONGEST`].
    pub const fn new(base: Length, arcs: PerSegment<Length>, links: PerSegment<Length>) -> Result<Self, ChainError> {
        let ([a, b, c], [d, e, f]) = (arcs, links);
        let parts = [base, a, b, c, d, e, f];
        let mut rest: &[Length] = &parts;
        let mut sum = 0_i64;
        while let [part, others @ ..] = rest {
            if part.to_bits() < 0 {
                return Err(ChainError::Negative(*part));
            }
            sum += part.to_bits() as i64;
            rest = others;
        }
        if sum > Self::LONGEST.to_bits() as i64 {
            let bits = if sum > i32::MAX as i64 { i32::MAX } else { sum as i32 };
            return Err(ChainError::TooLong(Length::from_bits(bits)));
        }
        Ok(Self { base, arcs, links })
    }

    /// From the hand to the first segment.
    #[must_use]
    pub const fn base(&self) -> Length {
        self.base
    }

    /// The segments that bend; their length is kept along the arc.
    #[must_use]
    pub const fn arcs(&self) -> PerSegment<Length> {
        self.arcs
    }

    /// What is stiff behind each segment.
    #[must_use]
    pub const fn links(&self) -> PerSegment<Length> {
        self.links
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_parts_are_as_long_as_its_actuator() {
        let Chain { base, arcs, links } = Chain::PAPER;
        let sum = arcs.into_iter().chain(links).fold(base, |sum, part| sum + part);
        assert_eq!(sum, Length::from_mm(130));
    }

    #[test]
    fn lengths_that_make_no_finger_are_named() {
        let (zero, short) = (Length::ZERO, Length::from_mm(40));
        let negative = Length::from_um(-1);
        assert_eq!(Chain::new(zero, [short, negative, short], [zero; 3]), Err(ChainError::Negative(negative)));
        let sum = Length::from_mm(520);
        assert_eq!(Chain::new(Length::from_mm(400), [short; 3], [zero; 3]), Err(ChainError::TooLong(sum)));
        assert_eq!(Chain::new(Length::MAX, [Length::MAX; 3], [zero; 3]), Err(ChainError::TooLong(Length::MAX)));
        assert!(Chain::new(zero, [zero; 3], [zero; 3]).is_ok());
    }
}
