//! Runs of host-sim's campaign with the firmware's ELF as the controller: the same draws, the same judge.
//!
//! What concerns the board is done on it for real: tasks hang until the watchdog bites or are held up, power goes, the host
//! falls silent, the settings' flash is damaged. The judge looks at pins and plant. What the controller believes it
//! hears from the telemetry, a hundred times a second, and puts it to the tick that the fault light names.

use crate::bench::Bench;
use crate::machine::Halt;
use crate::peripheral::flash::SECTOR;
use crate::time::MILLISECOND;
use anyhow::{Context, Result, anyhow, bail};
use finger_drivers::settings::Settings;
use host_sim::campaign::draw::{Case, Drawn, Filter, Program, STANDBY_MS, What, Wish};
use host_sim::campaign::judge::{Event, Judge, Outcome};
use host_sim::campaign::shard::{Campaign, Part, SCHEMA};
use host_sim::campaign::tally::Tally;
use host_sim::plant::{Plant, Scene};
use model_core::actuation::Actuation;
use model_core::controller::{Fault, Mode, Outputs, Reading};
use model_core::protocol::{LinkCommand, ResetCause, SequenceName, Telemetry};
use model_core::supervisor::fault::FaultSet;
use model_core::units::{Bend, Pressure};
use std::collections::VecDeque;
use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The judge looks at a tick this much later, ms: its telemetry has come by then.
const HEARD_AFTER_MS: usize = 40;
/// From a reset to the first control tick, ms.
const BOOT_MS: u32 = 20;
/// A host that drives says so this often, ms.
const BEAT_MS: u32 = 200;
/// A command that has not changed the mode is sent again after this, ms.
const AGAIN_MS: u32 = 200;
/// As on the core: after the program's end a run goes on for this long, ms.
const AFTER_PROGRAM_MS: u32 = 3000;
/// As on the core: a run ends when the controller has not started its program by then, ms.
const START_LIMIT_MS: u32 = 15_000;

/// A tick as it was, until the judge looks at it.
struct Moment {
    now_ms: u32,
    /// Starts of the board so far, and its own time then, ms.
    starts: usize,
    board_ms: u32,
    event: Event,
    fault_light: bool,
    actuation: Actuation,
    /// Since when all pins rest, the board's own time, ms.
    rests_since: Option<u32>,
    plant: Plant,
}

/// Who asks the board for what, by what its telemetry says.
#[derive(Default)]
struct Operator {
    ready_ms: Option<u32>,
    asked_ms: Option<u32>,
    started_ms: Option<u32>,
    sent: usize,
    next_ms: u32,
    ended_ms: Option<u32>,
}

impl Operator {
    fn act(
        &mut self,
        now_ms: u32,
        mode: Option<Mode>,
        program: &Program,
        silent: bool,
        bench: &mut Bench,
    ) -> Result<()> {
        let drives = matches!(mode, Some(Mode::Running | Mode::Holding));
        if self.started_ms.is_none() && drives {
            self.started_ms = self.asked_ms;
        }
        if self.started_ms.is_none() {
            if mode != Some(Mode::Vented) {
                self.ready_ms = None;
                return Ok(());
            }
            let ready_ms = *self.ready_ms.get_or_insert(now_ms);
            if now_ms < ready_ms + STANDBY_MS || self.asked_ms.is_some_and(|asked| now_ms < asked + AGAIN_MS) {
                return Ok(());
            }
        }
        match program {
            Program::Sequence(sequence) if self.started_ms.is_none() => {
                bench.request(LinkCommand::Run(SequenceName::try_from(sequence.name)?));
                self.asked_ms = Some(now_ms);
            }
            Program::Sequence(_) if mode == Some(Mode::Vented) => {
                self.ended_ms.get_or_insert(now_ms);
            }
            Program::Sequence(_) => {}
            Program::ByHand(_) if silent => {}
            Program::ByHand(setpoints) => {
                let waits = self.started_ms.is_some() && now_ms < self.next_ms;
                if waits || self.ended_ms.is_some() {
                    return Ok(());
                }
                let next = if self.started_ms.is_none() { 0 } else { self.sent };
                if let Some(&(wish, hold_ms)) = setpoints.get(next) {
                    bench.request(match wish {
                        Wish::Pressures(pressures) => LinkCommand::Setpoints(pressures.map(Pressure::to_bits)),
                        Wish::Bends(bends) => LinkCommand::Bends(bends.map(Bend::to_bits)),
                    });
                    self.asked_ms = Some(now_ms);
                    (self.sent, self.next_ms) = (next + 1, now_ms + hold_ms);
                } else {
                    bench.request(LinkCommand::Vent);
                    self.ended_ms = Some(now_ms);
                }
            }
        }
        Ok(())
    }
}

/// The settings' flash that a calibration of this finger left; one bit of it flipped when it is `damaged`.
fn flash(case: &Case, damaged: bool) -> Vec<u8> {
    let settings = Settings { coefficients: case.calibration, pressure_zero: Pressure::ZERO, bend_zero: Bend::ZERO };
    let mut flash = vec![0xFF; 2 * SECTOR];
    let record = settings.to_record(1);
    flash[..record.len()].copy_from_slice(&record);
    if damaged {
        flash[9] ^= 1;
    }
    flash
}

