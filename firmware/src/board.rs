//! The one place that names pins, interrupts, priorities, polarities and sensor laws. `docs/wiring.md` shows the same.

use embassy_stm32::adc::{Adc, AdcChannel, Exten, RingBufferedAdc, SampleTime};
use embassy_stm32::exti::ExtiInput;
use embassy_stm32::flash::{Blocking, Flash};
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::mode::Async;
use embassy_stm32::pac;
use embassy_stm32::peripherals::{ADC1, DMA1_CH5, DMA1_CH6, DMA2_CH0, IWDG, USART2};
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::{RoundTo, Timer};
use embassy_stm32::usart::{RingBufferedUartRx, Uart, UartTx};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{bind_interrupts, dma, exti, triggers, usart};
use finger_drivers::alarm::AlarmInput;
use finger_drivers::bf350::{Bf350, BridgeLaw, NOMINAL_TABLE};
use finger_drivers::ise30a::{AnalogueLaw, Ise30a};
use finger_drivers::relay::{Coil, Relay, Valve};
use finger_drivers::settings::Store;
use model_core::units::Millis;

/// Converter scans in one control tick.
pub const SCANS: usize = 16;
/// Channels in a scan: pressure, bend.
pub const CHANNELS: usize = 2;
/// Conversions in one control tick.
pub const TICK_CODES: usize = SCANS * CHANNELS;
/// Baud rate on the ST-LINK's virtual COM port: telemetry takes less than half of it.
pub const BAUD: u32 = 230_400;
/// The watchdog bites this long after the last feeding.
pub const WATCHDOG_US: u32 = 100_000;

/// While a flash sector is erased nothing else runs; two seconds at the most (data sheet DS10693).
const ERASING_US: u32 = 4_000_000;
/// The two sectors behind the program, as offsets into the flash, and their size.
const SETTINGS_SECTORS: [u32; 2] = [0x4_0000, 0x6_0000];
const SETTINGS_SECTOR_BYTES: u32 = 128 * 1024;

/// The pressure sensor's analogue output behind its divider.
pub const PRESSURE: Ise30a = Ise30a::new(AnalogueLaw::NOMINAL);
/// The strain gauge's amplifier.
pub const BEND: Bf350<3> = Bf350::new(BridgeLaw::NOMINAL, NOMINAL_TABLE);

/// A coil's driver stage is a low-side MOSFET: high is current.
const COIL_ON_IS_HIGH: bool = true;
/// Alarm contacts are closed to ground while all is well: high is the alarm, or a broken wire.
const ALARM_IS_HIGH: bool = true;
/// Shortest time of the pump's relay in either state: what its contacts need to settle (assumed). In
/// host-sim's runs of the built-in sequences the regulator's shortest pulse is 8 ms and its shortest pause 35 ms.
const RELAY_SHORTEST: Millis = Millis(5);

bind_interrupts!(pub struct Irqs {
    USART2 => usart::InterruptHandler<USART2>;
    DMA1_STREAM5 => dma::InterruptHandler<DMA1_CH5>;
    DMA1_STREAM6 => dma::InterruptHandler<DMA1_CH6>;
    DMA2_STREAM0 => dma::InterruptHandler<DMA2_CH0>;
    EXTI2 => exti::InterruptHandler<interrupt::typelevel::EXTI2>;
    EXTI3 => exti::InterruptHandler<interrupt::typelevel::EXTI3>;
});

/// The interrupt that the interlock's executor runs in; its own peripheral is not used.
pub use embassy_stm32::interrupt::UART5 as INTERLOCK_INTERRUPT;

/// Emergency stop or pressure switch.
pub type Alarm = AlarmInput<ExtiInput<'static, Async>>;

/// Everything that drives coils.
pub type Coils = finger_drivers::coils::Coils<Output<'static>>;

/// The board, its parts handed out.
pub struct Board {
    pub coils: Coils,
    /// Closed at rest, to ground: high is pressed, or a broken wire.
    pub emergency_stop: Alarm,
    /// The ISE30A's switch, closed to ground while pressure is right: high is over-pressure, or a broken wire.
    pub over_pressure: Alarm,
    /// The blue button: low is pressed.
    pub start_button: Input<'static>,
    pub running_led: Output<'static>,
    pub fault_led: Output<'static>,
    pub adc: RingBufferedAdc<'static, ADC1>,
    pub sampling: Timer<'static, embassy_stm32::peripherals::TIM3>,
    pub receiver: RingBufferedUartRx<'static>,
    pub transmitter: UartTx<'static, Async>,
    pub watchdog: IndependentWatchdog<'static, IWDG>,
    pub store: Store<Flash<'static, Blocking>>,
}

/// Clocks: 8 MHz from the ST-LINK, PLL to 180 MHz; APB1 at 45 MHz, APB2 at 90 MHz.
fn clocks() -> embassy_stm32::Config {
    let mut config = embassy_stm32::Config::default();
    config.rcc.hse = Some(Hse { freq: Hertz(8_000_000), mode: HseMode::Bypass });
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll =
        Some(Pll { prediv: PllPreDiv::DIV4, mul: PllMul::MUL180, divp: Some(PllPDiv::DIV2), divq: None, divr: None });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV4;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    config
}

