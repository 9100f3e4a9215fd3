//! A 2/2 valve: ISO 6358 flow through it, and the dead time of its coil.

use super::delay::Delay;
use super::parameters::OrificeParameters;
use model_core::actuation::Passage;

/// A restriction with ISO 6358's law, both ways alike, at the reference temperature.
///
/// With p1 the higher and p2 the lower absolute pressure: `q = C p1` while p2/p1 <= b (choked), else
/// `q = C p1 sqrt(1 - ((p2/p1 - b) / (1 - b))^2)`. At p2 = p1 the root's slope is infinite: any step size would
/// chatter there. Above a given ratio the flow is therefore linear in p1 - p2 (laminar), as it is in reality and as
/// ISO 6358-1 (2013) suggests; the two laws meet at that ratio.
#[derive(Clone, Copy, Debug)]
pub struct Orifice {
    /// C in NL/(s kPa).
    conductance: f64,
    critical_ratio: f64,
    /// 1/(1 - b).
    subsonic_scale: f64,
    /// The laminar zone's width, as a share of p1.
    laminar_width: f64,
    /// Flow per pressure difference in the laminar zone, NL/(s kPa).
    laminar_conductance: f64,
}

impl Orifice {
    /// From its data sheet's figures.
    #[must_use]
    pub fn new(parameters: &OrificeParameters) -> Self {
        let conductance = parameters.conductance_nl_per_s_bar / 100.0;
        let subsonic_scale = 1.0 / (1.0 - parameters.critical_ratio);
        let edge = (parameters.laminar_above - parameters.critical_ratio) * subsonic_scale;
        let laminar_width = 1.0 - parameters.laminar_above;
        Self {
            conductance,
            critical_ratio: parameters.critical_ratio,
            subsonic_scale,
            laminar_width,
            laminar_conductance: conductance * (1.0 - edge * edge).sqrt() / laminar_width,
        }
    }

    /// Flow in NL/s from `from_kpa` to `to_kpa` (absolute); negative when it runs the other way.
    #[inline]
    #[must_use]
    pub fn flow_nl_per_s(&self, from_kpa: f64, to_kpa: f64) -> f64 {
        let difference = from_kpa - to_kpa;
        let (high, low) = if difference >= 0.0 { (from_kpa, to_kpa) } else { (to_kpa, from_kpa) };
        if difference.abs() <= self.laminar_width * high {
            return self.laminar_conductance * difference;
        }
        let excess = low - self.critical_ratio * high;
        let effective = if excess <= 0.0 {
            high
        } else {
            // p1 sqrt(1 - ((r - b)/(1 - b))^2), multiplied out so that nothing is divided.
            let scaled = excess * self.subsonic_scale;
            // A pressure below nothing exists in an integrator that is about to fail only; it shall fail without a NaN.
            (high * high - scaled * scaled).max(0.0).sqrt()
        };
        (self.conductance * effective).copysign(difference)
    }

    /// The same flow, and its slopes over `from_kpa` and `to_kpa`, NL/(s kPa).
    #[inline]
    #[must_use]
    pub fn flow_and_slopes(&self, from_kpa: f64, to_kpa: f64) -> (f64, f64, f64) {
        let difference = from_kpa - to_kpa;
        let (high, low) = if difference >= 0.0 { (from_kpa, to_kpa) } else { (to_kpa, from_kpa) };
        if difference.abs() <= self.laminar_width * high {
            return (self.laminar_conductance * difference, self.laminar_conductance, -self.laminar_conductance);
        }
        let excess = low - self.critical_ratio * high;
        let (effective, high_slope, low_slope) = if excess <= 0.0 {
            (high, self.conductance, 0.0)
        } else {
            let scaled = excess * self.subsonic_scale;
            let effective = (high * high - scaled * scaled).max(0.0).sqrt();
            let per_effective = self.conductance / effective.max(f64::MIN_POSITIVE);
            let steepness = self.subsonic_scale * scaled * per_effective;
            (effective, high * per_effective + steepness * self.critical_ratio, -steepness)
        };
        // The other way round the flow changes its sign, and the sides their roles.
        if difference >= 0.0 {
            (self.conductance * effective, high_slope, low_slope)
        } else {
            (-self.conductance * effective, -low_slope, -high_slope)
        }
    }
}

