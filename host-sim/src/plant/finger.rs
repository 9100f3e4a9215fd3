//! One segment of the finger: its bend follows its pressure, and its volume follows its bend.

use super::fault::PUSH_MS;
use super::gas::{GasVolume, REFERENCE_KPA};
use super::static_curve::StaticCurve;
use core::f64::consts::PI;
use std::sync::Arc;

/// What the lag makes of one step of time.
#[derive(Clone, Copy, Debug)]
pub struct LagStep {
    /// Share of the difference that the step takes away; 1 without lag.
    share: f64,
    /// The same for half the step.
    half_share: f64,
    /// Step over time constant; infinite without lag.
    ratio: f64,
    /// Bend and pressure are stiff where the pressure lost per bend gained, times this, exceeds the model's slope.
    coupling_share: f64,
    /// A Newton step of up to this share of the goal is enough: it leaves about its square.
    newton_share: f64,
}

impl LagStep {
    /// A step in which no time passes: it finds the static bend and nothing moves.
    #[must_use]
    pub const fn still() -> Self {
        Self { share: 0.0, half_share: 0.0, ratio: 0.0, coupling_share: 0.0, newton_share: 0.0 }
    }

    /// For a step of `step_ms` under a time constant of `lag_ms`, which may be zero.
    #[must_use]
    pub fn new(step_ms: f64, lag_ms: f64) -> Self {
        if lag_ms > 0.0 {
            let ratio = step_ms / lag_ms;
            let share = -(-ratio).exp_m1();
            // `ratio (slope + coupling) > slope / 2`, solved for the coupling.
            let coupling_share = if ratio < 0.5 { ratio / (0.5 - ratio) } else { f64::INFINITY };
            let newton_share = (BEND_ERROR / share).sqrt();
            Self { share, half_share: -(-0.5 * ratio).exp_m1(), ratio, coupling_share, newton_share }
        } else {
            Self {
                share: 1.0,
                half_share: 1.0,
                ratio: f64::INFINITY,
                coupling_share: f64::INFINITY,
                newton_share: BEND_ERROR.sqrt(),
            }
        }
    }
}

/// A bend that follows its static value with a first-order lag: `d alpha/dt = (alpha_static(P) - alpha) / tau`.
///
/// The lag acts on the bend and not as a damper on the pressure (`d alpha/dt = (P - P_model(alpha)) / d`): the model's
/// stiffness vanishes at alpha = 0, so a damped finger would creep back to straight as 1/t and never arrive.
#[derive(Clone, Debug)]
pub struct Bend {
    curve: Arc<StaticCurve>,
    /// Volume without bend of its own, L: what something outside bends is in it.
    rest_volume_l: f64,
    /// Volume per bend, L/rad.
    growth_l_per_rad: f64,
    state: BendState,
    forced: Forced,
}

/// What something outside does to a bend, rad: the bend is the finger's own, and this much more.
#[derive(Clone, Copy, Debug, Default)]
struct Forced {
    /// Volume without any bend, L.
    rest_volume_l: f64,
    /// By how much it is off, rad.
    by: f64,
    /// How far it is pushed, of what it shall be in the end, rad.
    pushed: f64,
    /// The largest push so far, rad: its share of the time for a push is its speed.
    largest_push: f64,
    /// It bends no further than this, rad.
    limit: Option<f64>,
}

/// What a step changes of a bend.
#[derive(Clone, Copy, Debug)]
pub(super) struct BendState {
    alpha: f64,
    /// The static bend under the pressure of now.
    goal: f64,
    /// The model's slope there, kPa/rad.
    slope: f64,
    /// What the goal moved by in the last step: where the next search starts.
    moved: f64,
    /// Whether bend and pressure are stiff, as the last step left them.
    stiff: bool,
    /// Air with which bend and pressure have come to rest, NL; not a number while they move.
    settled_nl: f64,
}

/// Error of a goal that one Newton step may leave, as a share of the goal and times the lag's share of a step: what
/// reaches the bend. The next step finds it and takes it away.
const BEND_ERROR: f64 = 1e-8;

/// Where one step of Newton's method puts a bend.
struct Proposal {
    /// Whether that is good enough.
    holds: bool,
    goal: f64,
    slope: f64,
    alpha: f64,
    /// Whether the next step should take bend and pressure for stiff.
    stiff: bool,
}

