//! Converter to samples: sixteen scans summed, one sample a millisecond, stamped with the time of the last scan.

use crate::beats::{self, Beat};
use crate::board::{CHANNELS, TICK_CODES};
use embassy_stm32::adc::RingBufferedAdc;
use embassy_stm32::peripherals::{ADC1, TIM3};
use embassy_stm32::timer::low_level::Timer;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Instant;
use model_core::units::Millis;

/// One tick's conversions.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Time of the last of them, since start.
    pub at: Millis,
    /// Counts samples, lost ones too.
    pub number: u32,
    /// Sum of the [`SCANS`](crate::board::SCANS) codes of each channel.
    pub sums: [u32; CHANNELS],
}

/// The newest sample. One that was not taken in time is lost, which its number shows.
pub static SAMPLE: Signal<CriticalSectionRawMutex, Sample> = Signal::new();

#[embassy_executor::task]
pub async fn acquire(mut adc: RingBufferedAdc<'static, ADC1>, sampling: Timer<'static, TIM3>) -> ! {
    let mut codes = [0; TICK_CODES];
    let mut number = 0_u32;
    sampling.start();
    loop {
        let outcome = adc.read(&mut codes).await;
        number = number.wrapping_add(1);
        beats::beat(Beat::Acquisition);
        if outcome.is_err() {
            // The buffer was lapped: what it holds is no tick. The number goes on, so the loss is counted.
            continue;
        }
        let mut sums = [0_u32; CHANNELS];
        for scan in codes.chunks_exact(CHANNELS) {
            for (sum, &code) in sums.iter_mut().zip(scan) {
                *sum += u32::from(code);
            }
        }
        let at = Millis(Instant::now().as_millis() as u32);
        SAMPLE.signal(Sample { at, number, sums });
    }
}
