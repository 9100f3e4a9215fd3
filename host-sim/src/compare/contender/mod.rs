//! The regulators that are compared: ours, and its peers.

pub mod bang_bang;
pub mod front;
pub mod gains;
pub mod guard;
pub mod ours;
pub mod pid;
pub mod pwm;
pub mod sliding_mode;
mod tuned;

use super::trial::Contender;
use gains::{FRONT, Range};

/// One of the regulators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Bang-bang with dead band, round robin.
    BangBang,
    /// PWM with PID.
    PwmPid,
    /// Dual-mode sliding mode.
    SlidingMode,
    /// The core's.
    Ours,
}

impl Kind {
    /// All of them, in the tables' order.
    pub const ALL: [Self; 4] = [Self::BangBang, Self::PwmPid, Self::SlidingMode, Self::Ours];
    /// Those that are tuned.
    pub const PEERS: [Self; 3] = [Self::BangBang, Self::PwmPid, Self::SlidingMode];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::BangBang => "bang-bang",
            Self::PwmPid => "pwm-pid",
            Self::SlidingMode => "sliding-mode",
            Self::Ours => "ours",
        }
    }

    /// What of it is tuned: the front's figures and its own; nothing of ours.
    #[must_use]
    pub fn ranges(self) -> Vec<Range> {
        match self {
            Self::BangBang => gains::ranges(&gains::BANG_BANG),
            Self::PwmPid => gains::ranges(&gains::PWM_PID),
            Self::SlidingMode => gains::ranges(&gains::SLIDING_MODE),
            Self::Ours => Vec::new(),
        }
    }

    /// The figures that tuning has found, in the ranges' order.
    #[must_use]
    pub fn tuned(self) -> Vec<f64> {
        match self {
            Self::BangBang => tuned::BANG_BANG.to_vec(),
            Self::PwmPid => tuned::PWM_PID.to_vec(),
            Self::SlidingMode => tuned::SLIDING_MODE.to_vec(),
            Self::Ours => Vec::new(),
        }
    }

    /// A fresh one as it is tuned.
    #[must_use]
    pub fn make(self) -> Box<dyn Contender> {
        self.make_with(&self.tuned())
    }

    /// A fresh one with other figures, in the ranges' order; missing ones are 0.
    #[must_use]
    pub fn make_with(self, values: &[f64]) -> Box<dyn Contender> {
        let front = gains::front(&part(values, 0));
        match self {
            Self::BangBang => Box::new(bang_bang::BangBang::new(front, gains::bang_bang(&part(values, FRONT)))),
            Self::PwmPid => Box::new(pid::PwmPid::new(front, gains::pid(&part(values, FRONT)))),
            Self::SlidingMode => {
                Box::new(sliding_mode::SlidingMode::new(front, gains::sliding_mode(&part(values, FRONT))))
            }
            Self::Ours => Box::new(ours::Ours::new()),
        }
    }
}

fn part<const N: usize>(values: &[f64], from: usize) -> [f64; N] {
    core::array::from_fn(|i| values.get(from + i).copied().unwrap_or(0.0))
}
