//! What the tests that cross crates share: the table of high-precision values and the exhaustive run; see `tests/` and
//! `src/bin/`.

pub mod exhaustive;
pub mod faults;
pub mod truth;
