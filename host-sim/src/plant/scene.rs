//! What of the plant a run models, and what breaks in it.

use super::fault::InjectedFault;

/// Whether a part of the plant is modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Part {
    /// As the parameters say.
    #[default]
    Modelled,
    /// Left out, as if it were perfect.
    LeftOut,
}

impl Part {
    /// The value when modelled, zero when left out.
    pub(super) fn or_zero<T: Default>(self, value: T) -> T {
        match self {
            Self::Modelled => value,
            Self::LeftOut => T::default(),
        }
    }
}

/// What a run models. The default models everything and breaks nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Sensor noise, zero error and gain error.
    pub sensor_errors: Part,
    /// Steps of the converter and of the bend's resolution.
    pub quantisation: Part,
    /// The pressure sensor's lag.
    pub sensor_lag: Part,
    /// Dead times of the valves and the relay, and the pump's spin-up.
    pub actuator_delays: Part,
    /// Growth of a chamber's volume with its bend.
    pub volume_growth: Part,
    /// The bend's lag behind the pressure.
    pub finger_lag: Part,
    /// What breaks, and when.
    pub faults: Vec<InjectedFault>,
}

impl Scene {
    /// Perfect sensors, actuators without delay, a finger without lag; the gas, its flow and the chambers' growth
    /// remain.
    #[must_use]
    pub fn ideal() -> Self {
        Self {
            sensor_errors: Part::LeftOut,
            quantisation: Part::LeftOut,
            sensor_lag: Part::LeftOut,
            actuator_delays: Part::LeftOut,
            volume_growth: Part::Modelled,
            finger_lag: Part::LeftOut,
            faults: Vec::new(),
        }
    }

    /// The same scene with these faults.
    #[must_use]
    pub fn with_faults(mut self, faults: impl IntoIterator<Item = InjectedFault>) -> Self {
        self.faults.extend(faults);
        self
    }
}
