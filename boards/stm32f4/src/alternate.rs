//! Pins wired for a peripheral.

use embassy_stm32::Peri;
use embassy_stm32::gpio::AnyPin;

/// A pin and the number of the alternate function that it is wired for.
pub(crate) struct AlternatePin(pub u8, pub Peri<'static, AnyPin>);
