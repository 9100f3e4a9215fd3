//! Writes `tests/data/truth.csv`, the table of true values; started by `cargo xtask truth`.

use anyhow::{Context, Result};
use finger_tests::truth::table;
use indicatif::ProgressBar;

fn main() -> Result<()> {
    let bar = ProgressBar::new(table::rows() as u64);
    let text = table::write(|| bar.inc(1));
    bar.finish_and_clear();
    let path = table::path();
    std::fs::write(&path, &text).with_context(|| format!("cannot write {}", path.display()))?;
    println!("tests/data/truth.csv: {} rows, {} bytes", table::rows(), text.len());
    Ok(())
}
