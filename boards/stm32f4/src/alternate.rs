//! Pins wired for a peripheral.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, AnyPin, Flex, OutputType, Pin, Pull, Speed};

use crate::registers;

/// Mode of a pin in MODER: alternate function.
const ALTERNATE: u32 = 2;

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

    /// Connects the pin again if a bit of its settings has flipped.
    #[inline(never)] // once for all pins
    pub fn mend(&mut self, direction: Direction) {
        let (block, number) = (self.1.block(), usize::from(self.1.pin()));
        let of_pair = |register: u32| register >> (2 * number) & 3;
        let found = [
            of_pair(block.moder().read().0),
            of_pair(block.pupdr().read().0),
            of_pair(block.ospeedr().read().0),
            block.otyper().read().0 >> number & 1,
            u32::from(block.afr(number / 8).read().afr(number % 8)),
        ];
        let [pull, speed] = match direction {
            Direction::Input => [1, 0],
            Direction::Output => [0, 3],
        };
        if found != [ALTERNATE, pull, speed, 0, self.0.into()] {
            registers::count(block.as_ptr() as u32);
            self.connect(direction);
        }
    }
}
