//! The emulated board with the simulated finger as a device on a line: what `host-sim monitor --elf` talks to.

use crate::bench::Bench;
use crate::firmware_elf;
use crate::machine::Halt;
use crate::time::MILLISECOND;
use anyhow::{Result, bail};
use host_sim::monitor::source::{Device, Happened};
use host_sim::report::record::{Record, Source};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// The most board time that one poll makes, ms: keys are looked at after it.
const MOST_MS: u64 = 20;
/// How long the truth is kept, ms: a frame comes some milliseconds after its sample.
const KEPT_MS: usize = 200;

/// The plant at one time of the board's clock.
struct Truth {
    board_ms: u32,
    chambers_kpa: [f64; 3],
    manifold_kpa: f64,
    bends_deg: [f64; 3],
}

/// See the module's page.
pub struct OnLine {
    /// Board and finger.
    pub bench: Bench,
    seed: u64,
    /// Times as fast as a clock; nothing is as fast as can be.
    speed: Option<f64>,
    start: Instant,
    truth: VecDeque<Truth>,
}

impl OnLine {
    /// Just switched on.
    ///
    /// # Errors
    /// When the firmware is not built.
    pub fn new(seed: u64, speed: Option<f64>) -> Result<Self> {
        let bench = Bench::with_seed(&firmware_elf()?, seed)?;
        Ok(Self { bench, seed, speed, start: Instant::now(), truth: VecDeque::new() })
    }

    /// The board's time to which it is to be run now, ms.
    fn due_ms(&self, wait: Duration) -> u64 {
        let now = self.bench.milliseconds();
        let due = match self.speed {
            None => now + MOST_MS,
            Some(speed) => ((self.start.elapsed() + wait).as_secs_f64() * 1000.0 * speed) as u64,
        };
        due.min(now + MOST_MS)
    }

    fn note(&mut self) {
        let truth = self.bench.plant.truth();
        self.truth.push_back(Truth {
            board_ms: (self.bench.board.time() / MILLISECOND) as u32,
            chambers_kpa: truth.chambers_kpa,
            manifold_kpa: truth.manifold_kpa,
            bends_deg: truth.bends_deg,
        });
        if self.truth.len() > KEPT_MS {
            self.truth.pop_front();
        }
    }
}

impl Device for OnLine {
    fn source(&self) -> Source {
        Source::Emulated
    }

    fn name(&self) -> String {
        format!("emulated board, seed {}", self.seed)
    }

    fn now_ms(&self) -> u64 {
        self.bench.milliseconds()
    }

    fn unix_ms(&self) -> Option<u64> {
        // The same seed gives the same bytes.
        None
    }

    fn poll(&mut self, wait: Duration) -> Result<Happened> {
        let due_ms = self.due_ms(wait);
        let mut bytes = Vec::new();
        while self.bench.milliseconds() < due_ms {
            let (halt, sent) = self.bench.step_on_the_line()?;
            match halt {
                // A reset is seen by the device's clock.
                None | Some(Halt::Reset(_)) => {}
                Some(halt) => bail!("the board stopped: {halt:?}; log {:?}", self.bench.board.log_lines()),
            }
            self.note();
            bytes.extend(sent);
        }
        if let Some(speed) = self.speed {
            // Ahead of the clock: the rest of the wait is slept.
            let board = Duration::from_secs_f64(self.bench.milliseconds() as f64 / 1000.0 / speed);
            std::thread::sleep(board.saturating_sub(self.start.elapsed()).min(wait));
        }
        Ok(if bytes.is_empty() { Happened::Nothing } else { Happened::Bytes(bytes) })
    }

    fn send(&mut self, bytes: &[u8]) {
        self.bench.board.send(bytes);
    }

    /// The true pressures and bends at the sample's time; nobody knows them on a real device.
    fn complete(&self, row: &mut Record) {
        let Some(truth) = self.truth.iter().rev().find(|truth| Some(truth.board_ms) == row.device_ms) else { return };
        row.chambers_kpa = truth.chambers_kpa;
        row.manifold_kpa = truth.manifold_kpa;
        row.bends_deg = truth.bends_deg;
    }
}
