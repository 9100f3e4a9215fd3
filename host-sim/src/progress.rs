//! Progress of long work.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;

/// Counts `what` on a terminal, and is silent elsewhere.
#[must_use]
pub fn bar(length: usize, what: &str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(&format!("{{bar:40}} {{pos:>3}} of {{len}} {what} {{msg}}"));
    ProgressBar::new(length as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
