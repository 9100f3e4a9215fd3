//! One run: the controller on its drawn plant, with what breaks around it, and the judge beside.

use super::draw::{Case, Program, STANDBY_MS, What, Wish};
use super::judge::{Event, Judge, Outcome};
use crate::plant::{Plant, Scene};
use crate::trace::Sample;
use model_core::actuation::{Actuation, PerSegment};
use model_core::controller::{Command, Controller, Inputs, Mode, Outputs};
use model_core::supervisor::fault::{Fault, FaultSet};
use model_core::units::{Bend, Coefficients, Millis, Pressure};

/// The hung task is reset this long after its last beat, ms: the firmware's watchdog.
pub const WATCHDOG_MS: u32 = 100;
/// From a reset to the first control tick, ms: assumed.
const BOOT_MS: u32 = 20;
/// After the program's end a run goes on for this long, ms: the finger is seen to vent.
const AFTER_PROGRAM_MS: u32 = 3000;
/// A run ends when the controller has not started its program by then, ms.
const START_LIMIT_MS: u32 = 15_000;

/// What a campaign drives: the core, or a broken one in tests.
pub trait Core {
    /// Starts, with its self test, after an event that the firmware reports.
    fn start(calibration: PerSegment<Coefficients>, report: Option<Fault>) -> Self;
    /// Takes a command; true when it is taken.
    fn command(&mut self, command: Command) -> bool;
    /// One tick.
    fn step(&mut self, inputs: &Inputs) -> Outputs;
}

impl Core for Controller {
    fn start(calibration: PerSegment<Coefficients>, report: Option<Fault>) -> Self {
        let mut controller = Self::with_self_test(calibration);
        if let Some(fault) = report {
            controller.report(fault);
        }
        controller
    }

    fn command(&mut self, command: Command) -> bool {
        Self::command(self, command).is_ok()
    }

    fn step(&mut self, inputs: &Inputs) -> Outputs {
        Self::step(self, inputs)
    }
}

/// Who asks the controller for what, and when.
struct Operator {
    /// When the command was taken, ms.
    started_ms: Option<u32>,
    /// When the self test had passed, ms.
    ready_ms: Option<u32>,
    /// How many of the setpoints have been sent.
    sent: usize,
    next_ms: u32,
    ended_ms: Option<u32>,
}

impl Operator {
    fn act<C: Core>(&mut self, now_ms: u32, last: Option<Mode>, program: &Program, host_silent: bool, core: &mut C) {
        if self.started_ms.is_none() {
            if last != Some(Mode::Vented) {
                self.ready_ms = None;
                return;
            }
            let ready_ms = *self.ready_ms.get_or_insert(now_ms);
            if now_ms < ready_ms + STANDBY_MS {
                return;
            }
        }
        match program {
            Program::Sequence(sequence) => {
                if self.started_ms.is_none() && core.command(Command::Run(sequence)) {
                    self.started_ms = Some(now_ms);
                } else if last == Some(Mode::Vented) && self.started_ms.is_some_and(|started| now_ms > started + 1) {
                    self.ended_ms.get_or_insert(now_ms);
                }
            }
            Program::ByHand(_) if host_silent => {}
            Program::ByHand(setpoints) => {
                if self.started_ms.is_some() && now_ms < self.next_ms || self.ended_ms.is_some() {
                    return;
                }
                if let Some(&(wish, hold_ms)) = setpoints.get(self.sent) {
                    let command = match wish {
                        Wish::Pressures(pressures) => Command::Setpoints(pressures),
                        Wish::Bends(bends) => Command::Bends(bends),
                    };
                    if core.command(command) {
                        self.started_ms.get_or_insert(now_ms);
                        self.sent += 1;
                        self.next_ms = now_ms + hold_ms;
                    }
                } else if core.command(Command::Vent) {
                    self.ended_ms = Some(now_ms);
                }
            }
        }
    }
}

/// What stands between the machine and its controller.
struct Surroundings {
    /// The controller does not step before this, ms; its last outputs stay at the pins until a reset.
    blocked_until_ms: u32,
    /// Outputs are de-energised: no power, or a reset.
    safe: bool,
    /// What is reported when it starts again.
    report: Option<Fault>,
    /// Ticks that are late.
    late_ticks: u32,
    /// This controller's time zero, ms.
    born_ms: u32,
}

