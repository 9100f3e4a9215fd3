//! One row of a recording: what is known of one moment, of a simulated run or of a device.

use crate::campaign::kind::fault_name;
use crate::trace::Sample;
use core::str::FromStr;
use model_core::actuation::Actuation;
use model_core::controller::{Fault, Mode};
use model_core::protocol::{LinkMode, Telemetry, actuation_of};
use model_core::supervisor::fault::FaultSet;
use model_core::units::{Bend, Pressure};

/// Names of the alarm's priority, by the number that telemetry has.
pub const PRIORITIES: [&str; 4] = ["none", "low", "medium", "high"];

/// Where a row comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A simulated run: every true quantity is known.
    Simulated,
    /// A device, over its link.
    Device,
    /// The emulated board, over its link.
    Emulated,
}

impl Source {
    /// Every source.
    pub const ALL: [Self; 3] = [Self::Simulated, Self::Device, Self::Emulated];

    /// Its name in the table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Simulated => "simulated",
            Self::Device => "device",
            Self::Emulated => "emulated",
        }
    }
}

impl FromStr for Source {
    type Err = ();

    fn from_str(name: &str) -> Result<Self, ()> {
        Self::ALL.into_iter().find(|source| source.name() == name).ok_or(())
    }
}

/// How the link and the control ticks do; nothing where there is no link. All count up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkQuality {
    /// Control ticks that started late, since the device's start.
    pub late_ticks: Option<u32>,
    /// Frames that the device dropped, since its start.
    pub device_dropped_frames: Option<u32>,
    /// This control tick, core clock cycles.
    pub tick_cycles: Option<u32>,
    /// The longest control tick since the device's start, core clock cycles.
    pub worst_tick_cycles: Option<u32>,
    /// Telemetry frames that the device must have sent, by its clock, and that never came, since the recording's start.
    pub frames_lost: Option<u32>,
    /// Frames that came and were no message (damaged, or of another version), since the recording's start.
    pub frames_bad: Option<u32>,
}

impl LinkQuality {
    /// In the order of the columns.
    pub(super) fn to_array(self) -> [Option<u32>; 6] {
        [
            self.late_ticks,
            self.device_dropped_frames,
            self.tick_cycles,
            self.worst_tick_cycles,
            self.frames_lost,
            self.frames_bad,
        ]
    }

    pub(super) fn from_array(array: [Option<u32>; 6]) -> Self {
        let [late_ticks, device_dropped_frames, tick_cycles, worst_tick_cycles, frames_lost, frames_bad] = array;
        Self { late_ticks, device_dropped_frames, tick_cycles, worst_tick_cycles, frames_lost, frames_bad }
    }
}

/// One row. Pressures are gauge, in kPa, bends in degrees; a quantity that nobody knows is not a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Where it comes from.
    pub source: Source,
    /// Time since the recording's start, ms: rises from row to row, also when the device starts anew in between.
    pub time_ms: u32,
    /// Time of day at which the host had the row, ms since 1970 (UTC); nothing in a simulated run.
    pub unix_ms: Option<u64>,
    /// The device's own clock, ms since its start; nothing in a simulated run.
    pub device_ms: Option<u32>,
    /// What the controller was doing.
    pub mode: LinkMode,
    /// Every fault that is latched; bits that this version knows no fault for are kept.
    pub faults: FaultSet,
    /// Priority of the alarm, index into [`PRIORITIES`].
    pub priority: u8,
    /// Which repeat of the sequence.
    pub repeat: u16,
    /// Index of the sequence's step.
    pub step: u16,
    /// The reference rests at a target.
    pub holding: bool,
    /// What the controller did.
    pub actuation: Actuation,
    /// Reference of each chamber.
    pub setpoints_kpa: [f64; 3],
    /// The controller's estimate of each chamber.
    pub estimates_kpa: [f64; 3],
    /// True pressure of each chamber; known where the finger is simulated.
    pub chambers_kpa: [f64; 3],
    /// True pressure of the manifold; known where the finger is simulated.
    pub manifold_kpa: f64,
    /// What the pressure sensor read; not a number while it fails.
    pub sensor_kpa: f64,
    /// True bend of each segment; known where the finger is simulated.
    pub bends_deg: [f64; 3],
    /// What the bend sensor read, whole finger; not a number while it fails.
    pub bend_sensor_deg: f64,
    /// Bend of each segment by the controller's model at the estimated pressure, where the recorder worked it out.
    pub model_bends_deg: [f64; 3],
    /// Fingertip as the device tells it, mm: along the straight finger, and to where it bends.
    pub fingertip_mm: [f64; 2],
    /// Direction of the fingertip as the device tells it.
    pub fingertip_deg: f64,
    /// Driving force as the device tells it, N.
    pub force_n: f64,
    /// How the link does.
    pub link: LinkQuality,
    /// What happened since the row before, in words: what the host asked, how it was answered, that the link was lost.
    pub event: String,
}

