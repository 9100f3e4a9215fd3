//! The machine, simulated in f64: pump, valves, air, finger and sensors, one millisecond a step.
//!
//! Each part is a struct in a file of its own; a [`Scene`] leaves parts out or breaks them, [`PlantParameters`] holds
//! every figure. Same parameters, scene and seed: same readings, bit for bit.
//!
//! A tick is one or more steps of the same kind. In a step the air flows with the volumes of its middle, as far as they can
//! be told before it; then the finger bends and the volumes follow ([`finger::Bend`]). Both halves are of second order, so the
//! whole is, with any [`integrator::Method`] of second order or more. Air is only ever moved, so its sum changes by what
//! passes the pump, the dump valve and leaks.
//!
//! Stability: the stiffest case of the default plant is the 5 mL manifold with all four valves in their laminar zone, about
//! 1,300 per second. A small manifold or a torn chamber multiplies that. The default, the linearly implicit midpoint rule
//! with ROS2 where it would swing, is stable at any stiffness and takes one step a tick; the explicit methods need steps
//! below 2 over that rate. docs/simulator.md compares all of them with a reference of tight tolerance.

pub mod delay;
pub mod fault;
pub mod finger;
pub mod gas;
pub mod integrator;
pub mod network;
pub mod parameters;
pub mod pump;
pub mod scene;
pub mod sensor;
pub mod static_curve;
pub mod valve;

pub use fault::{FaultKind, InjectedFault};
pub use integrator::Method;
pub use parameters::PlantParameters;
pub use scene::{Part, Scene};

use fault::ActiveFaults;
use finger::{Bend, BendState, LagStep};
use gas::{GasVolume, REFERENCE_KPA};
use model_core::actuation::{Actuation, Passage, Segment};
use model_core::controller::{Inputs, Reading};
use model_core::units::Millis;
use network::{Contents, Network};
use parameters::OrificeParameters;
use pump::Pump;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use sensor::{BendSensor, PressureSensor};
use static_curve::StaticCurve;
use std::sync::Arc;
use valve::{Orifice, Valve};

/// What is really so, as no sensor can tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Gauge pressure of the manifold, kPa.
    pub manifold_kpa: f64,
    /// Gauge pressure of each chamber, kPa.
    pub chambers_kpa: [f64; 3],
    /// Bend of each segment, degrees.
    pub bends_deg: [f64; 3],
    /// Flow from the pump into the manifold, NL/s.
    pub pump_flow_nl_per_s: f64,
    /// Flow from the manifold through the dump valve, NL/s.
    pub dump_flow_nl_per_s: f64,
    /// Flow from the manifold into each chamber, NL/s.
    pub segment_flows_nl_per_s: [f64; 3],
    /// Flow from each chamber through its leak, NL/s.
    pub leak_flows_nl_per_s: [f64; 3],
    /// Air in the manifold and the chambers together, NL.
    pub content_nl: f64,
    /// The pump's speed as a share of full speed, 0..=1.
    pub pump_speed: f64,
    /// Where the dump valve really is.
    pub dump: Passage,
    /// Where each segment's valve really is.
    pub segments: [Passage; 3],
    /// By how much something outside holds each segment off the bend that it would have under its pressure, degrees.
    pub forced_deg: [f64; 3],
}

/// Halvings of a tick that the adaptive method may take: steps of 1 ms down to 1 us.
const HALVINGS: u32 = 10;

/// What the ticks took, counted: the same on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Evaluations of the flows.
    pub flow_evaluations: u64,
    /// Steps in which all bends took one step of Newton's method, side by side.
    pub bends_side_by_side: u64,
    /// Steps in which the bends were iterated, one after another.
    pub bends_iterated: u64,
}

/// The parts of a tick, in their order.
const ACTUATORS: u8 = 0;
const AIR: u8 = 1;
const FINGER: u8 = 2;
const READINGS: u8 = 3;

/// A tick, or the first parts of it.
pub(crate) type TickFunction = fn(&mut Plant, Actuation) -> Inputs;

/// What a step changes, to take it back.
#[derive(Clone, Copy)]
struct State {
    manifold: GasVolume,
    chambers: [GasVolume; 3],
    bends: [BendState; 3],
}