/// Simulates a run and judges it; `seen` gets every tick's sample, if it asks for it.
pub fn drive<C: Core>(case: &Case, mut seen: impl FnMut(&dyn Fn() -> Sample)) -> Outcome {
    let injected = case.faults.iter().filter_map(super::draw::Drawn::injected);
    let mut plant = Plant::new(case.plant.clone(), Scene::default().with_faults(injected), case.noise_seed);
    let damaged = case.faults.iter().any(|fault| fault.what == What::Settings);
    let mut core = C::start(case.calibration, damaged.then_some(Fault::SettingsCorrupt));
    let mut judge = Judge::new(case);
    let mut operator = Operator { started_ms: None, ready_ms: None, sent: 0, next_ms: 0, ended_ms: None };
    let mut around = Surroundings { blocked_until_ms: 0, safe: false, report: None, late_ticks: 0, born_ms: 0 };
    let mut actuation = Actuation::SAFE;
    let mut last: Option<Outputs> = None;
    let by_hand = matches!(case.program, Program::ByHand(_));
    let limit_ms = START_LIMIT_MS + case.program.duration_ms() + AFTER_PROGRAM_MS;
    let mut now_ms = 0_u32;
    loop {
        let mut host_silent = !(by_hand || case.host_listens);
        for fault in &case.faults {
            let since = now_ms.checked_sub(fault.from_ms);
            match (fault.what, since) {
                (What::SilentHost, Some(_)) => host_silent = true,
                (What::Hang, Some(0)) => {
                    around.blocked_until_ms = now_ms + WATCHDOG_MS + BOOT_MS;
                    around.report = Some(Fault::TaskHang);
                }
                (What::Hang, Some(WATCHDOG_MS)) => around.safe = true,
                (What::Dip { ms }, Some(0)) => {
                    around.blocked_until_ms = now_ms + ms + BOOT_MS;
                    (around.safe, around.report) = (true, Some(Fault::PowerDip));
                }
                // The tick that comes late takes two others with it.
                (What::LateTick { of }, Some(since)) if since % of == 0 && around.late_ticks == 0 => {
                    around.late_ticks = 2;
                }
                _ => {}
            }
        }
        let mut inputs = plant.inputs();
        inputs.host_heard = !host_silent;
        let blocked = now_ms < around.blocked_until_ms;
        let mut event = Event::Ticked;
        if blocked {
            event = Event::Missing { safe: around.safe };
            // The interlock and the emergency stop act in an interrupt, task or no task.
            if around.safe || inputs.over_pressure_switch || inputs.emergency_stop {
                actuation = Actuation::SAFE;
            }
        } else {
            if let Some(fault) = around.report.take() {
                core = C::start(case.calibration, Some(fault));
                (around.safe, around.born_ms, last) = (false, now_ms, None);
                judge.restarted();
            }
            if around.late_ticks > 1 {
                around.late_ticks -= 1;
                event = Event::Missing { safe: false };
            } else {
                inputs.overrun = around.late_ticks == 1;
                around.late_ticks = 0;
                inputs.now = Millis(now_ms - around.born_ms);
                operator.act(
                    now_ms,
                    last.map(|outputs| outputs.mode),
                    &case.program,
                    by_hand && host_silent,
                    &mut core,
                );
                let outputs = core.step(&inputs);
                actuation = outputs.actuation;
                last = Some(outputs);
            }
        }
        let done = judge.tick(now_ms, event, last.as_ref(), actuation, &plant);
        seen(&|| sample(now_ms, &inputs, last.as_ref(), actuation, &plant));
        plant.step(&actuation);
        now_ms += 1;
        let over = operator.ended_ms.is_some_and(|ended| now_ms > ended + AFTER_PROGRAM_MS);
        let idle = operator.started_ms.is_none() && now_ms > START_LIMIT_MS;
        if done || (!judge.is_venting() && (over || idle || now_ms > limit_ms)) {
            return judge.outcome(now_ms);
        }
    }
}

fn sample(time_ms: u32, inputs: &Inputs, outputs: Option<&Outputs>, actuation: Actuation, plant: &Plant) -> Sample {
    let truth = plant.truth();
    Sample {
        time_ms,
        actuation,
        mode: outputs.map_or(Mode::SelfTest, |outputs| outputs.mode),
        faults: outputs.map_or(FaultSet::EMPTY, |outputs| outputs.faults),
        step: outputs.map_or(0, |outputs| outputs.step),
        repeat: outputs.map_or(0, |outputs| outputs.repeat),
        holding: outputs.is_some_and(|outputs| outputs.holding),
        setpoints_kpa: outputs.map_or([0.0; 3], |outputs| outputs.setpoints.map(Pressure::to_f64)),
        estimates_kpa: outputs.map_or([0.0; 3], |outputs| outputs.estimates.map(Pressure::to_f64)),
        chambers_kpa: truth.chambers_kpa,
        manifold_kpa: truth.manifold_kpa,
        sensor_kpa: inputs.manifold.valid().map_or(f64::NAN, Pressure::to_f64),
        bends_deg: truth.bends_deg,
        bend_sensor_deg: inputs.bend.valid().map_or(f64::NAN, Bend::to_f64),
    }
}