/// Everything of one run.
struct Run<'a> {
    case: &'a Case,
    bench: Bench,
    judge: Judge<'a>,
    operator: Operator,
    moments: VecDeque<Moment>,
    /// Where the telemetry of each start begins.
    starts: Vec<usize>,
    judged_starts: usize,
    rests_since: Option<u32>,
    now_ms: u32,
    /// The board is hung or without power: nothing to hear until it has started again.
    missing: Option<Missing>,
}

/// Why no tick comes.
enum Missing {
    Hung,
    Unpowered { until_ms: u32 },
    Boots { until_ms: u32 },
}

/// Simulates a run on the board and judges it.
///
/// # Errors
/// When the board does something that is not modelled.
pub fn run_one(elf: &[u8], case: &Case) -> Result<Outcome> {
    let injected = case.faults.iter().filter_map(Drawn::injected);
    let plant = Plant::new(case.plant.clone(), Scene::default().with_faults(injected), case.noise_seed);
    let damaged = case.faults.iter().any(|fault| fault.what == What::Settings);
    let mut run = Run {
        case,
        bench: Bench::with_plant(elf, plant, flash(case, damaged))?,
        judge: Judge::new(case),
        operator: Operator::default(),
        moments: VecDeque::new(),
        starts: vec![0],
        judged_starts: 1,
        rests_since: None,
        now_ms: 0,
        missing: None,
    };
    let limit_ms = START_LIMIT_MS + case.program.duration_ms() + AFTER_PROGRAM_MS;
    loop {
        if run.tick()? {
            return Ok(run.judge.outcome(run.now_ms));
        }
        let operator = &run.operator;
        let over = operator.ended_ms.is_some_and(|ended| run.now_ms > ended + AFTER_PROGRAM_MS);
        let idle = operator.started_ms.is_none() && run.now_ms > START_LIMIT_MS;
        if !run.judge.is_venting() && (over || idle || run.now_ms > limit_ms) {
            while let Some(moment) = run.moments.pop_front() {
                run.judge(&moment);
            }
            return Ok(run.judge.outcome(run.now_ms));
        }
    }
}