/// Quantities of a row, in the order of their columns; the finger's bend, their sum, among them.
pub(super) const QUANTITIES: usize = 23;

impl Record {
    /// A vented row at a time, of which nothing else is known.
    #[must_use]
    pub fn unknown(source: Source, time_ms: u32) -> Self {
        Self {
            source,
            time_ms,
            unix_ms: None,
            device_ms: None,
            mode: LinkMode::Vented,
            faults: FaultSet::EMPTY,
            priority: 0,
            repeat: 0,
            step: 0,
            holding: false,
            actuation: Actuation::SAFE,
            setpoints_kpa: [f64::NAN; 3],
            estimates_kpa: [f64::NAN; 3],
            chambers_kpa: [f64::NAN; 3],
            manifold_kpa: f64::NAN,
            sensor_kpa: f64::NAN,
            bends_deg: [f64::NAN; 3],
            bend_sensor_deg: f64::NAN,
            model_bends_deg: [f64::NAN; 3],
            fingertip_mm: [f64::NAN; 2],
            fingertip_deg: f64::NAN,
            force_n: f64::NAN,
            link: LinkQuality::default(),
            event: String::new(),
        }
    }

    /// What a device said; time of day, frames lost and bad, the model's bends and events are for the recorder to add.
    #[must_use]
    pub fn from_telemetry(source: Source, time_ms: u32, told: &Telemetry) -> Self {
        let kpa = |bits: i32| Pressure::from_bits(bits).to_f64();
        let [x_um, y_um] = told.fingertip_um.map(f64::from);
        Self {
            device_ms: Some(told.tick),
            mode: told.mode,
            faults: FaultSet::from_bits(told.faults),
            priority: told.priority.min(3),
            repeat: told.repeat,
            step: told.step,
            holding: told.holding,
            actuation: actuation_of(told.outputs),
            setpoints_kpa: told.setpoints.map(kpa),
            estimates_kpa: told.estimates.map(kpa),
            sensor_kpa: told.manifold.map_or(f64::NAN, kpa),
            bend_sensor_deg: told.bend.map_or(f64::NAN, |bits| Bend::from_bits(bits).to_f64()),
            fingertip_mm: [x_um / 1e3, y_um / 1e3],
            fingertip_deg: f64::from(told.fingertip_millideg) / 1e3,
            force_n: f64::from(told.force_mn) / 1e3,
            link: LinkQuality {
                late_ticks: Some(told.overruns.into()),
                device_dropped_frames: Some(told.dropped_frames.into()),
                tick_cycles: Some(told.tick_cycles),
                worst_tick_cycles: Some(told.worst_tick_cycles),
                ..LinkQuality::default()
            },
            ..Self::unknown(source, time_ms)
        }
    }

    /// The whole finger's true bend: the sum of the segments'.
    #[must_use]
    pub fn finger_deg(&self) -> f64 {
        self.bends_deg.iter().sum()
    }

    pub(super) fn quantities(&self) -> [f64; QUANTITIES] {
        let mut all = [f64::NAN; QUANTITIES];
        all[0..3].copy_from_slice(&self.setpoints_kpa);
        all[3..6].copy_from_slice(&self.estimates_kpa);
        all[6..9].copy_from_slice(&self.chambers_kpa);
        all[9] = self.manifold_kpa;
        all[10] = self.sensor_kpa;
        all[11..14].copy_from_slice(&self.bends_deg);
        all[14] = self.finger_deg();
        all[15] = self.bend_sensor_deg;
        all[16..19].copy_from_slice(&self.model_bends_deg);
        all[19..21].copy_from_slice(&self.fingertip_mm);
        all[21] = self.fingertip_deg;
        all[22] = self.force_n;
        all
    }

