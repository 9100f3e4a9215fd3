//! The continuous system behind the plant, solved to a tight tolerance: what the integrators are measured against.
//!
//! It shares the parameters with the plant, and the finger's model with everything in host-sim
//! ([`crate::mechanics`]); dead times, pump, ISO 6358 and the equations are written here once more, by their text-book
//! form, and solved by Dormand and Prince's method of order 8 (crate `differential-equations`). Between two milliseconds
//! no actuator moves, so each is solved for itself and no step ever crosses a switching.
//!
//! Below [`LINEAR_BELOW_KPA`] the static bend is taken as linear in the pressure: its slope is infinite at 0, and no
//! explicit method would ever get past a vented finger. What that hides is 0.01 degrees of bend at the most.

use crate::mechanics::pressure_and_slope;
use crate::plant::parameters::{OrificeParameters, PlantParameters};
use crate::plant::{FaultKind, InjectedFault};
use anyhow::{Result, anyhow, ensure};
use core::cell::Cell;
use core::f64::consts::PI;
use differential_equations::methods::ExplicitRungeKutta;
use differential_equations::ode::{ODE, solve_ode};
use differential_equations::solout::DefaultSolout;
use model_core::actuation::{Actuation, Passage};
use model_core::units::Millis;

/// Gauge pressure below which the static bend is linear in it, kPa.
pub const LINEAR_BELOW_KPA: f64 = 1e-6;

/// Relative and absolute tolerance of the solution; the states are kPa, radians and a share, all of order 1 to 100.
pub const TOLERANCE: f64 = 1e-10;

/// Where every actuator is for one millisecond.
#[derive(Clone, Copy, Debug)]
struct Tick {
    pump: bool,
    dump_open: bool,
    segments_open: [bool; 3],
    leaks_nl_per_s_bar: [f64; 3],
}

/// The state at the end of a millisecond.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Gauge pressure of each chamber, kPa.
    pub chambers_kpa: [f64; 3],
    /// Bend of each segment, degrees.
    pub bends_deg: [f64; 3],
    /// All the air, NL.
    pub content_nl: f64,
}

/// Actuators after their dead times, and faults, at each millisecond.
fn schedule(parameters: &PlantParameters, faults: &[InjectedFault], commands: &[Actuation]) -> Vec<Tick> {
    let late = |tick: usize, dead_ms: u32| {
        tick.checked_sub(dead_ms as usize).map_or(Actuation::SAFE, |earlier| commands[earlier])
    };
    (0..commands.len())
        .map(|tick| {
            let valves = late(tick, parameters.segment_valve.dead_time_ms);
            let mut leaks_nl_per_s_bar = [0.0; 3];
            for fault in faults.iter().filter(|fault| fault.is_active(Millis(tick as u32))) {
                if let FaultKind::ChamberLeak { segment, conductance_nl_per_s_bar } = fault.kind {
                    leaks_nl_per_s_bar[segment as usize] = conductance_nl_per_s_bar;
                }
            }
            Tick {
                pump: late(tick, parameters.pump.dead_time_ms).pump,
                dump_open: late(tick, parameters.dump_valve.dead_time_ms).dump == Passage::Open,
                segments_open: valves.segments.map(|passage| passage == Passage::Open),
                leaks_nl_per_s_bar,
            }
        })
        .collect()
}

/// ISO 6358: `q = C p1 sqrt(1 - ((p2/p1 - b)/(1 - b))^2)`, choked below b, linear in the difference above a ratio.
fn flow_nl_per_s(orifice: &OrificeParameters, sonic_nl_per_s_bar: f64, from_kpa: f64, to_kpa: f64) -> f64 {
    if from_kpa < to_kpa {
        return -flow_nl_per_s(orifice, sonic_nl_per_s_bar, to_kpa, from_kpa);
    }
    let (ratio, b) = (to_kpa / from_kpa, orifice.critical_ratio);
    let share = |ratio: f64| (1.0 - ((ratio - b) / (1.0 - b)).powi(2)).sqrt();
    let choked = sonic_nl_per_s_bar * from_kpa / 100.0;
    if ratio <= b {
        choked
    } else if ratio <= orifice.laminar_above {
        choked * share(ratio)
    } else {
        choked * share(orifice.laminar_above) * (1.0 - ratio) / (1.0 - orifice.laminar_above)
    }
}

/// Contents as the absolute pressure (kPa) they would have at rest volume, manifold first; bends, rad; speed of the pump.
type State = [f64; 8];

/// The system in one millisecond; time in ms.
struct System<'a> {
    parameters: &'a PlantParameters,
    tick: Tick,
    /// Static bends found last, rad: where the next search starts.
    found: Cell<[f64; 3]>,
}