/// Starts the chip. Buffers are the caller's, because DMA goes on writing to them for ever.
pub fn start(adc_buffer: &'static mut [u16], uart_buffer: &'static mut [u8]) -> Option<Board> {
    let p = embassy_stm32::init(clocks());
    // Interlock first, then time, then data.
    interrupt::EXTI2.set_priority(Priority::P1);
    interrupt::EXTI3.set_priority(Priority::P1);
    INTERLOCK_INTERRUPT.set_priority(Priority::P2);
    interrupt::TIM5.set_priority(Priority::P1);
    interrupt::DMA2_STREAM0.set_priority(Priority::P6);
    interrupt::DMA1_STREAM5.set_priority(Priority::P7);
    interrupt::DMA1_STREAM6.set_priority(Priority::P7);
    interrupt::USART2.set_priority(Priority::P7);

    let resting = if COIL_ON_IS_HIGH { Level::Low } else { Level::High };
    macro_rules! coil {
        ($pin:expr) => {
            Coil::new(Output::new($pin, resting, Speed::Low), COIL_ON_IS_HIGH)
        };
    }
    let coils = Coils {
        pump: Relay::new(coil!(p.PB5), RELAY_SHORTEST),
        dump: Valve(coil!(p.PB10)),
        segments: [Valve(coil!(p.PA8)), Valve(coil!(p.PA9)), Valve(coil!(p.PA10))],
    };

    let sampling = Timer::new(p.TIM3);
    // Sixteen scans a millisecond; each update starts one.
    sampling.set_frequency(Hertz(16_000), RoundTo::Slower);
    pac::TIM3.cr2().modify(|w| w.set_mms(pac::timer::vals::Mms::UPDATE));
    let sequence = [(p.PC0.degrade_adc(), SampleTime::CYCLES56), (p.PC1.degrade_adc(), SampleTime::CYCLES56)];
    let adc = Adc::new(p.ADC1).into_ring_buffered(
        p.DMA2_CH0,
        adc_buffer,
        Irqs,
        sequence.into_iter(),
        triggers::TIM3_TRGO,
        Exten::RISING_EDGE,
    );

    let mut config = usart::Config::default();
    config.baudrate = BAUD;
    let uart = Uart::new(p.USART2, p.PA3, p.PA2, p.DMA1_CH6, p.DMA1_CH5, Irqs, config).ok()?;
    let (transmitter, receiver) = uart.split();
    Some(Board {
        coils,
        emergency_stop: Alarm::new(ExtiInput::new(p.PC3, p.EXTI3, Pull::Up, Irqs), ALARM_IS_HIGH),
        over_pressure: Alarm::new(ExtiInput::new(p.PC2, p.EXTI2, Pull::Up, Irqs), ALARM_IS_HIGH),
        start_button: Input::new(p.PC13, Pull::None),
        running_led: Output::new(p.PA5, Level::Low, Speed::Low),
        fault_led: Output::new(p.PC8, Level::Low, Speed::Low),
        adc,
        sampling,
        receiver: receiver.into_ring_buffered(uart_buffer),
        transmitter,
        watchdog: IndependentWatchdog::new(p.IWDG, WATCHDOG_US),
        store: Store::new(Flash::new_blocking(p.FLASH), SETTINGS_SECTORS, SETTINGS_SECTOR_BYTES),
    })
}

/// Gives the watchdog the patience that erasing a sector takes, or its usual one again. Only for a vented finger: while
/// the sector is erased nothing but the coils' own rest is safe.
pub fn watchdog_waits_for_erasing(waits: bool) {
    // SAFETY: the supervision task owns the watchdog to feed it; this only changes its time, and is no other owner.
    let watchdog = unsafe { IWDG::steal() };
    let mut watchdog = IndependentWatchdog::new(watchdog, if waits { ERASING_US } else { WATCHDOG_US });
    // The new values take a few cycles of the watchdog's own clock to get there (RM0390, IWDG_SR); feeding earlier would
    // load the old ones. At 32 kHz and the largest prescaler that is 40 ms; the loop's end is only for a dead clock.
    for _ in 0..4_000_000_u32 {
        if pac::IWDG.sr().read().0 == 0 {
            break;
        }
    }
    watchdog.pet();
}

/// Lets every coil rest without asking anybody: for the panic and fault handlers, which own nothing.
pub fn release_coils() {
    let (a, b) = ([8, 9, 10], [5, 10]);
    for pin in a {
        pac::GPIOA.bsrr().write(|w| if COIL_ON_IS_HIGH { w.set_br(pin, true) } else { w.set_bs(pin, true) });
    }
    for pin in b {
        pac::GPIOB.bsrr().write(|w| if COIL_ON_IS_HIGH { w.set_br(pin, true) } else { w.set_bs(pin, true) });
    }
}
