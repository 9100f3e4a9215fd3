//! Ours: the core's regulator and observer as they are, with nothing tuned here.

use crate::compare::trial::Contender;
use model_core::actuation::{Actuation, PerSegment};
use model_core::observer::{Observer, Pneumatics};
use model_core::regulator::Regulator;
use model_core::units::Pressure;

/// The core's regulator.
pub struct Ours {
    observer: Observer,
    regulator: Regulator,
}

impl Ours {
    /// Vented.
    #[must_use]
    pub fn new() -> Self {
        Self { observer: Observer::new(Pneumatics::NOMINAL), regulator: Regulator::new() }
    }
}

impl Default for Ours {
    fn default() -> Self {
        Self::new()
    }
}

impl Contender for Ours {
    fn know(&mut self, pneumatics: Pneumatics) {
        self.observer = Observer::new(pneumatics);
    }

    fn step(&mut self, references: PerSegment<Pressure>, manifold: Pressure) -> Actuation {
        self.observer.measure(manifold);
        let actuation = self.regulator.step(references, &mut self.observer);
        self.observer.commanded(&actuation);
        actuation
    }

    fn estimates_kpa(&self) -> [f64; 3] {
        self.observer.chambers().map(Pressure::to_f64)
    }
}
