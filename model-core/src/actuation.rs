//! What the controller does to the machine, and the safe state.

use serde::{Deserialize, Serialize};

/// The finger's segments, from the hand outwards. Arrays of three are in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Segment {
    /// At the metacarpophalangeal joint (MCP).
    Proximal = 0,
    /// At the proximal interphalangeal joint (PIP).
    Middle = 1,
    /// At the distal interphalangeal joint (DIP).
    Distal = 2,
}

impl Segment {
    /// All three, from the hand outwards.
    pub const ALL: [Self; 3] = [Self::Proximal, Self::Middle, Self::Distal];

    /// The lower-case name used in commands and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Proximal => "proximal",
            Self::Middle => "middle",
            Self::Distal => "distal",
        }
    }
}

/// One value for each segment, proximal first.
pub type PerSegment<T> = [T; 3];

/// A 2/2 valve's passage. The board translates it to an energised or a resting coil.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Passage {
    /// Air passes. The default: the machine's valves are normally open.
    #[default]
    Open,
    /// Air is shut off.
    Closed,
}

/// Everything the controller drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Actuation {
    /// The air pump's relay: true runs the pump.
    pub pump: bool,
    /// The dump valve, from the manifold to the atmosphere.
    pub dump: Passage,
    /// The segments' valves, from the manifold to each chamber.
    pub segments: PerSegment<Passage>,
}

impl Actuation {
    /// Vented: pump off, every passage open. With normally open valves this is every output de-energised.
    pub const SAFE: Self = Self { pump: false, dump: Passage::Open, segments: [Passage::Open; 3] };
    /// Held: pump off, every passage closed.
    pub const HOLD: Self = Self { pump: false, dump: Passage::Closed, segments: [Passage::Closed; 3] };
}

impl Default for Actuation {
    /// The safe state.
    fn default() -> Self {
        Self::SAFE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_vented() {
        assert_eq!(Actuation::default(), Actuation::SAFE);
        assert_eq!([Passage::default(); 3], Actuation::SAFE.segments);
        assert_ne!(Actuation::SAFE, Actuation::HOLD);
    }
}
