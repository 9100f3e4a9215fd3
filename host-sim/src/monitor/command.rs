//! `host-sim monitor` on the command line.

use super::keys::{Keys, calibrate};
use super::live::Live;
use super::playback::Playback;
use super::recording::Recorder;
use super::script::Script;
use super::source::Device;
use super::source::serial::{Serial, Wanted};
use super::summary::{Summary, Tally};
use super::{dashboard, headless, snapshot, terminal};
use crate::calibrate::file;
use crate::cli::{self, Emulator, Failure, print};
use crate::report::csv;
use anyhow::{Result, anyhow};
use clap::{ArgGroup, Args};
use model_core::sequence::{Sequence, library};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Size of the snapshot, columns and rows.
const SNAPSHOT: (u16, u16) = (100, 26);

#[derive(Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of the command line")]
#[command(group = ArgGroup::new("from").required(true).args(["port", "elf", "replay"]))]
pub(crate) struct MonitorArguments {
    /// The serial port of a device; auto takes the board's own.
    #[arg(long, value_name = "PATH|auto")]
    port: Option<String>,
    /// The emulated board with the simulated finger. The first time installs and builds what that needs.
    #[arg(long)]
    elf: bool,
    /// A recording, or a simulated run's samples.csv.
    #[arg(long, value_name = "FILE")]
    replay: Option<PathBuf>,
    /// How fast the emulated board or a recording goes: 2 is twice as fast as a clock. Without a terminal: as fast as can be.
    #[arg(long, value_name = "X", value_parser = speed, conflicts_with = "port")]
    speed: Option<f64>,
    /// Seed of the emulated board's sensors.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Where rows are recorded: a new file. Default: finger-DATE-TIME.csv here.
    #[arg(long, value_name = "FILE", conflicts_with = "replay")]
    record: Option<PathBuf>,
    /// Coefficients as `host-sim calibrate` writes them: sent at once without a terminal, and by the key l on one.
    #[arg(long, value_name = "FILE", conflicts_with = "replay")]
    calibration: Option<PathBuf>,
    /// No dashboard, though stdout is a terminal.
    #[arg(long)]
    headless: bool,
    /// Without a dashboard: runs this sequence, to its end unless --for says otherwise.
    #[arg(long, value_name = "NAME", value_parser = sequence, conflicts_with = "replay")]
    sequence: Option<&'static Sequence>,
    /// Without a dashboard: when the sequence has ended, the device uses what it has identified (sequence calibrate), and stores it.
    #[arg(long, requires = "sequence", conflicts_with = "seconds")]
    adopt: bool,
    /// Without a dashboard: ends so many seconds after the first frame.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds, conflicts_with = "replay")]
    seconds: Option<f64>,
    /// Without a dashboard: prints the summary as JSON.
    #[arg(long)]
    json: bool,
    /// Writes the dashboard as it is at --at as a picture, and ends.
    #[arg(long, value_name = "OUT.svg", requires = "replay")]
    snapshot: Option<PathBuf>,
    /// Time of the snapshot, seconds from the recording's start. Default: its end.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "snapshot")]
    at: Option<f64>,
}

fn speed(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (0.01..=1000.0).contains(value));
    value.ok_or_else(|| format!("{text:?} is no speed: a number from 0.01 to 1000"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (0.0..=1e6).contains(value));
    value.ok_or_else(|| format!("{text:?} is no time: seconds from 0 to 1000000"))
}

fn sequence(name: &str) -> Result<&'static Sequence, String> {
    library::find(name).ok_or_else(|| cli::unknown_sequence(name))
}

impl MonitorArguments {
    fn interactive(&self) -> bool {
        let asked_for = self.headless || self.json || self.sequence.is_some() || self.seconds.is_some();
        !asked_for && std::io::stdout().is_terminal()
    }
}

