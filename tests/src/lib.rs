//! What the tests that cross crates share: the table of high-precision values, the exhaustive run, the fault table as text; see
//! `tests/` and `src/bin/`.
//!
//! ```
//! // Every fault has a row in docs/faults.md, which `cargo xtask faults` renews from this text.
//! let table = finger_tests::faults::markdown();
//! assert!(table.contains("| 4 | EmergencyStop |"));
//! ```
//!
//! ```text
//! cargo test -p finger-tests                          all of tests/
//! cargo test -p finger-tests --test closed_loop       the core against the simulated finger
//! cargo xtask truth                                   tests/data/truth.csv anew, 50 digits a value
//! cargo xtask exhaustive -- --help                    every one of the 2^32 inputs
//! ```

pub mod exhaustive;
pub mod faults;
pub mod truth;