/// A flow and its slopes as quotients over one divisor, for a solver that divides by a sum with it anyway.
#[derive(Clone, Copy, Debug)]
pub struct Quotients {
    /// The divisor, kPa, above 0.
    pub divisor_kpa: f64,
    /// Flow times the divisor, NL kPa/s.
    pub flow: f64,
    /// Slope over the pressure it comes from times the divisor, NL/s; never negative.
    pub from_slope: f64,
    /// Less the slope over the pressure it goes to, times the divisor, NL/s; never negative.
    pub to_slope: f64,
}

impl Orifice {
    /// [`Self::flow_and_slopes`] without a division.
    #[inline]
    #[must_use]
    pub fn quotients(&self, from_kpa: f64, to_kpa: f64) -> Quotients {
        let difference = from_kpa - to_kpa;
        let forward = difference >= 0.0;
        let (high, low) = if forward { (from_kpa, to_kpa) } else { (to_kpa, from_kpa) };
        if difference.abs() <= self.laminar_width * high {
            let slope = self.laminar_conductance;
            return Quotients { divisor_kpa: 1.0, flow: slope * difference, from_slope: slope, to_slope: slope };
        }
        // Choked, nothing exceeds: the root is p1, and what is left of the slopes is C.
        let excess = low - self.critical_ratio * high;
        let scaled = if excess > 0.0 { excess * self.subsonic_scale } else { 0.0 };
        let square = high * high - scaled * scaled;
        // Below nothing a pressure exists in an integrator that is about to fail only; it shall fail without a NaN.
        let square = if square > f64::MIN_POSITIVE { square } else { f64::MIN_POSITIVE };
        let divisor_kpa = square.sqrt();
        let low_slope = self.conductance * self.subsonic_scale * scaled;
        let high_slope = self.conductance * high + self.critical_ratio * low_slope;
        let flow = self.conductance * square;
        // The other way round the flow changes its sign, and the sides their roles.
        if forward {
            Quotients { divisor_kpa, flow, from_slope: high_slope, to_slope: low_slope }
        } else {
            Quotients { divisor_kpa, flow: -flow, from_slope: low_slope, to_slope: high_slope }
        }
    }
}

/// A valve with its coil: the passage follows the command after the dead time.
#[derive(Clone, Debug)]
pub struct Valve {
    delay: Delay<Passage>,
    passage: Passage,
    orifice: Orifice,
}

impl Valve {
    /// At rest, which is open: the machine's valves are normally open.
    #[must_use]
    pub fn new(orifice: Orifice, dead_time_ticks: u32) -> Self {
        Self { delay: Delay::new(dead_time_ticks, Passage::Open), passage: Passage::Open, orifice }
    }

    /// One tick: takes the command; a stuck valve takes it too, and stays where it sticks.
    #[inline]
    pub fn step(&mut self, command: Passage, stuck: Option<Passage>) {
        let moved = self.delay.step(command);
        self.passage = stuck.unwrap_or(moved);
    }

    /// Where the valve really is.
    #[must_use]
    pub fn passage(&self) -> Passage {
        self.passage
    }

