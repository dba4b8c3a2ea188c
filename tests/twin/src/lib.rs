//! The twin: emulated STM32F405 boards on two CAN buses, in virtual time.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod board;
pub mod bxcan;
pub mod clock;
pub mod cpu;
pub mod image;
pub mod link;
pub mod mmio;
pub mod peripherals;
pub mod rtt;
