//! The dashboard on a terminal: keys, rows, pictures, until it is left.

use super::dashboard::{self, Status};
use super::event;
use super::keys::{Action, Keys};
use super::link::Quality;
use super::live::Live;
use super::playback::Playback;
use super::state::State;
use anyhow::{Context, Result};
use model_core::protocol::LinkCommand;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self as input, Event};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time between two pictures.
const PICTURE: Duration = Duration::from_millis(66);
/// Longest wait for the line before the keys are looked at.
const TURN: Duration = Duration::from_millis(10);

/// A terminal that is as it was before when this is dropped, also by a panic.
struct Screen(DefaultTerminal);

impl Screen {
    fn new() -> Result<Self> {
        Ok(Self(ratatui::try_init().context("the terminal cannot show the dashboard: use --headless")?))
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

/// Every key that was pressed.
fn pressed(keys: &mut Keys, wait: Duration) -> Result<Vec<Action>> {
    let mut actions = Vec::new();
    let mut wait = wait;
    while input::poll(wait)? {
        if let Event::Key(key) = input::read()? {
            actions.extend(keys.press(key));
        }
        wait = Duration::ZERO;
    }
    Ok(actions)
}

/// Shows a device until it is left.
///
/// # Errors
/// When the device or the terminal fails.
pub fn monitor(live: &mut Live, mut keys: Keys, stop: &AtomicBool) -> Result<()> {
    let mut screen = Screen::new()?;
    let mut state = State::default();
    let mut shown: Option<Instant> = None;
    loop {
        live.turn(TURN)?.iter().for_each(|row| state.take(row));
        let mut actions = pressed(&mut keys, Duration::ZERO)?;
        if stop.load(Ordering::Relaxed) {
            actions.push(Action::Quit);
        }
        for action in actions {
            match action {
                Action::Ask(command) => live.ask(command),
                Action::Acknowledge => state.acknowledge(),
                Action::Quit => {
                    live.vent()?;
                    return Ok(());
                }
                Action::Leave => {
                    live.leave();
                    return Ok(());
                }
                Action::Hold | Action::Jump(_) => {}
            }
        }
        if shown.is_none_or(|then| then.elapsed() >= PICTURE) {
            shown = Some(Instant::now());
            let status = status(live);
            screen.0.draw(|frame| dashboard::draw(frame, &state, &keys, &status))?;
        }
    }
}

fn status(live: &Live) -> Status {
    let session = &live.session;
    let now_ms = live.device().now_ms();
    let recording = match live.recorder().trouble() {
        Some(trouble) => Err(trouble.to_owned()),
        None => Ok(live.recorder().path().display().to_string()),
    };
    Status {
        source: live.device().name(),
        firmware: session.identity().map(|identity| identity.firmware.to_string()),
        connection: Some(session.connection().clone()),
        age_ms: session.age_ms(now_ms),
        now_ms,
        quality: *session.quality(),
        recording,
        asked: session.asked().filter(|command| **command != LinkCommand::Identify).map(event::name),
        identified: session.identified().copied(),
        replay: None,
    }
}

/// What is known beside a replay's rows.
#[must_use]
pub fn replay_status(playback: &Playback, file: &str) -> Status {
    let (place, end) = playback.place_and_end_ms();
    Status {
        source: file.to_owned(),
        firmware: None,
        connection: None,
        age_ms: None,
        now_ms: 0,
        quality: Quality::default(),
        recording: Ok(String::new()),
        asked: None,
        identified: None,
        replay: Some((place, end, playback.held || playback.over())),
    }
}

/// Shows a recording until it is left.
///
/// # Errors
/// When the terminal fails.
pub fn replay(playback: &mut Playback, file: &str, stop: &AtomicBool) -> Result<()> {
    let mut screen = Screen::new()?;
    let mut keys = Keys { replay: true, ..Keys::default() };
    let mut state = State::default();
    let mut then = Instant::now();
    while !stop.load(Ordering::Relaxed) {
        let elapsed = core::mem::replace(&mut then, Instant::now()).elapsed();
        playback.advance(elapsed.as_secs_f64() * 1000.0).iter().for_each(|row| state.take(row));
        for action in pressed(&mut keys, PICTURE)? {
            match action {
                Action::Quit | Action::Leave => return Ok(()),
                Action::Acknowledge => state.acknowledge(),
                Action::Hold => playback.held = !playback.held,
                Action::Jump(seconds) => state = playback.jump(f64::from(seconds)),
                Action::Ask(_) => {}
            }
        }
        let status = replay_status(playback, file);
        screen.0.draw(|frame| dashboard::draw(frame, &state, &keys, &status))?;
    }
    Ok(())
}
