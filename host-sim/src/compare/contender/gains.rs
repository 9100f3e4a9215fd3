//! The peers' figures as found by `host-sim compare --tune`, and the ranges it searches.

use super::{bang_bang, front::FrontGains, pid, sliding_mode};

/// A figure to be tuned.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// Its name, with unit.
    pub name: &'static str,
    /// Least value, above 0.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Where the search starts: set by hand.
    pub start: f64,
}

const fn range(name: &'static str, low: f64, high: f64, start: f64) -> Range {
    Range { name, low, high, start }
}

/// Figures of the front.
pub const FRONT: usize = 8;

/// The front's ranges: they come first for each peer.
const FRONT_RANGES: [Range; FRONT] = [
    range("supply_floor_kpa", 1.0, 60.0, 10.0),
    range("supply_per_error", 0.05, 10.0, 2.0),
    range("supply_hysteresis_kpa", 0.5, 30.0, 5.0),
    range("slot_ms", 20.0, 1000.0, 200.0),
    range("lead_ms", 1.0, 40.0, 12.0),
    range("match_kpa", 0.5, 6.0, 2.0),
    range("look_ms", 200.0, 8000.0, 2000.0),
    range("settle_ms", 24.0, 200.0, 60.0),
];

/// Own ranges of bang-bang.
pub const BANG_BANG: [Range; 3] =
    [range("dead_band_kpa", 0.3, 5.0, 1.0), range("stop_kpa", 0.01, 3.0, 0.3), range("turn_ms", 30.0, 2000.0, 300.0)];

/// Own ranges of the PID.
pub const PWM_PID: [Range; 6] = [
    range("proportional_per_kpa", 0.005, 1.0, 0.1),
    range("integral_per_kpa_s", 0.001, 5.0, 0.05),
    range("derivative_ms_per_kpa", 0.001, 5.0, 0.1),
    range("feed_forward", 0.05, 2.0, 0.8),
    range("period_ms", 10.0, 200.0, 40.0),
    range("dead_band_kpa", 0.1, 3.0, 0.6),
];

/// Own ranges of the sliding mode.
pub const SLIDING_MODE: [Range; 7] = [
    range("surface_per_s", 0.01, 20.0, 1.0),
    range("reaching_per_s", 1.0, 200.0, 20.0),
    range("switching_kpa_per_s", 1.0, 500.0, 30.0),
    range("layer_kpa", 0.1, 10.0, 2.0),
    range("enter_kpa", 0.2, 5.0, 1.0),
    range("leave_share", 0.02, 0.95, 0.4),
    range("period_ms", 10.0, 200.0, 40.0),
];

/// All ranges of a peer: the front's, then its own.
#[must_use]
pub fn ranges(own: &[Range]) -> Vec<Range> {
    FRONT_RANGES.iter().chain(own).copied().collect()
}

/// The front's figures.
#[must_use]
pub fn front(values: &[f64; FRONT]) -> FrontGains {
    let [supply_floor_kpa, supply_per_error, supply_hysteresis_kpa, slot_ms, lead_ms, match_kpa, look_ms, settle_ms] =
        *values;
    FrontGains {
        supply_floor_kpa,
        supply_per_error,
        supply_hysteresis_kpa,
        slot_ms,
        lead_ms,
        match_kpa,
        look_ms,
        settle_ms,
    }
}

/// Bang-bang's own figures.
#[must_use]
pub fn bang_bang(values: &[f64; 3]) -> bang_bang::Law {
    let [dead_band_kpa, stop_kpa, turn_ms] = *values;
    bang_bang::Law { dead_band_kpa, stop_kpa, turn_ms }
}

/// The PID's own figures.
#[must_use]
pub fn pid(values: &[f64; 6]) -> pid::Law {
    let [proportional_per_kpa, integral_per_kpa_s, derivative_ms_per_kpa, feed_forward, period_ms, dead_band_kpa] =
        *values;
    pid::Law { proportional_per_kpa, integral_per_kpa_s, derivative_ms_per_kpa, feed_forward, period_ms, dead_band_kpa }
}

/// The sliding mode's own figures.
#[must_use]
pub fn sliding_mode(values: &[f64; 7]) -> sliding_mode::Law {
    let [surface_per_s, reaching_per_s, switching_kpa_per_s, layer_kpa, enter_kpa, leave_share, period_ms] = *values;
    sliding_mode::Law {
        surface_per_s,
        reaching_per_s,
        switching_kpa_per_s,
        layer_kpa,
        enter_kpa,
        leave_share,
        period_ms,
    }
}