/// What a step of all three bends took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// Nothing: bends and pressures have come to rest.
    Nothing,
    /// One step of Newton's method for each, side by side.
    SideBySide,
    /// Iterations, one bend after another.
    Iterated,
}

/// One step of all three bends, each with its chamber's gas: [`Bend::step`] for each, side by side as long as one step of
/// Newton's method is enough for all.
#[inline]
pub fn step_all(bends: &mut [Bend; 3], gases: &mut [GasVolume; 3], atmosphere_kpa: f64, step: &LagStep) -> Work {
    #[expect(clippy::float_cmp, reason = "untouched, not merely near")]
    let settled = (0..3).all(|i| gases[i].content_nl() == bends[i].state.settled_nl);
    if settled {
        return Work::Nothing;
    }
    // One by one by name: an array of proposals would go through memory.
    let ([a, b, c], [gas_a, gas_b, gas_c]) = (bends, gases);
    let ahead_a = a.proposal(gas_a.content_nl(), atmosphere_kpa, step);
    let ahead_b = b.proposal(gas_b.content_nl(), atmosphere_kpa, step);
    let ahead_c = c.proposal(gas_c.content_nl(), atmosphere_kpa, step);
    if ahead_a.holds & ahead_b.holds & ahead_c.holds {
        a.take(&ahead_a, gas_a);
        b.take(&ahead_b, gas_b);
        c.take(&ahead_c, gas_c);
        Work::SideBySide
    } else {
        a.step(gas_a, atmosphere_kpa, step);
        b.step(gas_b, atmosphere_kpa, step);
        c.step(gas_c, atmosphere_kpa, step);
        Work::Iterated
    }
}

impl Bend {
    /// Straight. `growth_l_per_rad` may be zero.
    #[must_use]
    pub fn new(curve: Arc<StaticCurve>, rest_volume_l: f64, growth_l_per_rad: f64) -> Self {
        let slope = curve.pressure_and_slope(0.0).1;
        Self {
            curve,
            rest_volume_l,
            growth_l_per_rad,
            state: BendState { alpha: 0.0, goal: 0.0, slope, moved: 0.0, stiff: false, settled_nl: f64::NAN },
            forced: Forced { rest_volume_l, ..Forced::default() },
        }
    }

    /// The bend in radians.
    #[must_use]
    pub fn rad(&self) -> f64 {
        self.state.alpha + self.forced.by
    }

    /// By how much something outside holds it off the bend that it would have under its pressure, rad.
    #[must_use]
    pub fn forced_rad(&self) -> f64 {
        self.forced.by
    }

    /// One tick of what is outside, after the finger's own: a push towards an angle (rad), and something that it cannot
    /// pass from where it is when that comes.
    ///
    /// The finger's own bend goes on under the pressure that the true volume has. What is outside follows at the tick's
    /// end, so that the volume of the middle of a tick is at most half a tick's bend off.
    pub(super) fn force(&mut self, push_rad: f64, blocked: bool, gas: &mut GasVolume) {
        self.forced.largest_push = self.forced.largest_push.max(push_rad.abs());
        let full_step = self.forced.largest_push / PUSH_MS;
        self.forced.pushed += (push_rad - self.forced.pushed).clamp(-full_step, full_step);
        self.forced.limit = if blocked { self.forced.limit.or(Some(self.rad())) } else { None };
        let pushed = (self.state.alpha + self.forced.pushed).max(0.0);
        let bend = self.forced.limit.map_or(pushed, |limit| pushed.min(limit));
        let by = bend - self.state.alpha;
        #[expect(clippy::float_cmp, reason = "moved at all, not by how much")]
        if by != self.forced.by {
            self.forced.by = by;
            self.rest_volume_l = self.forced.rest_volume_l + self.growth_l_per_rad * by;
            gas.set_volume_l(self.forced.rest_volume_l + self.growth_l_per_rad * bend);
            self.state.settled_nl = f64::NAN;
        }
    }

    pub(super) fn state(&self) -> BendState {
        self.state
    }

    pub(super) fn restore(&mut self, state: BendState) {
        self.state = state;
    }