/// The machine.
#[derive(Clone, Debug)]
pub struct Plant {
    parameters: PlantParameters,
    faults: Vec<InjectedFault>,
    now: Millis,
    noisy: bool,
    rng: Pcg64,

    pump: Pump,
    dump: Valve,
    segments: [Valve; 3],
    last_actuation: Actuation,
    /// Ticks in a row with that command.
    unmoved_ticks: u32,
    /// After so many the valves have followed.
    longest_dead_ticks: u32,
    /// Whether any valve or leak is open.
    any_open: bool,
    leaks: [Option<Orifice>; 3],
    /// The conductance each leak was made for, NL/(s bar).
    leaks_nl_per_s_bar: [f64; 3],
    /// The same for the manifold.
    manifold_leak: Option<Orifice>,
    manifold_leak_nl_per_s_bar: f64,
    manifold: GasVolume,
    /// Absolute pressure for each normal litre in it: its volume never changes.
    manifold_kpa_per_nl: f64,
    chambers: [GasVolume; 3],
    bends: [Bend; 3],
    /// The finger's lag over a tick halved as often as the index says; for a fixed step its own, alone.
    lags: Vec<LagStep>,
    /// How often the adaptive method halves the tick at present.
    halvings: u32,
    counts: Counts,
    faults_now: ActiveFaults,
    pressure_sensor: PressureSensor,
    bend_sensor: BendSensor,
    /// The readings at `now`.
    inputs: Inputs,
}

/// A hole of this conductance, NL/(s bar), otherwise as that valve; none when it is zero.
fn hole(conductance_nl_per_s_bar: f64, valve: &OrificeParameters) -> Option<Orifice> {
    let of = || Orifice::new(&OrificeParameters { conductance_nl_per_s_bar, ..valve.clone() });
    (conductance_nl_per_s_bar > 0.0).then(of)
}

impl Plant {
    /// Vented, at rest, at the atmosphere's pressure, at time zero.
    #[must_use]
    pub fn new(parameters: PlantParameters, scene: Scene, seed: u64) -> Self {
        let mut rng = Pcg64::seed_from_u64(seed);
        // Drawn in every scene, so that a seed stands for the same sensors in all of them.
        let zero_draw: f64 = StandardNormal.sample(&mut rng);
        let gain_draw: f64 = rng.random_range(-1.0..=1.0);
        let zero_error_kpa = scene.sensor_errors.or_zero(zero_draw * parameters.pressure_sensor.zero_error_kpa);
        let gain_error = scene.sensor_errors.or_zero(gain_draw * parameters.bend_sensor.gain_error);

        let valve = |orifice: &OrificeParameters| {
            Valve::new(Orifice::new(orifice), scene.actuator_delays.or_zero(orifice.dead_time_ms))
        };
        let noisy = scene.sensor_errors == Part::Modelled;
        let quantised = scene.quantisation == Part::Modelled;
        let finger = &parameters.finger;
        let rest_l = finger.chamber_ml / 1000.0;
        let growth_l_per_rad =
            scene.volume_growth.or_zero(rest_l * finger.volume_growth / finger.growth_reference_deg.to_radians());
        let atmosphere_kpa = parameters.gas.atmosphere_kpa;
        let lag_ms = scene.finger_lag.or_zero(finger.lag_ms);
        let lags = if let Method::Adaptive { .. } = parameters.integration.method {
            (0..=HALVINGS).map(|halvings| LagStep::new((-f64::from(halvings)).exp2(), lag_ms)).collect()
        } else {
            vec![LagStep::new(1.0 / f64::from(parameters.integration.sub_steps.max(1)), lag_ms)]
        };
        // Segments with the same coefficients share one table: it then stays in the cache.
        let mut curves: Vec<Arc<StaticCurve>> = Vec::new();
        let bends = finger.coefficients_kpa.map(|coefficients| {
            let bits = |coefficients: &[f64; 3]| coefficients.map(f64::to_bits);
            let made = curves.iter().find(|curve| bits(curve.coefficients_kpa()) == bits(&coefficients));
            let curve = made.cloned().unwrap_or_else(|| Arc::new(StaticCurve::new(coefficients)));
            curves.push(Arc::clone(&curve));
            Bend::new(curve, rest_l, growth_l_per_rad)
        });

        let mut plant = Self {
            now: Millis::ZERO,
            noisy,
            rng,
            pump: Pump::new(
                &parameters.pump,
                scene.actuator_delays.or_zero(parameters.pump.dead_time_ms),
                scene.actuator_delays.or_zero(parameters.pump.spin_up_ms),
            ),
            dump: valve(&parameters.dump_valve),
            segments: core::array::from_fn(|_| valve(&parameters.segment_valve)),
            last_actuation: Actuation::SAFE,
            unmoved_ticks: 0,
            longest_dead_ticks: 1 + parameters.dump_valve.dead_time_ms.max(parameters.segment_valve.dead_time_ms),
            any_open: true,
            leaks: [None; 3],
            leaks_nl_per_s_bar: [0.0; 3],
            manifold_leak: None,
            manifold_leak_nl_per_s_bar: 0.0,
            manifold: GasVolume::at_pressure(parameters.gas.manifold_ml / 1000.0, atmosphere_kpa),
            manifold_kpa_per_nl: REFERENCE_KPA / (parameters.gas.manifold_ml / 1000.0),
            chambers: [GasVolume::at_pressure(rest_l, atmosphere_kpa); 3],
            bends,
            lags,
            halvings: 0,
            counts: Counts::default(),
            faults_now: ActiveFaults::default(),
            pressure_sensor: PressureSensor::new(
                &parameters.pressure_sensor,
                scene.sensor_lag.or_zero(parameters.pressure_sensor.lag_ms),
                zero_error_kpa,
                quantised,
                noisy,
            ),
            bend_sensor: BendSensor::new(&parameters.bend_sensor, 1.0 + gain_error, quantised),
            inputs: Inputs {
                now: Millis::ZERO,
                manifold: Reading::BelowRange,
                bend: Reading::BelowRange,
                over_pressure_switch: false,
                emergency_stop: false,
                host_heard: true,
                overrun: false,
            },
            faults: scene.faults,
            parameters,
        };
        plant.faults_now = ActiveFaults::at(&plant.faults, plant.now);
        plant.sense(plant.manifold_gauge_kpa());
        plant
    }

