//! A setpoint that moves, and where it will be.

use crate::units::Pressure;
use fixed::types::I16F16;

/// A setpoint that moved by more in one tick has jumped: no ramp or sine is so fast.
const JUMP: Pressure = Pressure::from_kpa(1);
/// Ticks after its last move for which a setpoint counts as moving.
const STILL_TICKS: u32 = 30;

/// One segment's setpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Setpoint {
    pub value: Pressure,
    /// kPa per tick, over about 16 ticks.
    slope: I16F16,
    /// Ticks since it moved last without a jump.
    still: u32,
}

impl Setpoint {
    pub(super) const ZERO: Self = Self { value: Pressure::ZERO, slope: I16F16::ZERO, still: STILL_TICKS };

    /// The next tick's value; true when it has jumped.
    pub(super) fn take(&mut self, new: Pressure) -> bool {
        let change = new - self.value;
        self.value = new;
        if change.abs() > JUMP {
            (self.slope, self.still) = (I16F16::ZERO, STILL_TICKS);
            return true;
        }
        self.still = if change == Pressure::ZERO { self.still.saturating_add(1) } else { 0 };
        let missing = change.to_fixed().saturating_sub(self.slope);
        self.slope = self.slope.saturating_add(missing >> 4);
        false
    }

    pub(super) const fn moves(&self) -> bool {
        self.still < STILL_TICKS
    }

    /// Whether it moves, and not upwards (`rise`) or not downwards.
    pub(super) fn recedes(&self, rise: bool) -> bool {
        if rise { self.slope < I16F16::ZERO } else { self.slope > I16F16::ZERO }
    }

    /// Where it will be, if it goes on.
    pub(super) fn after(&self, ticks: u8) -> Pressure {
        if !self.moves() {
            return self.value;
        }
        let on = self.slope.saturating_mul(I16F16::from_num(ticks));
        (self.value + Pressure::from_fixed(on)).clamp(Pressure::ZERO, Pressure::from_kpa(150))
    }
}
