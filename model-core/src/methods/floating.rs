//! Segments that narrow towards zero: the leading zeros of the input choose the octave, the bits behind its first one the
//! segment. Each octave has a number of segments of its own, a power of two, so that the error can be levelled.

/// Where an input lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The segment.
    pub index: usize,
    /// The input less the segment's lower end.
    pub offset: u32,
    /// The segment's width is 2 to this power.
    pub shift: u32,
}

/// One octave: inputs from 2^e to 2^(e + 1).
#[derive(Clone, Copy, Debug)]
struct Octave {
    shift: u8,
    /// The index of the segment at 0, were the octave's segments to start there.
    base: i16,
}

/// How the segments lie; a constant, in flash.
#[derive(Debug)]
pub struct Layout<const OCTAVES: usize> {
    /// The exponent of the first octave.
    first: u32,
    octaves: [Octave; OCTAVES],
    count: usize,
}

impl<const OCTAVES: usize> Layout<OCTAVES> {
    /// Octave by octave from 2^`first` on the number of segments, as a power of two, of which those from the input
    /// `smallest` to `largest` are counted.
    pub const fn new(first: u32, bits: [u8; OCTAVES], smallest: u32, largest: u32) -> Self {
        let mut octaves = [Octave { shift: 0, base: 0 }; OCTAVES];
        // As many before as there are from the first octave's start to the smallest input.
        let mut next = -(((smallest - (1 << first)) >> (first - bits[0] as u32)) as i32);
        let mut i = 0;
        while i < OCTAVES {
            let exponent = first + i as u32;
            octaves[i] = Octave { shift: (exponent - bits[i] as u32) as u8, base: (next - (1 << bits[i])) as i16 };
            next += 1 << bits[i];
            i += 1;
        }
        // The last octave ends early.
        let last = octaves[OCTAVES - 1];
        let count = ((largest - 1) >> last.shift) as i32 + last.base as i32 + 1;
        Self { first, octaves, count: count as usize }
    }

    /// How many segments there are.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Where `input` lies, which is not below the smallest or above the largest; the largest may be the end of the last
    /// segment, one index beyond.
    pub fn place(&self, input: u32) -> Place {
        let octave = 31_u32.saturating_sub(input.leading_zeros()).saturating_sub(self.first) as usize;
        let Some(&Octave { shift, base }) = self.octaves.get(octave) else {
            return Place { index: 0, offset: 0, shift: 0 };
        };
        let shift = u32::from(shift);
        let index = (input >> shift) as i32 + i32::from(base);
        Place { index: usize::try_from(index).unwrap_or(0), offset: input & ((1 << shift) - 1), shift }
    }

    /// Calls `visit` with the index, lower end and width of each segment.
    pub fn for_each(&self, smallest: u32, mut visit: impl FnMut(usize, u32, u32)) {
        let mut low = smallest;
        for index in 0..self.count {
            let width = 1 << self.place(low).shift;
            visit(index, low, width);
            low += width;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_input_lies_in_one_segment_and_the_segments_join() {
        const PRESSURES: Layout<26> = Layout::new(
            0,
            [0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 6, 6, 6, 6],
            1,
            1000 << 16,
        );
        const RESTS: Layout<5> = Layout::new(19, [6, 6, 6, 8, 7], 10 << 16, 180 << 16);
        let mut next = 1;
        PRESSURES.for_each(1, |index, low, width| {
            assert_eq!(low, next);
            for input in [low, low + width / 2, low + width - 1] {
                let place = PRESSURES.place(input);
                assert_eq!((place.index, place.offset, 1 << place.shift), (index, input - low, width));
            }
            next = low + width;
        });
        assert_eq!(next, 1000 << 16);
        assert_eq!(PRESSURES.place(1000 << 16).index, PRESSURES.count());
        let mut next = 10 << 16;
        RESTS.for_each(10 << 16, |index, low, width| {
            assert_eq!(low, next);
            assert_eq!(RESTS.place(low), Place { index, offset: 0, shift: width.trailing_zeros() });
            next = low + width;
        });
        assert_eq!(next, 180 << 16);
    }
}
