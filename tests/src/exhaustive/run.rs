//! The visit itself, on all cores or over a list of inputs.

use super::report::Outcome;
use super::tally::Tally;
use super::{Direction, Subject};
use std::ops::RangeInclusive;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Inputs that a core takes at a time.
const CHUNK: i64 = 1 << 20;

/// Every `i32`.
#[must_use]
pub fn every_input() -> RangeInclusive<i32> {
    i32::MIN..=i32::MAX
}

/// The domain with one input on either side.
#[must_use]
pub fn domain(direction: Direction) -> RangeInclusive<i32> {
    -1..=direction.domain_end() + 1
}

/// Visits all inputs of `range` on all cores; `done` is told how many more have been visited.
///
/// # Panics
/// When the function panics at its domain's end, which nothing can be judged without.
#[must_use]
pub fn visit(subject: &Subject, range: &RangeInclusive<i32>, done: impl Fn(u64) + Sync) -> Outcome {
    let started = Instant::now();
    let value_at_end = subject.evaluate(subject.direction.domain_end());
    // In i64, where nothing overflows at the ends of i32.
    let (start, end) = (i64::from(*range.start()), i64::from(*range.end()));
    let chunks = ((end - start) / CHUNK + 1) as usize;
    let next = AtomicUsize::new(0);
    let tallies = Mutex::new(vec![Tally::default(); chunks]);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= chunks {
                        break;
                    }
                    let first = start + index as i64 * CHUNK;
                    let last = (first + CHUNK - 1).min(end);
                    let mut tally = Tally::default();
                    // Both lie within the range, whose ends are i32.
                    tally.visit(subject, value_at_end, first as i32..=last as i32);
                    done((last - first + 1) as u64);
                    tallies.lock().expect("no thread panics while it holds the lock")[index] = tally;
                }
            });
        }
    });
    let tallies = tallies.into_inner().expect("no thread panics while it holds the lock");
    let total = tallies.into_iter().fold(Tally::default(), Tally::followed_by);
    Outcome::new(subject, &total, started.elapsed().as_secs_f64())
}

/// Visits the inputs of a rising list.
///
/// # Panics
/// As [`visit`].
#[must_use]
pub fn visit_some(subject: &Subject, inputs: &[i32]) -> Outcome {
    let started = Instant::now();
    let mut tally = Tally::default();
    tally.visit(subject, subject.evaluate(subject.direction.domain_end()), inputs.iter().copied());
    Outcome::new(subject, &tally, started.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::super::subjects;
    use super::*;
    use model_core::calibration::DEFAULT;

    /// Both ways of visiting see the same; the range ends at the last i32 and spans a border of chunks.
    #[test]
    fn chunks_leave_nothing_out() {
        for subject in subjects(&DEFAULT) {
            let range = i32::MAX - 1_100_000..=i32::MAX;
            let seen = std::sync::atomic::AtomicU64::new(0);
            let chunked = visit(&subject, &range, |count| {
                seen.fetch_add(count, Ordering::Relaxed);
            });
            let listed = visit_some(&subject, &range.collect::<Vec<_>>());
            assert_eq!((chunked.inputs, chunked.failures), (1_100_001, 0));
            assert_eq!(seen.into_inner(), 1_100_001);
            assert_eq!(listed.inputs, chunked.inputs);
        }
        for subject in subjects(&DEFAULT) {
            let range = 1_000_000..=2_100_000;
            let chunked = visit(&subject, &range, |_| ());
            let listed = visit_some(&subject, &range.collect::<Vec<_>>());
            assert_eq!(chunked.worst_input_bits, listed.worst_input_bits);
            assert_eq!(chunked.histogram, listed.histogram);
            assert!(chunked.domain_inputs == 1_100_001 && chunked.worst_error_lsb > 0.4, "{chunked:?}");
        }
    }
}
