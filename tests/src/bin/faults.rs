//! Prints the fault table in Markdown: what `cargo xtask faults` puts into docs/faults.md.

fn main() {
    print!("{}", finger_tests::faults::markdown());
}