    /// The same plant with other gauge pressures (kPa, above -100) at its start; the finger is straight and the sensors have
    /// settled at 0 kPa.
    #[must_use]
    pub fn starting_at(mut self, manifold_kpa: f64, chambers_kpa: [f64; 3]) -> Self {
        let atmosphere_kpa = self.parameters.gas.atmosphere_kpa;
        self.manifold = GasVolume::at_pressure(self.manifold.volume_l(), manifold_kpa + atmosphere_kpa);
        for ((chamber, bend), kpa) in self.chambers.iter_mut().zip(&mut self.bends).zip(chambers_kpa) {
            *chamber = GasVolume::at_pressure(chamber.volume_l(), kpa + atmosphere_kpa);
            // The bend starts out towards this pressure.
            bend.step(chamber, atmosphere_kpa, &LagStep::still());
        }
        self
    }

    /// Advances one tick (1 ms) under the commanded actuation, and returns the readings at its end.
    ///
    /// A fault acts in the ticks that start while it is there, and in the readings taken then.
    pub fn step(&mut self, actuation: &Actuation) -> Inputs {
        self.tick::<READINGS>(*actuation)
    }

    /// [`Self::step`] cut off after each of its parts: what a part costs is the time between two of them.
    pub(crate) const CUT_AFTER: [(&'static str, TickFunction); 4] = [
        ("pump, valves, faults", Self::tick::<ACTUATORS>),
        ("air", Self::tick::<AIR>),
        ("finger", Self::tick::<FINGER>),
        ("readings", Self::tick::<READINGS>),
    ];

    #[inline]
    fn tick<const LAST: u8>(&mut self, actuation: Actuation) -> Inputs {
        if !self.faults.is_empty() {
            self.pump.weaken(self.faults_now.pump_share);
        }
        self.pump.step(actuation.pump, self.faults_now.pump);
        let still = self.unmoved_ticks >= self.longest_dead_ticks && actuation == self.last_actuation;
        if !still || !self.faults.is_empty() {
            self.move_valves(actuation);
        }
        if LAST >= AIR {
            match self.parameters.integration.method {
                Method::Adaptive { tolerance_kpa } => self.advance_adaptively(tolerance_kpa),
                method => self.advance::<LAST>(method),
            }
        }
        if LAST >= FINGER && !self.faults.is_empty() {
            self.force_finger();
        }
        self.now = self.now + Millis(1);
        if !self.faults.is_empty() {
            self.faults_now = ActiveFaults::at(&self.faults, self.now);
        }
        if LAST >= READINGS {
            let manifold_kpa = self.manifold_gauge_kpa();
            self.pressure_sensor.step(manifold_kpa);
            return self.sense(manifold_kpa);
        }
        self.inputs
    }

    /// One tick of what is outside of the finger.
    fn force_finger(&mut self) {
        let ActiveFaults { push_deg, blocked, .. } = self.faults_now;
        let bends = self.bends.iter_mut().zip(&mut self.chambers);
        for ((bend, chamber), (push_deg, blocked)) in bends.zip(push_deg.into_iter().zip(blocked)) {
            bend.force(push_deg.to_radians(), blocked, chamber);
        }
    }

    /// One tick of the valves and leaks. Without a fault and once nothing has been commanded for the valves' dead times,
    /// nothing comes of it.
    fn move_valves(&mut self, actuation: Actuation) {
        let faults = self.faults_now;
        self.dump.step(actuation.dump, faults.dump);
        for segment in 0..3 {
            self.segments[segment].step(actuation.segments[segment], faults.segments[segment]);
        }
        self.unmoved_ticks = if actuation == self.last_actuation { self.unmoved_ticks.saturating_add(1) } else { 1 };
        self.last_actuation = actuation;
        #[expect(clippy::float_cmp, reason = "changed at all, not by how much")]
        let leaks_changed = faults.leaks_nl_per_s_bar != self.leaks_nl_per_s_bar;
        if leaks_changed {
            self.leaks_nl_per_s_bar = faults.leaks_nl_per_s_bar;
            self.leaks = faults.leaks_nl_per_s_bar.map(|conductance| hole(conductance, &self.parameters.segment_valve));
        }
        #[expect(clippy::float_cmp, reason = "changed at all, not by how much")]
        let manifold_leak_changed = faults.manifold_leak_nl_per_s_bar != self.manifold_leak_nl_per_s_bar;
        if manifold_leak_changed {
            self.manifold_leak_nl_per_s_bar = faults.manifold_leak_nl_per_s_bar;
            self.manifold_leak = hole(faults.manifold_leak_nl_per_s_bar, &self.parameters.dump_valve);
        }
        self.any_open = self.dump.opening().is_some()
            || self.segments.iter().any(|valve| valve.opening().is_some())
            || self.leaks.iter().any(Option::is_some)
            || self.manifold_leak.is_some();
    }

    /// The readings at the current time, without advancing; asked twice they are the same.
    #[must_use]
    pub fn inputs(&self) -> Inputs {
        self.inputs
    }

    /// The mean converter code (0..=4095) behind the bend reading: bridge, amplifier and converter in f64.
    #[must_use]
    pub fn bend_code(&self) -> f64 {
        match self.inputs.bend {
            Reading::Valid(bend) => self.parameters.bend_sensor.code(bend.to_f64()),
            Reading::BelowRange => 0.0,
            Reading::AboveRange => 4095.0,
        }
    }

    /// The mean converter code (0..=4095) behind the pressure reading.
    #[must_use]
    pub fn pressure_code(&self) -> f64 {
        self.pressure_sensor.code()
    }

    /// The figures in use.
    #[must_use]
    pub fn parameters(&self) -> &PlantParameters {
        &self.parameters
    }

    /// The true state at the current time.
    #[must_use]
    pub fn truth(&self) -> Truth {
        let atmosphere_kpa = self.parameters.gas.atmosphere_kpa;
        let manifold_kpa = self.manifold.absolute_kpa();
        let chambers_kpa = self.chambers.map(|chamber| chamber.absolute_kpa());
        let volumes_l = self.chambers.map(|chamber| chamber.volume_l());
        let flows = self.network(1.0, volumes_l).flows(&self.contents());
        Truth {
            manifold_kpa: manifold_kpa - atmosphere_kpa,
            chambers_kpa: chambers_kpa.map(|kpa| kpa - atmosphere_kpa),
            bends_deg: Segment::ALL.map(|segment| self.bends[segment as usize].rad().to_degrees()),
            pump_flow_nl_per_s: flows.pump,
            dump_flow_nl_per_s: flows.dump,
            segment_flows_nl_per_s: flows.segments,
            leak_flows_nl_per_s: flows.leaks,
            content_nl: self.manifold.content_nl() + self.chambers.iter().map(GasVolume::content_nl).sum::<f64>(),
            pump_speed: self.pump.speed(),
            dump: self.dump.passage(),
            segments: Segment::ALL.map(|segment| self.segments[segment as usize].passage()),
            forced_deg: Segment::ALL.map(|segment| self.bends[segment as usize].forced_rad().to_degrees()),
        }
    }

    /// True gauge pressure of each chamber, kPa: of [`Self::truth`] what takes no time.
    #[must_use]
    pub fn chambers_kpa(&self) -> [f64; 3] {
        self.chambers.map(|chamber| chamber.absolute_kpa() - self.parameters.gas.atmosphere_kpa)
    }

    /// What the ticks since the start took; the adaptive method's bends are not counted.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    fn manifold_gauge_kpa(&self) -> f64 {
        self.manifold.content_nl() * self.manifold_kpa_per_nl - self.parameters.gas.atmosphere_kpa
    }