impl Run<'_> {
    /// A millisecond of everything; true when the judge has seen enough.
    fn tick(&mut self) -> Result<bool> {
        let by_hand = matches!(self.case.program, Program::ByHand(_));
        let mut silent = !(by_hand || self.case.host_listens);
        let mut held_up = false;
        for fault in &self.case.faults {
            let since = self.now_ms.checked_sub(fault.from_ms);
            match (fault.what, since) {
                (What::SilentHost, Some(_)) => silent = true,
                (What::Hang, Some(0)) => {
                    self.bench.board.hang()?;
                    self.missing = Some(Missing::Hung);
                }
                (What::Dip { ms }, Some(0)) => {
                    self.bench.board.reset(ResetCause::Brownout)?;
                    self.restarted();
                    self.missing = Some(Missing::Unpowered { until_ms: self.now_ms + ms });
                }
                (What::LateTick { of }, Some(since)) => held_up |= since % of < 2,
                _ => {}
            }
        }
        if !silent && self.now_ms.is_multiple_of(BEAT_MS) && self.missing.is_none() {
            self.bench.request(LinkCommand::Beat);
        }
        let mode = self.bench.telemetry[self.starts[self.starts.len() - 1]..].last().and_then(|told| told.mode.mode());
        if self.missing.is_none() {
            self.operator.act(self.now_ms, mode, &self.case.program, by_hand && silent, &mut self.bench)?;
        }
        let plant = self.bench.plant.clone();
        let event = self.run_board(held_up)?;
        let board_ms = (self.bench.board.time() / MILLISECOND) as u32;
        let actuation = self.bench.actuation();
        self.rests_since = (actuation == Actuation::SAFE).then(|| self.rests_since.unwrap_or(board_ms));
        self.moments.push_back(Moment {
            now_ms: self.now_ms,
            starts: self.starts.len(),
            board_ms,
            event,
            fault_light: self.bench.fault_light(),
            actuation,
            rests_since: self.rests_since,
            plant,
        });
        self.now_ms += 1;
        if self.moments.len() <= HEARD_AFTER_MS {
            return Ok(false);
        }
        Ok(self.moments.pop_front().is_some_and(|moment| self.judge(&moment)))
    }

    /// The board's millisecond, and the finger's.
    fn run_board(&mut self, held_up: bool) -> Result<Event> {
        match self.missing {
            Some(Missing::Unpowered { until_ms }) if self.now_ms < until_ms => {
                self.bench.step_unpowered();
                return Ok(Event::Missing { safe: true });
            }
            Some(Missing::Unpowered { .. }) => {
                self.missing = Some(Missing::Boots { until_ms: self.now_ms + BOOT_MS });
            }
            Some(Missing::Boots { until_ms }) if self.now_ms >= until_ms => self.missing = None,
            _ => {}
        }
        let suspended = if held_up && self.missing.is_none() { Some(self.bench.board.suspend()?) } else { None };
        let halt = self.bench.step()?;
        match halt {
            Some(Halt::Reset(_)) => {
                self.restarted();
                self.missing = Some(Missing::Boots { until_ms: self.now_ms + BOOT_MS });
            }
            Some(other) => bail!("the board stopped: {other:?}; log {:?}", self.bench.board.log_lines()),
            None => {
                if let Some(pc) = suspended {
                    self.bench.board.release(pc)?;
                }
            }
        }
        Ok(match self.missing {
            None if suspended.is_some() => Event::Missing { safe: false },
            None => Event::Ticked,
            Some(Missing::Hung) => Event::Missing { safe: false },
            Some(_) => Event::Missing { safe: true },
        })
    }

    fn restarted(&mut self) {
        self.starts.push(self.bench.telemetry.len());
    }

    fn judge(&mut self, moment: &Moment) -> bool {
        let outputs = if moment.event == Event::Ticked {
            if moment.starts != self.judged_starts {
                self.judged_starts = moment.starts;
                self.judge.restarted();
            }
            self.told(moment)
        } else {
            None
        };
        // Nothing heard yet: as good as not stepped.
        let event = if outputs.is_some() { moment.event } else { Event::Missing { safe: true } };
        self.judge.tick(moment.now_ms, event, outputs.as_ref(), moment.actuation, &moment.plant)
    }

    /// What the controller said of a tick: the last telemetry before it, or the next one when the fault light, or pins that came to rest,
    /// say that a fault was latched between the two.
    fn told(&self, moment: &Moment) -> Option<Outputs> {
        let from = self.starts[moment.starts - 1];
        let to = self.starts.get(moment.starts).copied().unwrap_or(self.bench.telemetry.len());
        let all = &self.bench.telemetry[from..to];
        let next = all.partition_point(|told| told.tick <= moment.board_ms);
        let before = next.checked_sub(1).and_then(|index| all.get(index));
        let faulted = |told: &&Telemetry| matches!(told.mode.mode(), Some(Mode::Faulted(_)));
        let came_to_rest = moment.rests_since.is_some_and(|since| before.is_some_and(|told| since > told.tick));
        let latched = moment.fault_light || came_to_rest;
        let told = if latched && before.is_none_or(|told| !faulted(&told)) {
            all[next..].iter().take(2).find(faulted).or(before)
        } else {
            before
        };
        told.map(|told| outputs(told, moment.actuation))
    }
}

fn outputs(told: &Telemetry, actuation: Actuation) -> Outputs {
    // A fault that this version does not know vents all the same; the emergency stop stands for it.
    let mode = told.mode.mode().unwrap_or(Mode::Faulted(Fault::EmergencyStop));
    Outputs {
        actuation,
        mode,
        faults: FaultSet::from_bits(told.faults),
        setpoints: told.setpoints.map(Pressure::from_bits),
        estimates: told.estimates.map(Pressure::from_bits),
        step: told.step,
        repeat: told.repeat,
        holding: told.holding,
        manifold: told.manifold.map_or(Reading::BelowRange, |bits| Reading::Valid(Pressure::from_bits(bits))),
        bend: told.bend.map_or(Reading::BelowRange, |bits| Reading::Valid(Bend::from_bits(bits))),
    }
}

/// Which runs.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// The campaign's seed.
    pub seed: u64,
    /// How many.
    pub runs: u64,
    /// Runs with longer programs, ms, are passed over for the next ones.
    pub longest_ms: Option<u32>,
}

/// All of them, on all cores, counted as host-sim counts them.
///
/// # Errors
/// As [`run_one`].
pub fn run_all(elf: &[u8], options: &Options) -> Result<Part> {
    let fits = |case: &Case| options.longest_ms.is_none_or(|longest| case.program.duration_ms() <= longest);
    let cases: Vec<Case> = (0..)
        .map(|index| Case::draw(options.seed, index, &Filter::default()))
        .filter(fits)
        .take(options.runs as usize)
        .collect();
    let bar = host_sim::progress::bar(cases.len(), "runs");
    let next = AtomicUsize::new(0);
    let work = || -> Result<Tally> {
        let mut tally = Tally::new();
        while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            tally.count(case, &run_one(elf, case).with_context(|| format!("run {}", case.index))?);
            bar.inc(1);
        }
        Ok(tally)
    };
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    let mut result = Tally::new();
    std::thread::scope(|scope| -> Result<()> {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        for worker in workers {
            result.add(&worker.join().map_err(|_| anyhow!("a run panicked"))??);
        }
        Ok(())
    })?;
    bar.finish_and_clear();
    let campaign = Campaign { schema: SCHEMA, seed: options.seed, runs: options.runs, fault: None, sequence: None };
    Ok(Part { campaign, shard: None, result })
}