    pub(super) fn set_quantities(&mut self, all: &[f64; QUANTITIES]) {
        self.setpoints_kpa.copy_from_slice(&all[0..3]);
        self.estimates_kpa.copy_from_slice(&all[3..6]);
        self.chambers_kpa.copy_from_slice(&all[6..9]);
        self.manifold_kpa = all[9];
        self.sensor_kpa = all[10];
        self.bends_deg.copy_from_slice(&all[11..14]);
        self.bend_sensor_deg = all[15];
        self.model_bends_deg.copy_from_slice(&all[16..19]);
        self.fingertip_mm.copy_from_slice(&all[19..21]);
        self.fingertip_deg = all[21];
        self.force_n = all[22];
    }
}

impl From<&Sample> for Record {
    fn from(sample: &Sample) -> Self {
        Self {
            mode: sample.mode.into(),
            faults: sample.faults,
            priority: sample.faults.priority().map_or(0, |priority| priority as u8 + 1),
            repeat: sample.repeat,
            step: sample.step,
            holding: sample.holding,
            actuation: sample.actuation,
            setpoints_kpa: sample.setpoints_kpa,
            estimates_kpa: sample.estimates_kpa,
            chambers_kpa: sample.chambers_kpa,
            manifold_kpa: sample.manifold_kpa,
            sensor_kpa: sample.sensor_kpa,
            bends_deg: sample.bends_deg,
            bend_sensor_deg: sample.bend_sensor_deg,
            ..Self::unknown(Source::Simulated, sample.time_ms)
        }
    }
}

/// A fault's name by its code: `over-pressure`, or `code-63` when this version does not know it.
#[must_use]
pub fn code_name(code: u8) -> String {
    Fault::from_code(code).map_or_else(|| format!("code-{code}"), fault_name)
}

/// The code of a fault's name as [`code_name`] gives it.
#[must_use]
pub fn code_of(name: &str) -> Option<u8> {
    (0..64).find(|&code| code_name(code) == name)
}

/// A mode's name: `running`, or `faulted:over-pressure`.
#[must_use]
pub fn link_mode_name(mode: LinkMode) -> String {
    match mode {
        LinkMode::Vented => "vented".into(),
        LinkMode::SelfTest => "self-test".into(),
        LinkMode::Running => "running".into(),
        LinkMode::Holding => "holding".into(),
        LinkMode::Paused => "paused".into(),
        LinkMode::Faulted(code) => format!("faulted:{}", code_name(code)),
    }
}

/// The mode with this name.
#[must_use]
pub fn link_mode_of(name: &str) -> Option<LinkMode> {
    let plain = [LinkMode::Vented, LinkMode::SelfTest, LinkMode::Running, LinkMode::Holding, LinkMode::Paused];
    plain
        .into_iter()
        .find(|&mode| link_mode_name(mode) == name)
        .or_else(|| name.strip_prefix("faulted:").and_then(code_of).map(LinkMode::Faulted))
}

/// A mode's name in reports, as [`link_mode_name`] has it.
#[must_use]
pub fn mode_name(mode: Mode) -> String {
    link_mode_name(mode.into())
}

/// The latched faults' names with `|` between, by rising code; empty when there is none.
#[must_use]
pub fn fault_names(faults: FaultSet) -> String {
    faults.codes().map(code_name).collect::<Vec<_>>().join("|")
}

/// The faults of a text as [`fault_names`] gives it.
#[must_use]
pub fn faults_of(names: &str) -> Option<FaultSet> {
    let mut bits = 0;
    for name in names.split('|').filter(|name| !name.is_empty()) {
        bits |= 1 << code_of(name)?;
    }
    Some(FaultSet::from_bits(bits))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_and_fault_has_a_name_of_its_own_that_reads_back() {
        for code in 0..64 {
            assert_eq!(code_of(&code_name(code)), Some(code));
            assert_eq!(link_mode_of(&link_mode_name(LinkMode::Faulted(code))), Some(LinkMode::Faulted(code)));
            assert!(!code_name(code).contains(['|', ',', '"', ' ']), "{}", code_name(code));
        }
        assert_eq!(code_name(0), "over-pressure");
        assert_eq!(code_name(63), "code-63");
        assert_eq!(link_mode_of("dancing"), None);
        for bits in [0, 1, 1 << 63, 0b1001, u64::MAX] {
            assert_eq!(faults_of(&fault_names(FaultSet::from_bits(bits))), Some(FaultSet::from_bits(bits)));
        }
        assert_eq!(fault_names(FaultSet::from_bits(0b10001)), "over-pressure|emergency-stop");
        assert_eq!(faults_of("over-pressure|gremlins"), None);
    }
}
