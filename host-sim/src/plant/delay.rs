//! A pure dead time.

/// Hands on each value a fixed number of ticks late.
#[derive(Clone, Debug)]
pub struct Delay<T> {
    line: Box<[T]>,
    next: usize,
    last: T,
    /// How often in a row `last` has come in; no more than the line's length, when it fills the line.
    same: usize,
}

impl<T: Copy + PartialEq> Delay<T> {
    /// A delay of `ticks` (1 ms each), filled with `initial`; zero ticks hand values straight through.
    #[must_use]
    pub fn new(ticks: u32, initial: T) -> Self {
        let ticks = ticks as usize;
        Self { line: vec![initial; ticks].into_boxed_slice(), next: 0, last: initial, same: ticks }
    }

    /// Takes this tick's value and returns the one that now comes out.
    #[inline]
    pub fn step(&mut self, value: T) -> T {
        let length = self.line.len();
        // Actuators rest most of the time: a line that holds nothing else need not turn.
        if value != self.last {
            self.same = 0;
            self.last = value;
        } else if self.same == length {
            return value;
        }
        self.same += 1;
        let Some(slot) = self.line.get_mut(self.next) else {
            return value;
        };
        self.next = if self.next + 1 == length { 0 } else { self.next + 1 };
        core::mem::replace(slot, value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_value_comes_out_exactly_so_many_ticks_late(
            ticks in 0_u32..40,
            values in prop::collection::vec(1_u32.., 1..200),
        ) {
            let mut delay = Delay::new(ticks, 0);
            for (tick, &value) in values.iter().enumerate() {
                let expected = tick.checked_sub(ticks as usize).map_or(0, |earlier| values[earlier]);
                prop_assert_eq!(delay.step(value), expected);
            }
        }
    }
}