    /// The chamber's volume (L) in the middle of a step that starts now, as far as it can be told before the step.
    #[inline]
    #[must_use]
    pub fn volume_ahead_l(&self, step: &LagStep) -> f64 {
        self.rest_volume_l
            + self.growth_l_per_rad * (self.state.alpha + (self.state.goal - self.state.alpha) * step.half_share)
    }

    /// One step: bends, and sets the gas's volume to fit.
    ///
    /// The goal at the step's start and at its end share in it, half and half: second order. The end's goal, volume and
    /// pressure are solved together. Taken one after another they would chatter near P = 0, where alpha(P) has infinite
    /// slope: a trace of pressure bends the finger by degrees, its volume grows, and the pressure is below zero.
    ///
    /// There the problem is stiff without bound, and half and half would ring. Where the step is longer than half the time in
    /// which bend and pressure settle with each other (on the default plant: below 0.001 kPa) the end's goal counts alone.
    #[inline]
    pub fn step(&mut self, gas: &mut GasVolume, atmosphere_kpa: f64, step: &LagStep) {
        // Held for seconds: no more than 1e-12 rad would come of it.
        let content_nl = gas.content_nl();
        #[expect(clippy::float_cmp, reason = "untouched, not merely near")]
        if content_nl == self.state.settled_nl {
            return;
        }
        // The slope, and the pressure lost per bend gained, kPa/rad, both times the volume squared.
        let slope = self.state.slope * gas.volume_l() * gas.volume_l();
        let coupling = content_nl * REFERENCE_KPA * self.growth_l_per_rad;
        let stiff = step.ratio * (slope + coupling) > 0.5 * slope;
        self.state.stiff = stiff;
        let end_share = if stiff || step.share >= 1.0 { 1.0 } else { 0.5 };
        let base = self.state.alpha + (self.state.goal * (1.0 - end_share) - self.state.alpha) * step.share;
        let share = step.share * end_share;
        self.solve(content_nl * REFERENCE_KPA, atmosphere_kpa, base, share);
        self.arrive(base + self.state.goal * share, gas);
    }

    /// The same as [`Self::step`] where one step of Newton's method from last tick's goal, moved on as it moved then, is
    /// enough. Nothing branches on it, and but for the last few products nothing in it waits for
    /// the gas's content: three of these run side by side.
    #[expect(clippy::inline_always, reason = "a call would pass its result through memory, half of it at a time")]
    #[inline(always)]
    #[must_use]
    fn proposal(&self, content_nl: f64, atmosphere_kpa: f64, step: &LagStep) -> Proposal {
        let BendState { alpha, goal: last, moved, stiff, .. } = self.state;
        let no_lag = step.share >= 1.0;
        let end_share = if stiff | no_lag { 1.0 } else { 0.5 };
        let share = step.share * end_share;
        let base = alpha + (last * (1.0 - end_share) - alpha) * step.share;
        let base_volume = self.rest_volume_l + self.growth_l_per_rad * base;
        let growth = self.growth_l_per_rad * share;
        let start = last + moved;
        let (model, start_slope) = self.curve.pressure_and_slope_within(start);
        let absolute = model + atmosphere_kpa;
        let volume = base_volume + growth * start;
        let per_slope = 1.0 / (start_slope * volume + absolute * growth);

        let pressure_volume = content_nl * REFERENCE_KPA;
        let newton = (absolute * volume - pressure_volume) * per_slope;
        let straight = pressure_volume - atmosphere_kpa * base_volume <= 1e-11 * base_volume;
        let taken = newton.abs() <= step.newton_share * start && start <= self.curve.end_rad();
        let goal = if straight { 0.0 } else { start - newton };
        Proposal {
            holds: taken | straight,
            goal,
            slope: if straight { self.curve.coefficients_kpa()[0] } else { start_slope },
            alpha: base + goal * share,
            stiff: absolute * step.coupling_share * self.growth_l_per_rad > start_slope * volume,
        }
    }

    /// Takes a proposal that holds.
    #[inline]
    fn take(&mut self, proposal: &Proposal, gas: &mut GasVolume) {
        self.state.moved = if proposal.goal > 0.0 { proposal.goal - self.state.goal } else { 0.0 };
        self.state.goal = proposal.goal;
        self.state.slope = proposal.slope;
        self.state.stiff = proposal.stiff;
        self.arrive(proposal.alpha, gas);
    }

