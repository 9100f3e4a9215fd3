//! Bang-bang with a dead band, round robin: one chamber at a time, its valve fully open until it has arrived.

use super::front::{Front, FrontGains, Wish};
use crate::compare::trial::Contender;
use model_core::actuation::{Actuation, PerSegment};
use model_core::observer::Pneumatics;
use model_core::units::Pressure;

/// Its own figures.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// A chamber is served when it is off by more, kPa.
    pub dead_band_kpa: f64,
    /// Until so much is missing, kPa.
    pub stop_kpa: f64,
    /// And no longer than this while others wait, ms.
    pub turn_ms: f64,
}

/// See the module's page.
pub struct BangBang {
    front: Front,
    law: Law,
    /// What each chamber wants.
    directions: [i8; 3],
    turn: usize,
    turn_ticks: u32,
}

impl BangBang {
    /// Vented.
    #[must_use]
    pub fn new(front: FrontGains, law: Law) -> Self {
        Self { front: Front::new(front), law, directions: [0; 3], turn: 0, turn_ticks: 0 }
    }
}

impl Contender for BangBang {
    fn know(&mut self, pneumatics: Pneumatics) {
        self.front.know(pneumatics);
    }

    fn step(&mut self, references: PerSegment<Pressure>, manifold: Pressure) -> Actuation {
        let view = self.front.observe(references, manifold);
        for (i, direction) in self.directions.iter_mut().enumerate() {
            let error = view.references_kpa[i] - view.chambers_kpa[i];
            let missing = f64::from(*direction) * (view.references_kpa[i] - view.ahead_kpa[i]);
            if *direction != 0 && missing <= self.law.stop_kpa {
                *direction = 0;
            }
            if *direction == 0 && error.abs() > self.law.dead_band_kpa && missing <= 0.0 {
                *direction = if error > 0.0 { 1 } else { -1 };
            }
        }
        self.turn_ticks = self.turn_ticks.saturating_add(1);
        let others = (1..3).map(|step| (self.turn + step) % 3).find(|&i| self.directions[i] != 0);
        let over = self.directions[self.turn] == 0 || f64::from(self.turn_ticks) >= self.law.turn_ms;
        if let (true, Some(next)) = (over, others) {
            (self.turn, self.turn_ticks) = (next, 0);
        }
        let mut wishes = [Wish::default(); 3];
        wishes[self.turn] = Wish { direction: self.directions[self.turn], open: true };
        self.front.act(&view, wishes)
    }

    fn estimates_kpa(&self) -> [f64; 3] {
        self.front.estimates_kpa()
    }
}
