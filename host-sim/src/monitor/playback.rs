//! A recording that is played: which rows are due. No clock, no I/O.

use super::state::State;
use crate::report::record::Record;

/// See the module's page.
#[derive(Debug)]
pub struct Playback {
    rows: Vec<Record>,
    next: usize,
    /// Time played, ms of the recording, from its first row on.
    place_ms: f64,
    /// It stands still.
    pub held: bool,
    speed: f64,
}

impl Playback {
    /// At the first row of a recording's rows, in the order of time.
    #[must_use]
    pub const fn new(rows: Vec<Record>, speed: f64) -> Self {
        Self { rows, next: 0, place_ms: 0.0, held: false, speed }
    }

    fn start_ms(&self) -> u32 {
        self.rows.first().map_or(0, |row| row.time_ms)
    }

    /// Place and end, ms from the first row on.
    #[must_use]
    pub fn place_and_end_ms(&self) -> (u32, u32) {
        let end = self.rows.last().map_or(0, |row| row.time_ms - self.start_ms());
        ((self.place_ms as u32).min(end), end)
    }

    /// Every row was played.
    #[must_use]
    pub fn over(&self) -> bool {
        self.next >= self.rows.len()
    }

    /// Time goes on by so many milliseconds of the host: the rows that are due.
    pub fn advance(&mut self, elapsed_ms: f64) -> &[Record] {
        let from = self.next;
        if !self.held && !self.over() {
            self.place_ms += elapsed_ms * self.speed;
            self.find();
        }
        &self.rows[from..self.next]
    }

    fn find(&mut self) {
        let until = f64::from(self.start_ms()) + self.place_ms;
        self.next = self.rows.partition_point(|row| f64::from(row.time_ms) <= until);
    }

    /// Jumps by so many seconds; returns what is then to be shown.
    pub fn jump(&mut self, seconds: f64) -> State {
        let (_, end) = self.place_and_end_ms();
        self.place_ms = (self.place_ms + 1000.0 * seconds).clamp(0.0, f64::from(end));
        self.find();
        let mut state = State::default();
        self.rows[..self.next].iter().for_each(|row| state.take(row));
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::record::Source;

    fn rows(first_ms: u32) -> Vec<Record> {
        (0..1000).map(|index| Record::unknown(Source::Device, first_ms + 10 * index)).collect()
    }

    #[test]
    fn rows_come_at_their_time_each_once() {
        let mut playback = Playback::new(rows(5000), 2.0);
        assert_eq!(playback.advance(0.0).len(), 1);
        // 25 ms at double speed: 10 to 50 ms after the first row.
        let due: Vec<_> = playback.advance(25.0).iter().map(|row| row.time_ms).collect();
        assert_eq!(due, [5010, 5020, 5030, 5040, 5050]);
        playback.held = true;
        assert_eq!(playback.advance(1e9).len(), 0);
        playback.held = false;
        assert_eq!(playback.advance(1e9).len(), 994);
        assert!(playback.over());
        assert_eq!(playback.place_and_end_ms(), (9990, 9990));
    }

    #[test]
    fn a_jump_shows_what_was_so_then() {
        let mut playback = Playback::new(rows(0), 1.0);
        playback.advance(9000.0);
        let state = playback.jump(-5.0);
        assert_eq!(state.last().map(|row| row.time_ms), Some(4000));
        assert_eq!(playback.advance(10.0)[0].time_ms, 4010);
        assert_eq!(playback.jump(-60.0).last().map(|row| row.time_ms), Some(0));
        assert_eq!(playback.jump(60.0).last().map(|row| row.time_ms), Some(9990));
    }
}