    /// Ends a step at a bend, with the goal found.
    #[inline]
    fn arrive(&mut self, alpha: f64, gas: &mut GasVolume) {
        // The tail of the exponential, far below anything measurable, would end in slow denormal numbers.
        let vanished = self.state.goal <= 0.0 && alpha < 1e-12;
        self.state.alpha = if vanished { 0.0 } else { alpha };
        gas.set_volume_l(self.rest_volume_l + self.growth_l_per_rad * self.state.alpha);
        let still = (self.state.goal - self.state.alpha).abs() + self.state.moved.abs() < 1e-12;
        self.state.settled_nl = if still { gas.content_nl() } else { f64::NAN };
    }

    /// Sets the goal to the static bend whose model pressure is the gas's at a bend of `base + share * goal`;
    /// `pressure_volume` is the gas's absolute pressure times its volume, kPa L.
    #[inline]
    fn solve(&mut self, pressure_volume: f64, atmosphere_kpa: f64, base: f64, share: f64) {
        let base_volume = self.rest_volume_l + self.growth_l_per_rad * base;
        let growth = self.growth_l_per_rad * share;
        // A vented chamber's gauge pressure is rounding, about 1e-14 kPa: nothing to search in.
        if pressure_volume - atmosphere_kpa * base_volume <= 1e-11 * base_volume {
            (self.state.goal, self.state.slope, self.state.moved) = (0.0, self.curve.coefficients_kpa()[0], 0.0);
            return;
        }
        // The excess of the model's pressure over the gas's, times the volume, is a smooth function of the goal that
        // rises everywhere: one zero, and Chebyshev's method for it, which is Newton's with the curvature. A bracket takes
        // the cases where it would leave.
        let (mut low, mut high) = (0.0, PI);
        let last = self.state.goal;
        let mut goal = (last + self.state.moved).max(1e-5);
        for _ in 0..60 {
            let (model, slope, curvature) = self.curve.pressure_and_slopes(goal);
            self.state.slope = slope;
            let volume = base_volume + growth * goal;
            let absolute = model + atmosphere_kpa;
            let excess = absolute * volume - pressure_volume;
            if excess < 0.0 {
                low = goal;
            } else {
                high = goal;
            }
            let per_slope = 1.0 / (slope * volume + absolute * growth);
            let newton = excess * per_slope;
            // Twice the curvature's share of Newton's step; far from the root the parabola is no guide.
            let bow = (curvature * volume + 2.0 * slope * growth) * per_slope * newton;
            let next = goal - newton * (1.0 + 0.5 * bow.clamp(-1.0, 1.0));
            // The ends belong to it: at the root the step is zero, and must not be taken for one that leaves.
            let next = if next >= low && next <= high { next } else { 0.5 * (low + high) };
            let moved = (next - goal).abs();
            goal = next;
            // The method cubes its error: after a step of 3e-5 what remains is rounding.
            if moved <= 3e-5 * goal {
                break;
            }
        }
        self.state.moved = goal - last;
        self.state.goal = goal;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::{angle_from_pressure_rad, pressure_and_slope};

    const COEFFICIENTS: [f64; 3] = [0.0, 13.84, 0.336];
    const ATMOSPHERE: f64 = 101.325;
    const REST_L: f64 = 0.0068;
    const GROWTH: f64 = 0.3 * REST_L / 2.0;

    fn bend(growth_l_per_rad: f64) -> Bend {
        Bend::new(Arc::new(StaticCurve::new(COEFFICIENTS)), REST_L, growth_l_per_rad)
    }

    #[test]
    fn without_lag_bend_and_gas_agree_at_once() {
        for gauge in [1e-9, 1e-6, 1e-3, 0.1, 5.0, 30.0, 150.0, 240.0] {
            let mut bend = bend(GROWTH);
            let tick = LagStep::new(1.0, 0.0);
            let mut gas = GasVolume::at_pressure(REST_L, ATMOSPHERE + gauge);
            bend.step(&mut gas, ATMOSPHERE, &tick);
            let left = gas.absolute_kpa() - ATMOSPHERE;
            assert!(left >= -1e-12 && left < gauge, "{gauge}: {left}");
            let model = pressure_and_slope(&COEFFICIENTS, bend.rad()).0;
            assert!((model - left).abs() < 1e-10, "{gauge}: {model} {left}");
            // And again: it stays.
            let before = bend.rad();
            bend.step(&mut gas, ATMOSPHERE, &tick);
            assert!((bend.rad() - before).abs() < 1e-9);
        }
    }

    #[test]
    fn lags_by_its_time_constant() {
        let mut bend = bend(0.0);
        let mut gas = GasVolume::at_pressure(REST_L, ATMOSPHERE + 100.0);
        // The goal of a step's start counts half: no time passes until it is known.
        bend.step(&mut gas, ATMOSPHERE, &LagStep::still());
        let tick = LagStep::new(1.0, 80.0);
        for _ in 0..80 {
            bend.step(&mut gas, ATMOSPHERE, &tick);
        }
        let share = bend.rad() / angle_from_pressure_rad(&COEFFICIENTS, 100.0);
        assert!((share - (1.0 - (-1.0_f64).exp())).abs() < 1e-9, "{share}");
    }

    #[test]
    fn a_trace_of_pressure_settles_without_ringing() {
        // A closed, straight chamber with some kPa too much: the bend rises and the pressure falls, and neither turns.
        for gauge in [1e-8, 1e-6, 1e-4, 1e-2, 1.0, 30.0] {
            let mut bend = bend(GROWTH);
            let mut gas = GasVolume::at_pressure(REST_L, ATMOSPHERE + gauge);
            let tick = LagStep::new(1.0, 80.0);
            let (mut last_rad, mut last_kpa) = (0.0, f64::INFINITY);
            for step in 0..3000 {
                bend.step(&mut gas, ATMOSPHERE, &tick);
                let (rad, kpa) = (bend.rad(), gas.absolute_kpa());
                assert!(rad >= last_rad - 1e-12 && kpa <= last_kpa + 1e-11, "{gauge} kPa, step {step}");
                (last_rad, last_kpa) = (rad, kpa);
            }
            // The model's pressure is the gas's at the end.
            let model = pressure_and_slope(&COEFFICIENTS, bend.rad()).0;
            assert!((model - (last_kpa - ATMOSPHERE)).abs() < 1e-9, "{gauge}: {model}");
        }
    }

    #[test]
    fn side_by_side_is_as_good_as_one_by_one() {
        // Filled, held, emptied through P = 0 into a little vacuum, and filled again; each chamber at its own pace.
        let tick = LagStep::new(1.0, 80.0);
        let mut together: [Bend; 3] = core::array::from_fn(|_| bend(GROWTH));
        let mut alone = together.clone();
        let mut gases = [GasVolume::at_pressure(REST_L, ATMOSPHERE); 3];
        let mut gases_alone = gases;
        let (mut side_by_side, mut worst_rad) = (0, 0.0_f64);
        for ms in 0..4000 {
            let rate_nl = match ms {
                0..800 => 1.5e-5,
                1500..2600 => -1.3e-5,
                3000..3500 => 1e-5,
                _ => 0.0,
            };
            for i in 0..3 {
                let nl = rate_nl * [1.0, 0.7, 0.4][i];
                gases[i].add(nl);
                gases_alone[i].add(nl);
                alone[i].step(&mut gases_alone[i], ATMOSPHERE, &tick);
            }
            side_by_side += u32::from(step_all(&mut together, &mut gases, ATMOSPHERE, &tick) == Work::SideBySide);
            for (one, other) in together.iter().zip(&alone) {
                worst_rad = worst_rad.max((one.rad() - other.rad()).abs());
            }
        }
        println!("{side_by_side} of 4000 side by side, {worst_rad:e} rad apart");
        assert!(alone[0].rad() > 0.1 && side_by_side > 3000);
        assert!(worst_rad < 1e-6, "{worst_rad:e}");
    }

    #[test]
    fn vacuum_is_straight() {
        let mut bend = bend(GROWTH);
        let mut gas = GasVolume::at_pressure(REST_L, ATMOSPHERE - 60.0);
        bend.step(&mut gas, ATMOSPHERE, &LagStep::new(1.0, 80.0));
        assert!(bend.rad().abs() <= 0.0);
    }
}
