//! What the monitor's tests share: frames as a device sends them.

pub use super::requests::frame;

use model_core::actuation::Actuation;
use model_core::protocol::{
    Decoder, IdentifiedSegment, Identity, LinkCommand, LinkMode, Report, Request, ResetCause, SequenceName, Telemetry,
    outputs_of,
};

/// Telemetry of a vented device at this time.
pub fn telemetry(tick: u32) -> Report {
    Report::Telemetry(told(tick, LinkMode::Vented))
}

/// Telemetry in which the pressures follow their setpoints.
pub fn told(tick: u32, mode: LinkMode) -> Telemetry {
    Telemetry {
        tick,
        mode,
        faults: 0,
        priority: 0,
        setpoints: [60 << 16, 30 << 16, 60 << 16],
        estimates: [59 << 16, 30 << 16, 61 << 16],
        manifold: Some(60 << 16),
        bend: Some(186 << 16),
        outputs: outputs_of(&Actuation::HOLD),
        step: 0,
        repeat: 0,
        holding: true,
        fingertip_um: [40_000, 60_000],
        fingertip_millideg: 186_000,
        force_mn: 2_500,
        overruns: 0,
        dropped_frames: 0,
        tick_cycles: 3_500,
        worst_tick_cycles: 7_000,
    }
}

/// Who a device with the default calibration is.
pub fn identity(id: u16) -> Report {
    let default = model_core::calibration::DEFAULT;
    let bits = [default.k(), default.c1(), default.c2()].map(fixed::types::I8F24::to_bits);
    Report::Identity(Identity {
        id,
        protocol: model_core::protocol::VERSION,
        firmware: heapless::String::try_from("0.1.0").expect("short"),
        serial: [0x0042_0031, 0x3335_5117, 0x2036_3839],
        reset_cause: ResetCause::PowerOn,
        coefficients: [bits; 3],
        pressure_zero: 0,
        bend_zero: 0,
        sequences: 15,
    })
}

/// What a device has identified after some steps of the proximal segment.
pub fn identified() -> [IdentifiedSegment; 3] {
    let coefficients = [12.0, 11.0, 0.5].map(|kpa| fixed::types::I8F24::from_num(kpa).to_bits());
    let (residual_pressure, residual_bend) = (1 << 15, 26_214);
    let ready = IdentifiedSegment { coefficients, residual_pressure, residual_bend, points: 14, ready: true };
    let not_yet = IdentifiedSegment { points: 2, ready: false, ..ready };
    [ready, not_yet, IdentifiedSegment { points: 0, ..not_yet }]
}

/// The request that starts a sequence.
pub fn run(name: &str) -> LinkCommand {
    LinkCommand::Run(SequenceName::try_from(name).expect("short"))
}

/// The requests in what a host sends.
pub fn requests(bytes: &[u8]) -> Vec<Request> {
    let mut decoder = Decoder::new();
    bytes.iter().filter_map(|&byte| decoder.push(byte)).map(|request| request.expect("whole")).collect()
}
