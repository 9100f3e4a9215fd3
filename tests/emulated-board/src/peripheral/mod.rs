//! What the firmware touches of the STM32F446's peripherals (reference manual RM0390), and nothing else.

pub mod adc;
pub mod dma;
pub mod flash;
pub mod gpio;
pub mod nvic;
pub mod power;
pub mod timer;
pub mod usart;
pub mod watchdog;
