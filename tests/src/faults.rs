//! The fault table as the documents show it.

use model_core::supervisor::fault::{Action, Clearing, Row};
use model_core::supervisor::table::TABLE;
use std::fmt::Write;

/// The table in Markdown, a line a fault.
#[must_use]
pub fn markdown() -> String {
    let mut text = String::from(
        "| Code | Fault | Found when | Within, ms | Action | Priority | Can be cleared when |\n|---|---|---|---|---|---|---|\n",
    );
    for row in &TABLE {
        let Row { fault, condition, detect_within_ms, priority, clears_when, .. } = row;
        let action = match row.action {
            Action::Vent => "vent",
            Action::FallBackToPressure => "go on by pressure",
            Action::Warn => "go on",
        };
        let test = match row.clearing {
            Clearing::Command => "",
            Clearing::CommandThenSelfTest => "; self test",
        };
        let (code, priority) = (fault.code(), priority.name());
        let _ = writeln!(
            text,
            "| {code} | {fault:?} | {condition} | {detect_within_ms} | {action} | {priority} | {clears_when}{test} |"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_page_shows_the_table_of_the_code() {
        let page = include_str!("../../docs/faults.md");
        assert!(page.contains(&super::markdown()), "renew it: cargo xtask faults");
    }
}