    fn contents(&self) -> Contents {
        let [a, b, c] = &self.chambers;
        [self.manifold.content_nl(), a.content_nl(), b.content_nl(), c.content_nl()]
    }

    /// What decides the flows at a share of this tick (0..=1), with the chambers at these volumes.
    #[inline]
    fn network(&self, tick_share: f64, volumes_l: [f64; 3]) -> Network<'_> {
        let [a, b, c] = volumes_l;
        Network {
            atmosphere_kpa: self.parameters.gas.atmosphere_kpa,
            pump: self.pump.delivery(tick_share),
            dump: self.dump.opening().or(self.manifold_leak.as_ref()),
            segments: [self.segments[0].opening(), self.segments[1].opening(), self.segments[2].opening()],
            leaks: [self.leaks[0].as_ref(), self.leaks[1].as_ref(), self.leaks[2].as_ref()],
            kpa_per_nl: [self.manifold_kpa_per_nl, REFERENCE_KPA / a, REFERENCE_KPA / b, REFERENCE_KPA / c],
        }
    }

    /// Whether air can move in this tick. Held chambers are most of a sequence's time.
    fn can_flow(&self) -> bool {
        !self.pump.rests() || self.any_open
    }

    /// One tick in steps of fixed length.
    #[inline]
    fn advance<const LAST: u8>(&mut self, method: Method) {
        let sub_steps = self.parameters.integration.sub_steps.max(1);
        let tick_share = 1.0 / f64::from(sub_steps);
        let can_flow = self.can_flow();
        let lag = self.lags[0];
        for sub_step in 0..sub_steps {
            if can_flow {
                let middle = (f64::from(sub_step) + 0.5) * tick_share;
                self.flow(method, middle, tick_share, &lag, f64::INFINITY);
            }
            if LAST >= FINGER {
                let atmosphere_kpa = self.parameters.gas.atmosphere_kpa;
                match finger::step_all(&mut self.bends, &mut self.chambers, atmosphere_kpa, &lag) {
                    finger::Work::Nothing => {}
                    finger::Work::SideBySide => self.counts.bends_side_by_side += 1,
                    finger::Work::Iterated => self.counts.bends_iterated += 1,
                }
            }
        }
    }

    /// One tick in halves, quarters, eighths... of it, as the tolerance asks.
    fn advance_adaptively(&mut self, tolerance_kpa: f64) {
        /// A step whose error is this share of the tolerance is followed by one of twice the length.
        const EASY: f64 = 1.0 / 16.0;
        let method = self.parameters.integration.method;
        let can_flow = self.can_flow();
        // In units of the shortest step.
        let end = 1_u32 << HALVINGS;
        let mut done = 0;
        while done < end {
            let length = end >> self.halvings;
            let lag = self.lags[self.halvings as usize];
            let last = self.halvings == HALVINGS;
            let before = self.state();
            let share = |units: u32| f64::from(units) / f64::from(end);
            let mut error_kpa = 0.0;
            if can_flow {
                let limit_kpa = if last { f64::INFINITY } else { tolerance_kpa };
                error_kpa = self.flow(method, share(done) + 0.5 * share(length), share(length), &lag, limit_kpa);
            }
            if last || error_kpa <= tolerance_kpa {
                error_kpa = error_kpa.max(self.bend(&lag));
            }
            if !last && error_kpa > tolerance_kpa {
                self.restore(before);
                self.halvings += 1;
                continue;
            }
            done += length;
            // A longer step starts where one of its length can.
            if self.halvings > 0 && error_kpa < EASY * tolerance_kpa && done % (2 * length) == 0 {
                self.halvings -= 1;
            }
        }
    }

    /// Moves the air for a share of a tick around its `middle`, unless the error is estimated above the limit; returns that
    /// estimate, kPa.
    #[inline]
    fn flow(&mut self, method: Method, middle: f64, tick_share: f64, lag: &LagStep, limit_kpa: f64) -> f64 {
        let volumes_l = core::array::from_fn(|i| self.bends[i].volume_ahead_l(lag));
        let network = self.network(middle, volumes_l);
        let contents = self.contents();
        if network.rests(&contents) {
            return 0.0;
        }
        let step = integrator::step(method, &network, &contents, 1e-3 * tick_share);
        self.counts.flow_evaluations += u64::from(step.evaluations);
        if step.error_kpa <= limit_kpa {
            let [manifold, chambers @ ..] = step.contents;
            self.manifold.set_content_nl(manifold);
            for (chamber, content_nl) in self.chambers.iter_mut().zip(chambers) {
                chamber.set_content_nl(content_nl);
            }
        }
        step.error_kpa
    }

    /// Bends the finger; returns how far off the volumes were that the air flowed with, as a pressure, kPa.
    #[inline]
    fn bend(&mut self, lag: &LagStep) -> f64 {
        let mut worst_kpa = 0.0_f64;
        for (bend, chamber) in self.bends.iter_mut().zip(&mut self.chambers) {
            let (ahead_l, before_l) = (bend.volume_ahead_l(lag), chamber.volume_l());
            bend.step(chamber, self.parameters.gas.atmosphere_kpa, lag);
            let off_l = ahead_l - 0.5 * (before_l + chamber.volume_l());
            worst_kpa = worst_kpa.max((off_l * chamber.kpa_per_l()).abs());
        }
        worst_kpa
    }

    fn state(&self) -> State {
        State {
            manifold: self.manifold,
            chambers: self.chambers,
            bends: core::array::from_fn(|i| self.bends[i].state()),
        }
    }

    fn restore(&mut self, state: State) {
        (self.manifold, self.chambers) = (state.manifold, state.chambers);
        for (bend, state) in self.bends.iter_mut().zip(state.bends) {
            bend.restore(state);
        }
    }

    /// Takes the readings; the manifold's gauge pressure is known.
    #[inline]
    fn sense(&mut self, manifold_kpa: f64) -> Inputs {
        let faults = self.faults_now;
        // Both are drawn even while a sensor is broken: a fault does not change the other sensor's noise.
        let mut draw = || if self.noisy { StandardNormal.sample(&mut self.rng) } else { 0.0 };
        let (pressure_noise, bend_noise) = (draw(), draw());
        self.pressure_sensor.convert(pressure_noise, faults.pressure_signal);
        let bend_deg = self.bends.iter().map(Bend::rad).sum::<f64>().to_degrees();
        let inputs = Inputs {
            now: self.now,
            manifold: self.pressure_sensor.reading(),
            bend: self.bend_sensor.reading(bend_deg, bend_noise, faults.bend_signal),
            over_pressure_switch: faults
                .pressure_switch
                .unwrap_or(manifold_kpa >= self.parameters.pressure_sensor.switch_kpa),
            emergency_stop: faults.emergency_stop,
            // The plant's side of the bench is a host that is heard every tick, and no tick is late.
            host_heard: true,
            overrun: false,
        };
        // Not read back: what was written field by field would have to reach memory first.
        self.inputs = inputs;
        inputs
    }
}

#[cfg(test)]
mod tests;
