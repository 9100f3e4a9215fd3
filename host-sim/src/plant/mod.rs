//! The machine, simulated in f64: pump, valves, air, finger and sensors, one millisecond a step.
//!
//! Each part is a struct in a file of its own; a [`Scene`] leaves parts out or breaks them, [`PlantParameters`] holds
//! every figure. Same parameters, scene and seed: same readings, bit for bit.
//!
//! Within a tick the air flows in sub-steps (Heun's method on the contents of the four volumes) with the actuators'
//! state and the volumes held; at its end the finger bends and the volumes follow. Air is only ever moved, so its sum
//! changes by what passes the pump, the dump valve and leaks.
//!
//! Stability: the stiffest case is the 5 mL manifold with all four valves in their laminar zone, about 1,300 per second.
//! A sub-step of 100 us times that is 0.13; Heun's method is stable up to 2 and free of overshoot up to 1.

pub mod delay;
pub mod fault;
pub mod finger;
pub mod gas;
pub mod parameters;
pub mod pump;
pub mod scene;
pub mod sensor;
pub mod valve;

pub use fault::{FaultKind, InjectedFault};
pub use parameters::PlantParameters;
pub use scene::{Part, Scene};

use fault::ActiveFaults;
use finger::Bend;
use gas::GasVolume;
use model_core::actuation::{Actuation, Passage, Segment};
use model_core::controller::{Inputs, Reading};
use model_core::units::Millis;
use parameters::OrificeParameters;
use pump::Pump;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use sensor::{BendSensor, PressureSensor};
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
}

/// Flows at one moment, NL/s.
#[derive(Clone, Copy)]
struct Flows {
    pump: f64,
    dump: f64,
    segments: [f64; 3],
    leaks: [f64; 3],
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
    leaks: [Option<Orifice>; 3],
    manifold: GasVolume,
    chambers: [GasVolume; 3],
    bends: [Bend; 3],
    pressure_sensor: PressureSensor,
    bend_sensor: BendSensor,
    /// The readings at `now`.
    inputs: Inputs,
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
            leaks: [None; 3],
            manifold: GasVolume::at_pressure(parameters.gas.manifold_ml / 1000.0, atmosphere_kpa),
            chambers: [GasVolume::at_pressure(rest_l, atmosphere_kpa); 3],
            bends: finger.coefficients_kpa.map(|coefficients| {
                Bend::new(coefficients, rest_l, growth_l_per_rad, scene.finger_lag.or_zero(finger.lag_ms))
            }),
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
            },
            faults: scene.faults,
            parameters,
        };
        let faults = ActiveFaults::at(&plant.faults, plant.now);
        plant.sense(&faults);
        plant
    }

    /// Advances one tick (1 ms) under the commanded actuation, and returns the readings at its end.
    ///
    /// A fault acts in the ticks that start while it is there, and in the readings taken then.
    pub fn step(&mut self, actuation: &Actuation) -> Inputs {
        let faults = ActiveFaults::at(&self.faults, self.now);
        self.pump.step(actuation.pump, faults.pump);
        self.dump.step(actuation.dump, faults.dump);
        for segment in 0..3 {
            self.segments[segment].step(actuation.segments[segment], faults.segments[segment]);
            let conductance = faults.leaks_nl_per_s_bar[segment];
            self.leaks[segment] = (conductance > 0.0).then(|| {
                Orifice::new(&OrificeParameters {
                    conductance_nl_per_s_bar: conductance,
                    ..self.parameters.segment_valve.clone()
                })
            });
        }
        self.move_air();
        for (bend, chamber) in self.bends.iter_mut().zip(&mut self.chambers) {
            bend.step(chamber, self.parameters.gas.atmosphere_kpa);
        }
        self.pressure_sensor.step(self.manifold_gauge_kpa());

        self.now = self.now + Millis(1);
        let faults = ActiveFaults::at(&self.faults, self.now);
        self.sense(&faults);
        self.inputs
    }

    /// The readings at the current time, without advancing; asked twice they are the same.
    #[must_use]
    pub fn inputs(&self) -> Inputs {
        self.inputs
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
        let flows = self.flows(manifold_kpa, chambers_kpa);
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
        }
    }

    fn manifold_gauge_kpa(&self) -> f64 {
        self.manifold.absolute_kpa() - self.parameters.gas.atmosphere_kpa
    }

    /// All flows at these absolute pressures in kPa.
    #[inline]
    fn flows(&self, manifold_kpa: f64, chambers_kpa: [f64; 3]) -> Flows {
        let atmosphere_kpa = self.parameters.gas.atmosphere_kpa;
        Flows {
            pump: self.pump.flow_nl_per_s(manifold_kpa - atmosphere_kpa),
            dump: self.dump.flow_nl_per_s(manifold_kpa, atmosphere_kpa),
            segments: core::array::from_fn(|i| self.segments[i].flow_nl_per_s(manifold_kpa, chambers_kpa[i])),
            leaks: core::array::from_fn(|i| {
                self.leaks[i].map_or(0.0, |leak| leak.flow_nl_per_s(chambers_kpa[i], atmosphere_kpa))
            }),
        }
    }

    /// Moves the air for one tick.
    fn move_air(&mut self) {
        let closed = |valve: &Valve| valve.passage() == Passage::Closed;
        // Held chambers are most of a sequence's time.
        if self.pump.rests()
            && closed(&self.dump)
            && self.segments.iter().all(closed)
            && self.leaks.iter().all(Option::is_none)
        {
            return;
        }
        let sub_steps = self.parameters.integration.sub_steps.max(1);
        let seconds = 1e-3 / f64::from(sub_steps);
        for _ in 0..sub_steps {
            let start = self.flows(self.manifold.absolute_kpa(), self.chambers.map(|chamber| chamber.absolute_kpa()));
            // Heun's predictor, then the mean of both ends.
            let into_manifold = start.pump - start.dump - start.segments.iter().sum::<f64>();
            let end = self.flows(
                self.manifold.absolute_kpa_with(seconds * into_manifold),
                core::array::from_fn(|i| {
                    self.chambers[i].absolute_kpa_with(seconds * (start.segments[i] - start.leaks[i]))
                }),
            );
            let half = 0.5 * seconds;
            self.manifold.add(half * (start.pump + end.pump - start.dump - end.dump));
            for i in 0..3 {
                let moved = half * (start.segments[i] + end.segments[i]);
                self.manifold.add(-moved);
                self.chambers[i].add(moved - half * (start.leaks[i] + end.leaks[i]));
            }
        }
    }

    /// Takes the readings.
    fn sense(&mut self, faults: &ActiveFaults) {
        // Both are drawn even while a sensor is broken: a fault does not change the other sensor's noise.
        let mut draw = || if self.noisy { StandardNormal.sample(&mut self.rng) } else { 0.0 };
        let (pressure_noise, bend_noise) = (draw(), draw());
        self.pressure_sensor.convert(pressure_noise, faults.pressure_signal);
        let bend_deg = self.bends.iter().map(Bend::rad).sum::<f64>().to_degrees();
        self.inputs = Inputs {
            now: self.now,
            manifold: self.pressure_sensor.reading(),
            bend: self.bend_sensor.reading(bend_deg, bend_noise, faults.bend_open),
            over_pressure_switch: self.manifold_gauge_kpa() >= self.parameters.pressure_sensor.switch_kpa,
            emergency_stop: faults.emergency_stop,
        };
    }
}
