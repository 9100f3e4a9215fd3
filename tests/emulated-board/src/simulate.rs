//! A run of host-sim with the firmware's ELF as the controller.

use crate::bench::Bench;
use crate::firmware_elf;
use anyhow::{Result, bail};
use host_sim::simulate::{Program, Run, STANDBY_MS, VENT_MS};
use host_sim::trace::{Sample, Trace};
use model_core::controller::{Fault, Mode};
use model_core::protocol::{LinkCommand, Report, SequenceName, Telemetry};
use model_core::supervisor::fault::FaultSet;
use model_core::units::{Bend, Pressure};

/// Time between two signs of life, ms: the device vents after a second without one.
const BEAT_MS: u32 = 500;

/// Simulates standby, program and venting.
///
/// Pins and plant are sampled every millisecond; mode, setpoints and estimates are what the telemetry says, a hundred
/// times a second.
///
/// # Errors
/// When the firmware is not built, does not take the command, or is reset on the way.
pub fn on_elf(run: &Run, progress: &mut dyn FnMut(u32, u32)) -> Result<Trace> {
    let mut bench = Bench::new(&firmware_elf()?, run.parameters.clone(), run.scene.clone(), run.seed)?;
    // Time starts when the self test is over: a run on the core has none.
    bench.ready()?;
    let end = STANDBY_MS + run.program.duration_ms();
    let total = end + VENT_MS;
    let mut samples = Vec::with_capacity(total as usize);
    for time_ms in 0..total {
        if time_ms == STANDBY_MS {
            bench.request(match run.program {
                Program::Sequence(sequence) => LinkCommand::Run(SequenceName::try_from(sequence.name)?),
                Program::Setpoints(setpoints) => LinkCommand::Setpoints(setpoints.map(Pressure::to_bits)),
                Program::Bends(bends) => LinkCommand::Bends(bends.map(Bend::to_bits)),
            });
        } else if time_ms == end && matches!(run.program, Program::Setpoints(_) | Program::Bends(_)) {
            bench.request(LinkCommand::Vent);
        }
        if time_ms % BEAT_MS == 0 {
            // A host that drives by hand has to be heard.
            bench.request(LinkCommand::Beat);
        }
        bench.run_ms(1)?;
        if let Some(Report::Nack { reason, .. }) = bench.answers.last() {
            bail!("the firmware does not take the command: {reason:?}");
        }
        samples.push(sample(time_ms, &bench));
        if time_ms % 100 == 0 {
            progress(time_ms, total);
        }
    }
    progress(total, total);
    Ok(Trace {
        name: run.program.name().to_owned(),
        description: format!("{}; the firmware's ELF on the emulated board", run.program.description()),
        seed: run.seed,
        samples,
    })
}

fn sample(time_ms: u32, bench: &Bench) -> Sample {
    let truth = bench.plant.truth();
    let inputs = bench.plant.inputs();
    let told = bench.telemetry.last();
    let kpa = |of: fn(&Telemetry) -> [i32; 3]| {
        told.map_or([0.0; 3], |told| of(told).map(|bits| Pressure::from_bits(bits).to_f64()))
    };
    Sample {
        time_ms,
        actuation: bench.actuation(),
        // A fault that this version does not know vents all the same; the emergency stop stands for it.
        mode: told.map_or(Mode::Vented, |told| told.mode.mode().unwrap_or(Mode::Faulted(Fault::EmergencyStop))),
        faults: told.map_or(FaultSet::EMPTY, |told| FaultSet::from_bits(told.faults)),
        step: told.map_or(0, |told| told.step),
        repeat: told.map_or(0, |told| told.repeat),
        holding: told.is_some_and(|told| told.holding),
        setpoints_kpa: kpa(|told| told.setpoints),
        estimates_kpa: kpa(|told| told.estimates),
        chambers_kpa: truth.chambers_kpa,
        manifold_kpa: truth.manifold_kpa,
        sensor_kpa: inputs.manifold.valid().map_or(f64::NAN, Pressure::to_f64),
        bends_deg: truth.bends_deg,
        bend_sensor_deg: inputs.bend.valid().map_or(f64::NAN, Bend::to_f64),
    }
}
