//! The firmware. Built for the board by `cargo xtask firmware`.
fn main() {}