    /// What air passes through; nothing when closed.
    #[inline]
    #[must_use]
    pub fn opening(&self) -> Option<&Orifice> {
        (self.passage == Passage::Open).then_some(&self.orifice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn orifice() -> Orifice {
        Orifice::new(&OrificeParameters::default())
    }

    #[test]
    fn agrees_with_the_standard_by_hand() {
        // C = 0.025 NL/(s bar), b = 0.3; python: C*p1*sqrt(1 - ((r - b)/(1 - b))**2), p1 in bar, r = p2/p1.
        for (p1, p2, expected) in [
            (250.0, 50.0, 0.0625),                // r = 0.2: choked, C p1
            (250.0, 75.0, 0.0625),                // r = b
            (200.0, 160.0, 0.034_992_710_611_19), // r = 0.8: 0.05 sqrt(1 - (5/7)^2)
            (200.0, 130.0, 0.043_301_270_189_22), // r = 0.65: 0.05 sqrt(3)/2
            (101.325, 0.0, 0.025_331_25),
        ] {
            let flow = orifice().flow_nl_per_s(p1, p2);
            assert!((flow - expected).abs() < 1e-12, "{p1} to {p2} kPa: {flow}");
        }
    }

    #[test]
    fn is_continuous_at_both_edges() {
        for edge in [0.3, 0.999] {
            let below = orifice().flow_nl_per_s(200.0, 200.0 * (edge - 1e-12));
            let above = orifice().flow_nl_per_s(200.0, 200.0 * (edge + 1e-12));
            assert!((below - above).abs() < 1e-9, "{edge}: {below} {above}");
        }
    }

    #[test]
    fn a_closed_valve_passes_nothing_and_opens_after_its_dead_time() {
        let mut valve = Valve::new(orifice(), 10);
        for tick in 0..10 {
            valve.step(Passage::Closed, None);
            assert_eq!(valve.passage(), Passage::Open, "{tick}");
        }
        valve.step(Passage::Open, None);
        assert_eq!(valve.passage(), Passage::Closed);
        assert!(valve.opening().is_none());
        valve.step(Passage::Closed, Some(Passage::Open));
        assert_eq!(valve.passage(), Passage::Open);
        assert!(valve.opening().is_some());
    }

    proptest! {
        #[test]
        fn flow_is_odd_and_rises_with_the_difference(a in 1.0..400.0, b in 1.0..400.0, more in 0.001..10.0) {
            let there = orifice().flow_nl_per_s(a, b);
            prop_assert!((there + orifice().flow_nl_per_s(b, a)).abs() <= 0.0);
            prop_assert!(orifice().flow_nl_per_s(a + more, b) >= there);
            prop_assert!(orifice().flow_nl_per_s(a, b + more) <= there);
        }

        #[test]
        fn slopes_are_the_derivatives(a in 1.0..400.0, ratio in 0.01..1.0_f64, reverse in proptest::bool::ANY) {
            let (from, to) = if reverse { (a * ratio, a) } else { (a, a * ratio) };
            // Away from the edges, where the slope jumps.
            prop_assume!((ratio - 0.3).abs() > 1e-3 && (ratio - 0.999).abs() > 1e-4);
            let (flow, from_slope, to_slope) = orifice().flow_and_slopes(from, to);
            prop_assert!((flow - orifice().flow_nl_per_s(from, to)).abs() <= 0.0);
            let quotients = orifice().quotients(from, to);
            for (quotient, expected) in
                [(quotients.flow, flow), (quotients.from_slope, from_slope), (-quotients.to_slope, to_slope)]
            {
                let value = quotient / quotients.divisor_kpa;
                prop_assert!((value - expected).abs() <= 1e-12 * expected.abs().max(1e-6), "{} {}", value, expected);
            }
            let step = 1e-6 * a;
            let central = |high: f64, low: f64| (high - low) / (2.0 * step);
            let by_from = central(orifice().flow_nl_per_s(from + step, to), orifice().flow_nl_per_s(from - step, to));
            let by_to = central(orifice().flow_nl_per_s(from, to + step), orifice().flow_nl_per_s(from, to - step));
            prop_assert!((from_slope - by_from).abs() < 1e-5 * by_from.abs().max(1e-4), "{} {}", from_slope, by_from);
            prop_assert!((to_slope - by_to).abs() < 1e-5 * by_to.abs().max(1e-4), "{} {}", to_slope, by_to);
        }
    }
}
