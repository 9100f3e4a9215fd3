use super::*;
use model_core::controller::Controller;

#[test]
fn placeholder_runs() {
    let campaign = Campaign { schema: shard::SCHEMA, seed: 1, runs: 20, fault: None, sequence: None };
    let tally = run_all::<Controller>(&campaign, Shard::WHOLE, &ProgressBar::hidden());
    assert_eq!(tally.runs, 20);
}
