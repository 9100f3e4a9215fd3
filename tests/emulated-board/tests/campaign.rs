//! The campaign in small, on the firmware's ELF: random machines, programs and faults, judged at the pins and by the plant.
//! More of it: `cargo run -p emulated-board --bin campaign -- --runs N --seed S`.

use emulated_board::campaign::{Options, run_all};
use emulated_board::firmware_elf;
use std::collections::BTreeMap;

/// How many runs, and which: those of one seed with short programs, so that a machine of two cores makes them in a minute.
const OPTIONS: Options = Options { seed: 2026, runs: 16, longest_ms: Some(12_000) };

#[test]
fn nothing_is_violated_on_the_board() {
    let part = run_all(&firmware_elf().expect("built"), &OPTIONS).expect("the board is modelled");
    let text = host_sim::campaign::text(&part);
    println!("{text}");
    assert_eq!(part.result.violated(), 0, "{text}");
    // Most of the runs have faults, and those are seen: a judge that hears nothing would find nothing violated.
    let cells = part.result.matrix.values().flat_map(BTreeMap::values).chain(part.result.two_at_once.values());
    let detected: u64 = cells.map(|cell| cell.detected).sum();
    assert!(detected >= OPTIONS.runs / 3, "{detected} faults detected; {text}");
}
