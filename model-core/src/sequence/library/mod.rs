//! The built-in sequences.
//!
//! ```
//! use model_core::sequence::library;
//!
//! let grasp = library::find("grasp").expect("built in");
//! assert_eq!(grasp.repeats(), 3);
//! ```

use super::{Sequence, Step};

// Sequences with a file of their own, one line each; `cargo xtask new-sequence NAME` writes file and line.

/// Up to 150 kPa in 3 s, held for 4 s, down in 3 s, 1 s of rest: the paper's combinations.
const fn combination(kpa: [i16; 3]) -> [Step; 2] {
    [Step::kpa(kpa).ramp_ms(3000).hold_ms(4000), Step::kpa([0; 3]).ramp_ms(3000).hold_ms(1000)]
}

/// One joint to 60 degrees and back, slowly.
const fn isolated(deg: [i16; 3]) -> [Step; 2] {
    [Step::deg(deg).ramp_ms(3000).hold_ms(3000), Step::deg([0; 3]).ramp_ms(3000).hold_ms(2000)]
}

static PROXIMAL: Sequence =
    Sequence::new("proximal", "150 kPa in the proximal segment (paper, figure 25)", &combination([150, 0, 0]), 1);
static MIDDLE: Sequence = Sequence::new("middle", "150 kPa in the middle segment", &combination([0, 150, 0]), 1);
static DISTAL: Sequence = Sequence::new("distal", "150 kPa in the distal segment", &combination([0, 0, 150]), 1);
static PROXIMAL_MIDDLE: Sequence =
    Sequence::new("proximal-middle", "150 kPa in the proximal and middle segments", &combination([150, 150, 0]), 1);
static PROXIMAL_DISTAL: Sequence =
    Sequence::new("proximal-distal", "150 kPa in the proximal and distal segments", &combination([150, 0, 150]), 1);
static MIDDLE_DISTAL: Sequence =
    Sequence::new("middle-distal", "150 kPa in the middle and distal segments", &combination([0, 150, 150]), 1);
static ALL_SEGMENTS: Sequence = Sequence::new("all", "150 kPa in all three segments", &combination([150; 3]), 1);

static RECONFIGURE: Sequence = Sequence::new(
    "reconfigure",
    "The paper's reconfiguration: proximal 60, middle 30, distal 60 kPa",
    &[Step::kpa([60, 30, 60]).ramp_ms(2000).hold_ms(5000), Step::kpa([0; 3]).ramp_ms(2000).hold_ms(1000)],
    1,
);

static STAIRCASE: Sequence = Sequence::new(
    "staircase",
    "0 to 150 kPa and back in steps of 30 kPa, all segments: the paper's measurement",
    &[
        Step::kpa([30; 3]).hold_ms(3000),
        Step::kpa([60; 3]).hold_ms(3000),
        Step::kpa([90; 3]).hold_ms(3000),
        Step::kpa([120; 3]).hold_ms(3000),
        Step::kpa([150; 3]).hold_ms(3000),
        Step::kpa([120; 3]).hold_ms(3000),
        Step::kpa([90; 3]).hold_ms(3000),
        Step::kpa([60; 3]).hold_ms(3000),
        Step::kpa([30; 3]).hold_ms(3000),
        Step::kpa([0; 3]).hold_ms(3000),
    ],
    1,
);

static GRASP: Sequence = Sequence::new(
    "grasp",
    "Close the hand joint after joint, hold, open; three times",
    &[
        Step::deg([45, 30, 15]).ramp_ms(2000).hold_ms(2000),
        Step::deg([70, 80, 50]).ramp_ms(2500).hold_ms(3000),
        Step::deg([45, 30, 15]).ramp_ms(2500).hold_ms(2000),
        Step::deg([0; 3]).ramp_ms(2000).hold_ms(2000),
    ],
    3,
);

static WAVE: Sequence = Sequence::new(
    "wave",
    "One joint after the other, from the hand outwards; twice",
    &[
        Step::deg([60, 0, 0]).ramp_ms(2000).hold_ms(1500),
        Step::deg([0, 60, 0]).ramp_ms(2500).hold_ms(1500),
        Step::deg([0, 0, 60]).ramp_ms(2500).hold_ms(1500),
        Step::deg([0; 3]).ramp_ms(2000).hold_ms(1000),
    ],
    2,
);

static ISOLATED_MCP: Sequence =
    Sequence::new("isolated-mcp", "The proximal joint alone to 60 degrees, five times", &isolated([60, 0, 0]), 5);
static ISOLATED_PIP: Sequence =
    Sequence::new("isolated-pip", "The middle joint alone to 60 degrees, five times", &isolated([0, 60, 0]), 5);
static ISOLATED_DIP: Sequence =
    Sequence::new("isolated-dip", "The distal joint alone to 60 degrees, five times", &isolated([0, 0, 60]), 5);

/// One segment alone up to 150 kPa by 30, long enough at each for the identification's points, and back to empty.
const fn alone(kpa: [i16; 3]) -> [Step; 6] {
    const fn part([p, m, d]: [i16; 3], of_5: i16) -> Step {
        Step::kpa([p / 5 * of_5, m / 5 * of_5, d / 5 * of_5])
    }
    [
        part(kpa, 1).hold_ms(3000),
        part(kpa, 2).hold_ms(3000),
        part(kpa, 3).hold_ms(3000),
        part(kpa, 4).hold_ms(3000),
        part(kpa, 5).hold_ms(3000),
        Step::kpa([0; 3]).ramp_ms(1500).hold_ms(2500),
    ]
}

const CALIBRATE_STEPS: [Step; 18] = {
    let [p, m, d] = [alone([150, 0, 0]), alone([0, 150, 0]), alone([0, 0, 150])];
    [p[0], p[1], p[2], p[3], p[4], p[5], m[0], m[1], m[2], m[3], m[4], m[5], d[0], d[1], d[2], d[3], d[4], d[5]]
};

static CALIBRATE: Sequence = Sequence::new(
    "calibrate",
    "Each segment alone to 150 kPa by 30: for its coefficients to be identified",
    &CALIBRATE_STEPS,
    1,
)
.for_identification();

/// All built-in sequences.
pub static ALL: [&Sequence; 15] = [
    &RECONFIGURE,
    &STAIRCASE,
    &PROXIMAL,
    &MIDDLE,
    &DISTAL,
    &PROXIMAL_MIDDLE,
    &PROXIMAL_DISTAL,
    &MIDDLE_DISTAL,
    &ALL_SEGMENTS,
    &GRASP,
    &WAVE,
    &ISOLATED_MCP,
    &ISOLATED_PIP,
    &ISOLATED_DIP,
    &CALIBRATE,
];

/// The built-in sequence of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Sequence> {
    ALL.iter().find(|sequence| sequence.name == name).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_found() {
        for (index, sequence) in ALL.iter().enumerate() {
            assert_eq!(find(sequence.name).map(|found| found.name), Some(sequence.name));
            assert!(ALL.iter().skip(index + 1).all(|other| other.name != sequence.name), "{}", sequence.name);
        }
        assert!(find("no-such-sequence").is_none());
    }

    #[test]
    fn the_papers_seven_combinations_are_here() {
        let tops: Vec<_> = ALL.iter().filter_map(|s| s.steps().first()).map(|step| step.target).collect();
        for mask in 1..8_u8 {
            let kpa = [0, 1, 2].map(|bit| if mask >> bit & 1 == 1 { 150 } else { 0 });
            assert!(tops.contains(&Step::kpa(kpa).target), "{kpa:?}");
        }
    }
}
