//! Bit timing of a controller, as its register has it.
//!
//! A copy shows a flipped bit. Then the register of the controller has the right value.

use ecss_can::link::bit_timing::BitTiming;
use ecss_can::types::Duration;

/// Fields of CAN_BTR (RM0090 32.9.2): first bits.
const TS1: u32 = 16;
const TS2: u32 = 20;
const SJW: u32 = 24;
/// Bits of all fields of the bit timing.
const FIELDS: u32 = 0x037F_03FF;
/// SILM: drives no dominant bit.
const LISTENS: u32 = 1 << 31;

/// Bit times after which mailboxes are empty: twice a frame with the error frame after it.
const EMPTYING_BITS: u32 = 400;
/// Least value of that time, for high bit rates, in microseconds.
const EMPTYING: u16 = 5_000;

/// Bit timing of a bxCAN controller, from [`bit_timing`](crate::bit_timing). Its settings can be changed in Init mode only.
#[derive(Clone, Copy, Debug)]
pub struct ControllerTiming {
    value: u32,
    complement: u32,
    /// Length of a bit in clocks of the controller.
    clocks: u16,
    /// Time that mailboxes may take to become empty, in microseconds.
    emptying: u16,
}

impl ControllerTiming {
    /// Takes a bit timing.
    pub const fn new(timing: &BitTiming) -> ControllerTiming {
        let prescaler = timing.prescaler() as u32 - 1;
        let segment1 = (timing.segment1() as u32 - 1) << TS1;
        let segment2 = (timing.segment2() as u32 - 1) << TS2;
        let jump_width = (timing.jump_width() as u32 - 1) << SJW;
        let value = prescaler | segment1 | segment2 | jump_width;
        let emptying = timing.bit_rate().span(EMPTYING_BITS).as_micros() as u16;
        let emptying = if emptying > EMPTYING { emptying } else { EMPTYING };
        let clocks = timing.prescaler() * timing.quanta() as u16;
        ControllerTiming { value, complement: !value, clocks, emptying }
    }

    /// Returns the value of CAN_BTR. `listens`: the controller drives no dominant bit.
    pub fn register(&self, listens: bool) -> u32 {
        if listens { self.value | LISTENS } else { self.value }
    }

    /// Returns whether a value of CAN_BTR is that of a controller that only listens.
    pub fn listens(register: u32) -> bool {
        register & LISTENS != 0
    }

    /// Returns the length of a bit in clocks of the controller.
    pub fn clocks(&self) -> u32 {
        self.clocks.into()
    }

    /// Returns the time that mailboxes may take to become empty.
    pub const fn emptying(&self) -> Duration {
        Duration::from_micros(self.emptying as u64)
    }

    /// Takes the settings from CAN_BTR if a bit of them flipped.
    pub fn restore(&mut self, register: u32) {
        if self.value != !self.complement {
            self.value = register & FIELDS;
            self.complement = !self.value;
        }
    }
}

#[cfg(test)]
mod tests {
    use ecss_can::profile::Profile;

    use super::*;
    use crate::bit_timing;

    fn settings() -> ControllerTiming {
        bit_timing(&Profile::DEFAULT.network)
    }

    /// Given a controller at 42 MHz and 1 Mbit/s: prescaler 3, segments of 11 and 2 time quanta, jump width 1.
    #[test]
    fn settings_are_those_of_the_bit_timing() {
        assert_eq!(settings().register(false), 2 | 10 << 16 | 1 << 20);
        assert_eq!(settings().register(true), 2 | 10 << 16 | 1 << 20 | 1 << 31);
        assert!(
            ControllerTiming::listens(settings().register(true))
                && !ControllerTiming::listens(settings().register(false))
        );
        assert_eq!(settings().clocks(), 42);
    }

    /// Given settings, when any bit of them or of their copy flips, then they are taken from the controller.
    #[test]
    fn flipped_bit_of_settings_is_corrected_from_the_controller() {
        for (bit, listens) in (0..64).flat_map(|bit| [(bit, false), (bit, true)]) {
            let mut flipped = settings();
            let word = if bit < 32 { &mut flipped.value } else { &mut flipped.complement };
            *word ^= 1 << (bit % 32);
            flipped.restore(settings().register(listens));
            assert_eq!(flipped.register(listens), settings().register(listens), "bit {bit}");
            flipped.restore(0);
            assert_eq!(flipped.register(false), settings().register(false), "bit {bit}: the copy");
        }
    }

    /// Given settings without a flipped bit, then a wrong register changes nothing.
    #[test]
    fn wrong_register_does_not_change_settings() {
        let mut same = settings();
        same.restore(!0);
        assert_eq!(same.register(false), settings().register(false));
    }
}