impl System<'_> {
    fn growth(&self) -> f64 {
        self.parameters.finger.volume_growth / self.parameters.finger.growth_reference_deg.to_radians()
    }

    /// Absolute pressure of a chamber.
    fn chamber_kpa(&self, state: &State, segment: usize) -> f64 {
        state[1 + segment] / (1.0 + self.growth() * state[4 + segment])
    }

    fn static_rad(&self, segment: usize, gauge_kpa: f64) -> f64 {
        if gauge_kpa <= 0.0 {
            return 0.0;
        }
        let coefficients = &self.parameters.finger.coefficients_kpa[segment];
        let searched = gauge_kpa.max(LINEAR_BELOW_KPA);
        let mut found = self.found.get();
        let mut alpha = found[segment].max(1e-5);
        for _ in 0..100 {
            let (pressure, slope) = pressure_and_slope(coefficients, alpha);
            let next = alpha - (pressure - searched) / slope;
            // P is convex: from the left a step may reach beyond the pole.
            let next = if next < PI { next.max(0.1 * alpha) } else { 0.5 * (alpha + PI) };
            let moved = (next - alpha).abs();
            alpha = next;
            if moved <= 1e-12 * alpha {
                break;
            }
        }
        found[segment] = alpha;
        self.found.set(found);
        alpha * (gauge_kpa / LINEAR_BELOW_KPA).min(1.0)
    }
}

impl ODE<f64, State> for System<'_> {
    fn diff(&self, _time_ms: f64, state: &State, rate: &mut State) {
        let p = self.parameters;
        let atmosphere = p.gas.atmosphere_kpa;
        let per_ms = 1e-3 * 100.0;
        // kPa at rest volume for each NL/s and ms.
        let (manifold_gain, chamber_gain) =
            (per_ms / (p.gas.manifold_ml / 1000.0), per_ms / (p.finger.chamber_ml / 1000.0));
        let manifold = state[0];
        let speed = state[7];
        let pump = speed * p.pump.free_flow_nl_per_min / 60.0 * (1.0 - (manifold - atmosphere) / p.pump.stall_kpa);
        let dump = if self.tick.dump_open {
            flow_nl_per_s(&p.dump_valve, p.dump_valve.conductance_nl_per_s_bar, manifold, atmosphere)
        } else {
            0.0
        };
        rate[0] = (pump.max(0.0) - dump) * manifold_gain;
        for segment in 0..3 {
            let chamber = self.chamber_kpa(state, segment);
            let through = if self.tick.segments_open[segment] {
                flow_nl_per_s(&p.segment_valve, p.segment_valve.conductance_nl_per_s_bar, manifold, chamber)
            } else {
                0.0
            };
            let leak = flow_nl_per_s(&p.segment_valve, self.tick.leaks_nl_per_s_bar[segment], chamber, atmosphere);
            rate[0] -= through * manifold_gain;
            rate[1 + segment] = (through - leak) * chamber_gain;
            rate[4 + segment] = (self.static_rad(segment, chamber - atmosphere) - state[4 + segment]) / p.finger.lag_ms;
        }
        rate[7] = (f64::from(u8::from(self.tick.pump)) - speed) / p.pump.spin_up_ms;
    }
}

/// The state after each millisecond of the commands, from a straight finger at these gauge pressures (kPa, manifold first).
///
/// # Errors
/// When the solver does not reach the tolerance, or a lag is zero: the system has then no state of its own for it.
pub fn solve(
    parameters: &PlantParameters,
    faults: &[InjectedFault],
    start_kpa: [f64; 4],
    commands: &[Actuation],
    tolerance: f64,
) -> Result<Vec<Instant>> {
    ensure!(parameters.finger.lag_ms > 0.0 && parameters.pump.spin_up_ms > 0.0, "the reference needs both lags");
    let atmosphere = parameters.gas.atmosphere_kpa;
    let mut state = [0.0; 8];
    for (content, gauge) in state.iter_mut().zip(start_kpa) {
        *content = gauge + atmosphere;
    }
    let mut system = System {
        parameters,
        tick: Tick { pump: false, dump_open: true, segments_open: [true; 3], leaks_nl_per_s_bar: [0.0; 3] },
        found: Cell::new([0.0; 3]),
    };
    let mut instants = Vec::with_capacity(commands.len());
    for (time_ms, tick) in schedule(parameters, faults, commands).into_iter().enumerate() {
        system.tick = tick;
        let mut method = ExplicitRungeKutta::dop853().rtol(tolerance).atol(tolerance).max_steps(100_000);
        let solution = solve_ode(&mut method, &system, 0.0, 1.0, &state, &mut DefaultSolout::new())
            .map_err(|error| anyhow!("the reference fails at {time_ms} ms: {error:?}"))?;
        state = *solution.y.last().ok_or_else(|| anyhow!("the reference has no end at {time_ms} ms"))?;
        let [manifold, a, b, c, ..] = state;
        let chamber_l = parameters.finger.chamber_ml / 1000.0;
        instants.push(Instant {
            chambers_kpa: core::array::from_fn(|i| system.chamber_kpa(&state, i) - atmosphere),
            bends_deg: core::array::from_fn(|i| state[4 + i].to_degrees()),
            content_nl: (manifold * parameters.gas.manifold_ml / 1000.0 + (a + b + c) * chamber_l) / 100.0,
        });
    }
    Ok(instants)
}
