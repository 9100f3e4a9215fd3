//! The sequence `new-sequence`.

use model_core::sequence::{Sequence, Step};

/// What the finger does, step by step, from rest: to the target in a straight line (`ramp_ms`), then stay (`hold_ms`).
///
/// `Step::kpa` takes the gauge pressures of the proximal, middle and distal chamber, each 0 to 150 kPa; `Step::deg` takes
/// the bends of the segments instead, each 0 to 110 degrees. A ramp changes by at most 100 kPa or 75 degrees a second; a
/// step without a ramp by at most 30 kPa or 25 degrees. The last step ends at zero.
const STEPS: &[Step] = &[
    Step::kpa([30, 15, 30]).ramp_ms(1500).hold_ms(2000),
    Step::kpa([60, 30, 60]).ramp_ms(1500).hold_ms(3000),
    Step::kpa([0, 0, 0]).ramp_ms(2000).hold_ms(1000),
];

/// Name, one line for people, the steps, and how often they are run.
pub static SEQUENCE: Sequence = Sequence::new("new-sequence", "In two steps to 60/30/60 kPa and back", STEPS, 1);
