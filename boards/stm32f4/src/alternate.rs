//! Pins wired for a peripheral.

#[cfg(feature = "full")]
mod mend;

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, AnyPin, Flex, OutputType, Pin, Pull, Speed};

/// A pin and the number of the alternate function that it is wired for.
pub(crate) struct AlternatePin(pub u8, pub Peri<'static, AnyPin>);

/// Direction of a pin, as its peripheral sees it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Direction {
    /// With a pull-up, which keeps an input without wire recessive and free of edges.
    Input,
    /// Push-pull, with the steepest edges.
    Output,
}

impl AlternatePin {
    /// Returns a number that each flipped bit of pin or function changes.
    pub fn check(&self) -> u8 {
        self.0 ^ (self.1.port() << 4 | self.1.pin())
    }

    /// Connects the pin to its peripheral.
    pub fn connect(&mut self, direction: Direction) {
        let kind = match direction {
            Direction::Input => AfType::input(Pull::Up),
            Direction::Output => AfType::output(OutputType::PushPull, Speed::VeryHigh),
        };
        let mut pin = Flex::new(self.1.reborrow());
        pin.set_as_af_unchecked(self.0, kind);
        // Dropping it would disconnect the peripheral.
        core::mem::forget(pin);
    }
}