/// Shows, or records without showing.
pub(crate) fn execute(arguments: &MonitorArguments, emulator: Option<&Emulator>) -> Result<(), Failure> {
    if let Some(file) = &arguments.replay {
        return replay(arguments, file);
    }
    let calibration = match &arguments.calibration {
        None => [None; 3],
        Some(path) => file::read(path)
            .and_then(|calibration| calibration.segments())
            .map_err(|error| Failure::Input(format!("{error:#}")))?,
    };
    let device: Box<dyn Device> = if arguments.elf {
        let Some(emulator) = emulator else { return cli::start_elf() };
        // Without anybody who watches there is nothing to wait for.
        let speed = arguments.speed.or_else(|| arguments.interactive().then_some(1.0));
        (emulator.device)(arguments.seed, speed)?
    } else {
        let wanted = match arguments.port.as_deref() {
            None | Some("auto") => Wanted::Auto,
            Some(path) => Wanted::Path(path.to_owned()),
        };
        Box::new(Serial::new(wanted).map_err(Failure::Input)?)
    };
    let recorder = Recorder::create(arguments.record.as_deref()).map_err(Failure::Input)?;
    let stop = stopped_by_signals()?;
    let mut live = Live::new(device, recorder);
    if arguments.interactive() {
        let keys = Keys { calibration, ..Keys::default() };
        terminal::monitor(&mut live, keys, &stop)?;
        print(&format!("recording: {} ({} rows)\n", live.recorder().path().display(), live.recorder().rows()))?;
        return Ok(());
    }
    let for_ms = arguments.seconds.map(|seconds| (seconds * 1000.0) as u64);
    let mut script = Script::new(calibrate(&calibration), arguments.sequence, for_ms).adopting(arguments.adopt);
    let (summary, failure) = headless::run(&mut live, &mut script, &stop)?;
    tell(&summary, arguments.json)?;
    match failure {
        Some(why) => Err(Failure::Run(anyhow!(why))),
        None => Ok(()),
    }
}

fn tell(summary: &Summary, json: bool) -> Result<()> {
    if json { print(&format!("{:#}\n", serde_json::to_value(summary)?)) } else { print(&summary.text()) }
}

/// Set when the process is asked to end: what it has set in motion is to be vented first.
fn stopped_by_signals() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let mut signals = vec![signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM];
    #[cfg(unix)]
    signals.push(signal_hook::consts::SIGHUP);
    for signal in signals {
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

fn replay(arguments: &MonitorArguments, file: &Path) -> Result<(), Failure> {
    let name = file.display().to_string();
    let bytes = std::fs::read(file).map_err(|error| Failure::Input(format!("cannot read {name}: {error}")))?;
    let recording = csv::read(&bytes).map_err(|error| Failure::Input(format!("{name}: {error:#}")))?;
    if let Some((line, why)) = &recording.first_bad {
        eprintln!("warning: {name}: {} lines left out; line {line}: {why}", recording.bad_lines);
    }
    if let Some(picture) = &arguments.snapshot {
        let mut playback = Playback::new(recording.records, 1.0);
        let end = f64::from(playback.place_and_end_ms().1) / 1000.0;
        let state = playback.jump(arguments.at.unwrap_or(end).min(end));
        let keys = Keys { replay: true, ..Keys::default() };
        let mut canvas = Terminal::new(TestBackend::new(SNAPSHOT.0, SNAPSHOT.1)).map_err(|error| anyhow!("{error}"))?;
        let status = terminal::replay_status(&playback, &file.file_name().unwrap_or_default().to_string_lossy());
        canvas
            .draw(|frame| dashboard::draw(frame, &state, &keys, &status))
            .map_err(|error| anyhow!("cannot draw: {error}"))?;
        let svg = snapshot::svg(canvas.backend().buffer());
        return std::fs::write(picture, svg)
            .map_err(|error| Failure::Input(format!("cannot write {}: {error}", picture.display())));
    }
    if arguments.interactive() {
        let mut playback = Playback::new(recording.records, arguments.speed.unwrap_or(1.0));
        return Ok(terminal::replay(&mut playback, &name, &*stopped_by_signals()?)?);
    }
    let mut tally = Tally::default();
    recording.records.iter().for_each(|row| tally.take(row));
    Ok(tell(&tally.summary(&name, &name), arguments.json)?)
}
