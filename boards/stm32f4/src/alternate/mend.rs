//! Settings of a pin that are compared with what they have to be.

use embassy_stm32::gpio::Pin;

use super::{AlternatePin, Direction};
use crate::registers;

/// Settings of a pin, side by side: MODER, PUPDR, OSPEEDR; then OTYPER, push-pull.
const ALTERNATE: u32 = 0b10;
const PULL_UP: u32 = 0b01 << 2;
const VERY_HIGH_SPEED: u32 = 0b11 << 4;

impl AlternatePin {
    /// Connects the pin again if a bit of its settings has flipped.
    pub fn mend(&mut self, direction: Direction) {
        let (block, number) = (self.1.block(), usize::from(self.1.pin()));
        let of_pair = |register: u32| register >> (2 * number) & 0b11;
        let found = of_pair(block.moder().read().0)
            | of_pair(block.pupdr().read().0) << 2
            | of_pair(block.ospeedr().read().0) << 4
            | (block.otyper().read().0 >> number & 1) << 6;
        let wanted = match direction {
            Direction::Input => ALTERNATE | PULL_UP,
            Direction::Output => ALTERNATE | VERY_HIGH_SPEED,
        };
        let function = block.afr(number / 8).read().0 >> (4 * (number % 8)) & 0xF;
        if found != wanted || function != self.0.into() {
            registers::count(block.as_ptr() as u32);
            self.connect(direction);
        }
    }
}
