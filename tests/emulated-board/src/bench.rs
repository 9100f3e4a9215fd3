//! The emulated board with the simulated finger on it, and a host on its UART.

use crate::board::{Board, Pin};
use crate::machine::Halt;
use crate::time::{MICROSECOND, MILLISECOND};
use anyhow::{Result, bail};
use host_sim::plant::{Plant, PlantParameters, Scene};
use model_core::actuation::{Actuation, Passage};
use model_core::protocol::{
    Decoder, FrameError, LinkCommand, LinkMode, MAX_FRAME, Report, Request, SequenceName, Telemetry, encode,
};

const PUMP: Pin = Pin('B', 5);
const DUMP: Pin = Pin('B', 10);
const SEGMENTS: [Pin; 3] = [Pin('A', 8), Pin('A', 9), Pin('A', 10)];
/// The ISE30A's switch: high is over-pressure.
pub const SWITCH: Pin = Pin('C', 2);
/// The emergency stop: high is pressed.
pub const STOP: Pin = Pin('C', 3);
/// The start button: low is pressed.
pub const START: Pin = Pin('C', 13);
const FAULT_LIGHT: Pin = Pin('C', 8);
const PRESSURE_CHANNEL: u8 = 10;
const BEND_CHANNEL: u8 = 11;

/// Scans in a tick of the firmware.
const SCANS: usize = 16;

/// From the converter's tick to the plant's step.
const PHASE: u64 = 700 * MICROSECOND;

/// Longest time until a request is answered, ms.
const ANSWER_MS: u32 = 100;

/// See the module's page.
pub struct Bench {
    /// The board.
    pub board: Board,
    /// The finger.
    pub plant: Plant,
    /// Telemetry so far.
    pub telemetry: Vec<Telemetry>,
    /// Answers that nobody has taken.
    pub answers: Vec<Report>,
    /// Frames from the board that could not be read.
    pub damaged: Vec<FrameError>,
    decoder: Decoder,
    next_id: u16,
    /// Emergency stop and switch pressed by hand, beside the plant's own.
    pub stop_pressed: bool,
    /// The same for the switch.
    pub switch_pressed: bool,
    milliseconds: u64,
}

impl Bench {
    /// Firmware and finger at rest, just switched on.
    ///
    /// # Errors
    /// When the file is not the firmware's ELF.
    pub fn new(elf: &[u8], parameters: PlantParameters, scene: Scene, seed: u64) -> Result<Self> {
        Self::assemble(Board::new(elf)?, Plant::new(parameters, scene, seed))
    }

    fn assemble(board: Board, plant: Plant) -> Result<Self> {
        let mut bench = Self {
            board,
            plant,
            telemetry: Vec::new(),
            answers: Vec::new(),
            damaged: Vec::new(),
            decoder: Decoder::new(),
            next_id: 1,
            stop_pressed: false,
            switch_pressed: false,
            milliseconds: 0,
        };
        bench.board.wire(START, true);
        bench.wire();
        bench.wire_sensors();
        bench.align()?;
        Ok(bench)
    }

    /// Puts the plant's steps [`PHASE`] after the converter's ticks, so that a tick's decision is on the pins before the
    /// plant takes it.
    fn align(&mut self) -> Result<()> {
        let mut scans = 0;
        while scans < SCANS {
            let next = self.board.time() + 10 * MICROSECOND;
            if self.board.run_until(next)?.is_some() || next > 100 * MILLISECOND {
                bail!("the converter does not start; log {:?}", self.board.log_lines());
            }
            scans = self.board.converted();
        }
        let next = self.board.time() + PHASE;
        self.board.run_until(next)?;
        Ok(())
    }

