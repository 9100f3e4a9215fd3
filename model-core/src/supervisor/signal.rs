//! What the pressure signal itself shows: how rough it is, and whether it moves faster than air can.

use super::held::lasts;
use crate::units::Pressure;

/// Mean absolute second difference above which the reading is noisy. White noise of 0.3 kPa rms has 0.6 kPa; a valve that
/// opens bends the reading by 5 kPa in one tick, which counts a sixty-fourth. Five times the noise is found.
const NOISY: Pressure = Pressure::from_milli_kpa(2000);
/// Below this the reading has no noise of its own, and a sensor's output stands still: its converter alone has 0.1 kPa. A sound
/// sensor with half the noise has 0.3 kPa, and over the mean's 64 ticks a tenth of that more or less.
const SMOOTH: Pressure = Pressure::from_milli_kpa(175);
/// Largest change in [`RATE_TICKS`] ticks. Three chambers at 150 kPa that open into an empty manifold through valves with 1.4
/// times their conductance raise it by 5.3 kPa/ms for a few milliseconds only, seen through the sensor's lag.
const RATE: Pressure = Pressure::from_kpa(36);
const RATE_TICKS: usize = 4;
/// A change that fast must be seen so often: one disturbed sample is seen four times, as a change there and back.
const RATE_COUNT: u8 = 2;

/// See the module's page.
#[derive(Clone, Debug, Default)]
pub(super) struct Signal {
    /// The last readings, newest first.
    last: [Pressure; RATE_TICKS],
    /// How many readings there have been, up to their number.
    count: u8,
    roughness: Pressure,
    fast: u8,
    noisy: u8,
}

/// What it shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Shown {
    pub noisy: bool,
    pub too_fast: bool,
}

impl Signal {
    pub(super) const fn new() -> Self {
        // Starts with a sound sensor's roughness, so that it is not taken for one that stands still.
        let roughness = Pressure::from_milli_kpa(600);
        Self { last: [Pressure::ZERO; RATE_TICKS], count: 0, roughness, fast: 0, noisy: 0 }
    }

    /// One reading.
    pub(super) fn watch(&mut self, reading: Pressure) -> Shown {
        let [first, second, third, fourth] = self.last;
        let mut shown = Shown::default();
        if usize::from(self.count) >= RATE_TICKS {
            let bend = ((reading - first) - (first - second)).abs();
            self.roughness = self.roughness.low_passed(bend, 6);
            // Both ends twice: what comes back at once was one sample.
            let fast = (reading - fourth).abs() > RATE && (first - fourth).abs() > RATE;
            shown.too_fast = lasts(&mut self.fast, fast, RATE_COUNT);
            shown.noisy = lasts(&mut self.noisy, self.roughness > NOISY, 20);
        } else {
            self.count += 1;
        }
        self.last = [reading, first, second, third];
        shown
    }

    /// The reading has less noise than a sound sensor has.
    pub(super) fn stands_still(&self) -> bool {
        self.roughness < SMOOTH
    }

    /// It has more.
    pub(super) fn is_noisy(&self) -> bool {
        self.roughness > NOISY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a run of readings in kPa shows: ever noisy, ever too fast; and the tick of the first.
    fn shown(readings: impl Iterator<Item = f64>) -> (bool, bool, Option<usize>) {
        let mut signal = Signal::new();
        readings.enumerate().fold((false, false, None), |(noisy, fast, first), (tick, reading)| {
            let shown = signal.watch(Pressure::from_f64_kpa(reading));
            let any = shown.noisy || shown.too_fast;
            (noisy | shown.noisy, fast | shown.too_fast, first.or(any.then_some(tick)))
        })
    }

    /// Noise of about this many kPa rms, the same every time.
    fn noise(rms: f64) -> impl FnMut(usize) -> f64 {
        let mut state = 1_u64;
        move |_| {
            let mut sum = 0.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                sum += (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5;
            }
            rms * sum
        }
    }

    #[test]
    fn noise_is_told_from_more_noise() {
        let (noisy, fast, _) = shown((0..200_000).map(noise(0.45)));
        assert!(!noisy && !fast);
        let (noisy, _, first) = shown((0..2000).map(noise(3.0)));
        assert!(noisy && first.is_some_and(|tick| tick < 100), "{first:?}");
    }

    #[test]
    fn air_is_slower_than_a_jump() {
        // The manifold as three full chambers open into it, through the sensor's lag: the fastest that air does.
        let filling =
            (0..200).map(|tick| if tick < 50 { 0.0 } else { 110.0 * (1.0 - (-f64::from(tick - 50) / 14.0).exp()) });
        assert_eq!(shown(filling), (false, false, None));
        let (_, fast, first) = shown((0..200).map(|tick| if tick < 50 { 10.0 } else { 60.0 }));
        assert!(fast && first.is_some_and(|tick| tick < 55), "{first:?}");
        let one_sample = (0..200).map(|tick| if tick == 50 { 140.0 } else { 60.0 });
        assert!(!shown(one_sample).1);
    }

    #[test]
    fn a_signal_that_stands_still_is_smooth() {
        let mut signal = Signal::new();
        assert!(!signal.stands_still());
        let mut noise_of = noise(0.05);
        for tick in 0..400 {
            signal.watch(Pressure::from_f64_kpa(60.0 + noise_of(tick)));
        }
        assert!(signal.stands_still() && !signal.is_noisy());
    }
}
