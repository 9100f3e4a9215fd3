//! Command line of the simulated finger.
fn main() {}
