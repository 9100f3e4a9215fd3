//! Pulse width modulation of a chamber's valve: what the PID and the sliding mode hand their duty to.

use super::front::Wish;

/// Shortest opening, ms: a valve's shortest time.
const SHORTEST_MS: f64 = 3.0;

/// One valve's modulator.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pwm {
    ticks: u32,
    direction: i8,
    /// Opening that is left in this period, ms.
    left_ms: f64,
}

impl Pwm {
    /// One tick; `duty` (-1..=1, its sign is the direction) is asked for when a period begins, `served` tells whether the valve was
    /// open in the last tick.
    pub fn step(&mut self, period_ms: f64, served: bool, duty: f64) -> Wish {
        if served {
            self.left_ms -= 1.0;
        }
        let over = f64::from(self.ticks) >= period_ms || self.direction == 0;
        let turned = self.direction != 0 && duty * f64::from(self.direction) < 0.0;
        if over || turned {
            let on_ms = duty.abs().min(1.0) * period_ms;
            self.ticks = 0;
            self.direction = if on_ms < SHORTEST_MS { 0 } else { duty.signum() as i8 };
            self.left_ms = on_ms;
        }
        self.ticks = self.ticks.saturating_add(1);
        Wish { direction: self.direction, open: self.left_ms >= 0.5 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_duty_is_the_share_of_time_and_short_pulses_are_left_out() {
        for (duty, expected) in [(0.5, 100), (-0.25, 50), (1.0, 200), (0.1, 0)] {
            let (mut pwm, mut served, mut open) = (Pwm::default(), false, 0);
            for _ in 0..200 {
                let wish = pwm.step(20.0, served, duty);
                served = wish.open && wish.direction != 0;
                open += i32::from(served);
                assert!(!served || wish.direction == duty.signum() as i8);
            }
            assert_eq!(open, expected, "{duty}");
        }
    }
}
