//! The regulators that are compared: ours, and its peers.

pub mod ours;

use super::trial::Contender;
use serde::Serialize;

/// One of the regulators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The core's.
    Ours,
}

impl Kind {
    /// All of them, in the tables' order.
    pub const ALL: [Self; 1] = [Self::Ours];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
        }
    }

    /// A fresh one.
    #[must_use]
    pub fn make(self) -> Box<dyn Contender> {
        match self {
            Self::Ours => Box::new(ours::Ours::new()),
        }
    }
}