    /// The default finger, on a board whose settings' flash holds what another one left.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_settings(elf: &[u8], seed: u64, settings: Vec<u8>) -> Result<Self> {
        let plant = Plant::new(PlantParameters::default(), Scene::default(), seed);
        Self::assemble(Board::with_settings(elf, Some(settings))?, plant)
    }

    /// Any finger, on a board whose settings' flash holds what another one left.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_plant(elf: &[u8], plant: Plant, settings: Vec<u8>) -> Result<Self> {
        Self::assemble(Board::with_settings(elf, Some(settings))?, plant)
    }

    /// The default finger.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_seed(elf: &[u8], seed: u64) -> Result<Self> {
        Self::new(elf, PlantParameters::default(), Scene::default(), seed)
    }

    /// What the sensors' outputs carry: from one tick of the converter to the next, so that the sixteen scans of a reading share one draw
    /// of the noise, which is that of a reading. Two in one would be smoother than a sound sensor.
    fn wire_sensors(&mut self) {
        self.board.set_analogue(PRESSURE_CHANNEL, self.plant.pressure_code());
        self.board.set_analogue(BEND_CHANNEL, self.plant.bend_code());
    }

    fn wire(&mut self) {
        let inputs = self.plant.inputs();
        self.board.wire(SWITCH, inputs.over_pressure_switch || self.switch_pressed);
        self.board.wire(STOP, inputs.emergency_stop || self.stop_pressed);
    }

    /// What the coils do to the machine: a coil whose pin is no output rests.
    #[must_use]
    pub fn actuation(&self) -> Actuation {
        let current = |pin| self.board.driven(pin) == Some(true);
        let passage = |pin| if current(pin) { Passage::Closed } else { Passage::Open };
        Actuation { pump: current(PUMP), dump: passage(DUMP), segments: SEGMENTS.map(passage) }
    }

    /// One millisecond of board and finger. A reset is carried out, and returned.
    ///
    /// # Errors
    /// As [`Board::run_until`].
    pub fn step(&mut self) -> Result<Option<Halt>> {
        let (halt, sent) = self.step_on_the_line()?;
        for byte in sent {
            match self.decoder.push::<Report>(byte) {
                Some(Ok(Report::Telemetry(telemetry))) => self.telemetry.push(telemetry),
                Some(Ok(answer)) => self.answers.push(answer),
                Some(Err(error)) => self.damaged.push(error),
                None => {}
            }
        }
        Ok(halt)
    }

    /// The same for a host of its own: returns the bytes that the board has sent, and looks at none of them.
    ///
    /// # Errors
    /// As [`Board::run_until`].
    pub fn step_on_the_line(&mut self) -> Result<(Option<Halt>, Vec<u8>)> {
        self.wire();
        let until = self.board.time() + MILLISECOND;
        let mut halt = self.board.run_until(until - PHASE)?;
        self.wire_sensors();
        if halt.is_none() {
            halt = self.board.run_until(until)?;
        }
        if let Some(Halt::Reset(cause)) = halt {
            self.board.reset(cause)?;
        }
        let sent = self.board.take_sent();
        self.plant.step(&self.actuation());
        self.milliseconds += 1;
        Ok((halt, sent))
    }

    /// One millisecond of the finger without power on the board, which has been reset.
    pub fn step_unpowered(&mut self) {
        self.plant.step(&self.actuation());
        self.milliseconds += 1;
    }

    /// Whether the fault light is on: in the tick in which a fault that vents is latched.
    #[must_use]
    pub fn fault_light(&self) -> bool {
        self.board.driven(FAULT_LIGHT) == Some(true)
    }

    /// Milliseconds of the plant's time.
    #[must_use]
    pub const fn milliseconds(&self) -> u64 {
        self.milliseconds
    }

    /// Runs on.
    ///
    /// # Errors
    /// As [`Board::run_until`]; a reset and a power cut too.
    pub fn run_ms(&mut self, milliseconds: u32) -> Result<()> {
        for _ in 0..milliseconds {
            if let Some(halt) = self.step()? {
                bail!("the board stopped: {halt:?}; log {:?}", self.board.log_lines());
            }
        }
        Ok(())
    }

    /// Runs until the self test has passed, and a little on, so that the sensor's zero is trimmed.
    ///
    /// # Errors
    /// When it does not pass within ten seconds, or the board stops.
    pub fn ready(&mut self) -> Result<()> {
        for _ in 0..10_000 {
            self.run_ms(1)?;
            if self.telemetry.last().is_some_and(|told| told.mode == LinkMode::Vented) {
                return self.run_ms(200);
            }
        }
        bail!("the self test does not pass: {:?}", self.telemetry.last())
    }

    /// Sends a request; returns its id.
    pub fn request(&mut self, command: LinkCommand) -> u16 {
        let id = self.next_id;
        self.next_id = self.next_id.wrapping_add(1);
        let mut frame = [0; MAX_FRAME];
        let length = encode(&Request { id, command }, &mut frame).unwrap_or(0);
        self.board.send(&frame[..length]);
        id
    }

    /// Sends a request and waits for its answer.
    ///
    /// # Errors
    /// When none comes, or the board stops.
    pub fn ask(&mut self, command: &LinkCommand) -> Result<Report> {
        let id = self.request(command.clone());
        for _ in 0..ANSWER_MS {
            self.run_ms(1)?;
            let of_it = |report: &Report| match report {
                Report::Ack { id: other }
                | Report::Nack { id: other, .. }
                | Report::Identification { id: other, .. } => *other == id,
                Report::Identity(identity) => identity.id == id,
                Report::Telemetry(_) => false,
            };
            if let Some(index) = self.answers.iter().position(of_it) {
                return Ok(self.answers.remove(index));
            }
        }
        bail!("{command:?} got no answer within {ANSWER_MS} ms; log {:?}", self.board.log_lines())
    }

    /// Sends a request that has to be taken.
    ///
    /// # Errors
    /// When it is not, or as [`Self::ask`].
    pub fn take(&mut self, command: &LinkCommand) -> Result<()> {
        match self.ask(command)? {
            Report::Ack { .. } => Ok(()),
            other => bail!("{command:?} is answered by {other:?}"),
        }
    }

    /// Starts a built-in sequence.
    ///
    /// # Errors
    /// As [`Self::take`].
    pub fn start(&mut self, sequence: &str) -> Result<()> {
        self.take(&LinkCommand::Run(SequenceName::try_from(sequence)?))
    }

    /// Virtual time from the edge of an alarm input until every coil rests, microseconds.
    ///
    /// # Errors
    /// When a millisecond is not enough, or the board stops.
    pub fn rest_latency_us(&mut self, alarm: Pin) -> Result<f64> {
        let start = self.board.time();
        self.board.wire(alarm, true);
        while self.actuation() != Actuation::SAFE {
            let next = self.board.time() + MICROSECOND / 4;
            if let Some(halt) = self.board.run_until(next)? {
                bail!("the board stopped: {halt:?}");
            }
            if self.board.time() - start >= MILLISECOND {
                bail!("not every coil rests after a millisecond");
            }
        }
        Ok((self.board.time() - start) as f64 / MICROSECOND as f64)
    }
}
