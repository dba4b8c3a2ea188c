//! Settings of a pin that are compared with what they have to be.

use embassy_stm32::gpio::Pin;

use super::{AlternatePin, Direction};
use crate::registers;

/// Settings of a pin in MODER, PUPDR and OSPEEDR. In OTYPER push-pull is zero.
const ALTERNATE: u32 = 0b10;
const PULL_UP: u32 = 0b01;
const VERY_HIGH_SPEED: u32 = 0b11;

impl AlternatePin {
    /// Connects the pin again if a bit of its settings has flipped.
    pub fn mend(&mut self, direction: Direction) {
        let (block, number) = (self.1.block(), usize::from(self.1.pin()));
        let (pull, speed) = match direction {
            Direction::Input => (PULL_UP, 0),
            Direction::Output => (0, VERY_HIGH_SPEED),
        };
        let pairs = |register: u32| register >> (2 * number);
        let settings = pairs(block.moder().read().0) ^ ALTERNATE
            | pairs(block.pupdr().read().0) ^ pull
            | pairs(block.ospeedr().read().0) ^ speed;
        let output = block.otyper().read().0 >> number;
        let function = block.afr(number / 8).read().0 >> (4 * (number % 8)) ^ u32::from(self.0);
        if settings & 0b11 | output & 1 | function & 0xF != 0 {
            registers::count(block.as_ptr() as u32);
            self.connect(direction);
        }
    }
}
