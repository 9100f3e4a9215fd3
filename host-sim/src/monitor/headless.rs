//! A session without anybody at the keys.

use super::live::Live;
use super::script::{Script, Stage};
use super::summary::{Summary, Tally};
use anyhow::Result;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Follows a script until it is over, or the process is asked to end; then vents what it has set in motion. Returns the
/// summary, and why the script failed.
///
/// # Errors
/// When the device cannot go on at all.
pub fn run(live: &mut Live, script: &mut Script, stop: &AtomicBool) -> Result<(Summary, Option<String>)> {
    let mut tally = Tally::default();
    while !stop.load(Ordering::Relaxed) && !script.over(live.device().now_ms()) {
        for row in live.turn(Duration::from_millis(20))? {
            tally.take(&row);
        }
        let now_ms = live.device().now_ms();
        if let Some(command) = script.next(&mut live.session, now_ms) {
            live.ask(command);
        }
    }
    if script.started() && !matches!(script.stage(), Stage::Adopting | Stage::Finished(_)) {
        live.vent()?.iter().for_each(|row| tally.take(row));
    }
    live.leave();
    let mut failure = match script.stage() {
        Stage::Failed(why) => Some(why.clone()),
        Stage::Asking if !script.started() && script.sequence().is_some() => {
            Some("the sequence was not started before the time was over".into())
        }
        _ => None,
    };
    if tally.state.last().is_none() {
        failure.get_or_insert_with(|| "no frame came: is the device switched on, and this its port?".into());
    }
    if let Some(trouble) = live.recorder().trouble() {
        failure.get_or_insert_with(|| format!("the recording is not whole: {trouble}"));
    }
    Ok((summary(live, script, &tally), failure))
}

fn summary(live: &Live, script: &Script, tally: &Tally) -> Summary {
    let quality = live.session.quality();
    let outcome = match script.stage() {
        Stage::Adopting | Stage::Finished(_) => "finished".to_owned(),
        Stage::Failed(why) => why.clone(),
        Stage::Running if script.started() => "running".into(),
        Stage::Asking | Stage::Running => "not-started".into(),
    };
    Summary {
        firmware: live.session.identity().map(|identity| identity.firmware.to_string()),
        sequence: script.sequence().map(|sequence| sequence.name.to_owned()),
        sequence_outcome: script.sequence().map(|_| outcome),
        frames: Some(quality.frames),
        frames_lost: Some(quality.lost),
        frames_bad: Some(quality.bad()),
        frames_bad_crc: Some(quality.bad_crc),
        longest_gap_s: Some(live.session.gaps().1 as f64 / 1000.0),
        ..tally.summary(&live.device().name(), &live.recorder().path().display().to_string())
    }
}

#[cfg(test)]
mod tests;
