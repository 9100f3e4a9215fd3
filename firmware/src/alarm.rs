//! An input that raises an alarm, wired so that a broken wire raises it too: emergency stop, pressure switch.

use core::future::pending;
use embedded_hal::digital::InputPin;
use embedded_hal_async::digital::Wait;

/// See the module's page.
#[derive(Debug)]
pub struct AlarmInput<P> {
    pin: P,
    /// Level of the alarm.
    high_is_alarm: bool,
}

impl<P: InputPin + Wait> AlarmInput<P> {
    /// On a pin; `high_is_alarm` tells which level is the alarm.
    pub const fn new(pin: P, high_is_alarm: bool) -> Self {
        Self { pin, high_is_alarm }
    }

    /// Whether the alarm is up. A pin that cannot be read is one.
    pub fn is_raised(&mut self) -> bool {
        self.pin.is_high().map_or(true, |high| high == self.high_is_alarm)
    }

    /// Waits until the alarm is up. A pin that cannot be waited for is one.
    pub async fn raised(&mut self) {
        let _ = if self.high_is_alarm { self.pin.wait_for_high().await } else { self.pin.wait_for_low().await };
    }

    /// Waits until the alarm is down; for ever when the pin cannot be waited for.
    pub async fn cleared(&mut self) {
        let waited = if self.high_is_alarm { self.pin.wait_for_low().await } else { self.pin.wait_for_high().await };
        if waited.is_err() {
            pending::<()>().await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::pin::pin;
    use core::task::{Context, Poll, Waker};
    use embedded_hal::digital::{Error, ErrorKind, ErrorType};

    /// A pin at a level, or a broken one.
    struct Pin(Option<bool>);

    #[derive(Debug)]
    struct Broken;
    impl Error for Broken {
        fn kind(&self) -> ErrorKind {
            ErrorKind::Other
        }
    }
    impl ErrorType for Pin {
        type Error = Broken;
    }
    impl InputPin for Pin {
        fn is_high(&mut self) -> Result<bool, Broken> {
            self.0.ok_or(Broken)
        }
        fn is_low(&mut self) -> Result<bool, Broken> {
            self.0.map(|high| !high).ok_or(Broken)
        }
    }
    impl Pin {
        async fn wait(&self, high: bool) -> Result<(), Broken> {
            match self.0 {
                None => Err(Broken),
                Some(level) if level == high => Ok(()),
                Some(_) => pending().await,
            }
        }
    }
    impl Wait for Pin {
        async fn wait_for_high(&mut self) -> Result<(), Broken> {
            self.wait(true).await
        }
        async fn wait_for_low(&mut self) -> Result<(), Broken> {
            self.wait(false).await
        }
        async fn wait_for_rising_edge(&mut self) -> Result<(), Broken> {
            pending().await
        }
        async fn wait_for_falling_edge(&mut self) -> Result<(), Broken> {
            pending().await
        }
        async fn wait_for_any_edge(&mut self) -> Result<(), Broken> {
            pending().await
        }
    }

    fn is_ready(future: impl Future<Output = ()>) -> bool {
        pin!(future).poll(&mut Context::from_waker(Waker::noop())) == Poll::Ready(())
    }

    #[test]
    fn what_cannot_be_read_is_an_alarm_that_never_clears() {
        for (level, high_is_alarm, raised) in [
            (Some(true), true, true),
            (Some(false), true, false),
            (Some(false), false, true),
            (Some(true), false, false),
            (None, true, true),
            (None, false, true),
        ] {
            let mut input = AlarmInput::new(Pin(level), high_is_alarm);
            assert_eq!(input.is_raised(), raised);
            assert_eq!(is_ready(input.raised()), raised);
            assert_eq!(is_ready(input.cleared()), !raised);
        }
    }
}
