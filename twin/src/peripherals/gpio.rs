//! GPIO ports A to K: modes, pulls, outputs with the times of their changes, alternate functions.
//!
//! RM0090 chapter 8. A pin reads the level of its driver: its own output, a timer, the harness, otherwise its pull. A
//! pin without any of these reads low. Open-drain, speed and the configuration lock are stored without effect.

use crate::pin::Pin;
use crate::wire::time::Time;

const MODER: u32 = 0x00;
const PUPDR: u32 = 0x0C;
const IDR: u32 = 0x10;
const ODR: u32 = 0x14;
const BSRR: u32 = 0x18;
const AFRL: u32 = 0x20;
const AFRH: u32 = 0x24;

const INPUT: u32 = 0;
const OUTPUT: u32 = 1;
const ALTERNATE: u32 = 2;

/// The alternate function of TIM3, TIM4 and TIM5.
pub(super) const TIMER_AF: u32 = 2;

/// An output pin changed its level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinChange {
    /// Instant of the change.
    pub at: Time,
    /// Pin that changed.
    pub pin: Pin,
    /// Level after the change.
    pub high: bool,
}

/// One port.
#[derive(Clone, Debug)]
pub struct Gpio {
    port: usize,
    /// MODER, OTYPER, OSPEEDR, PUPDR, -, ODR, -, LCKR, AFRL, AFRH.
    pub(super) words: [u32; 10],
    /// Pins that the harness drives, and their levels.
    driven: u32,
    levels: u32,
    /// Pins for which a timer has an output, and its levels.
    timed: u32,
    timed_levels: u32,
}

impl Gpio {
    /// After a reset; `port` 0 is A. JTAG pins start with their alternate function and pulls (RM0090 8.4).
    pub fn new(port: usize) -> Self {
        let (moder, ospeedr, pupdr) = match port {
            0 => (0xA800_0000, 0, 0x6400_0000),
            1 => (0x0000_0280, 0x0000_00C0, 0x0000_0100),
            _ => (0, 0, 0),
        };
        let mut words = [0; 10];
        words[0] = moder;
        words[2] = ospeedr;
        words[3] = pupdr;
        Gpio { port, words, driven: 0, levels: 0, timed: 0, timed_levels: 0 }
    }

    /// Resets the port, by RCC or a system reset. Levels driven by harness and timers remain.
    pub fn reset(&mut self) {
        let Gpio { port, driven, levels, timed, timed_levels, .. } = *self;
        *self = Gpio { driven, levels, timed, timed_levels, ..Gpio::new(port) };
    }

    fn word(&self, offset: u32) -> u32 {
        self.words[offset as usize / 4]
    }

    fn mode(&self, n: u32) -> u32 {
        self.word(MODER) >> (2 * n) & 0b11
    }

    /// The alternate function that pin `n` carries.
    pub fn alternate_function(&self, n: u32) -> Option<u32> {
        let afr = if n < 8 { self.word(AFRL) } else { self.word(AFRH) };
        (self.mode(n) == ALTERNATE).then_some(afr >> (4 * (n % 8)) & 0xF)
    }

    /// Returns whether the chip pulls pin `n` up.
    pub fn is_pulled_up(&self, n: u32) -> bool {
        self.word(PUPDR) >> (2 * n) & 0b11 == 1
    }

    /// Drives pin `n` by the harness, or releases it.
    pub fn drive(&mut self, n: u32, level: Option<bool>) {
        self.driven = self.driven & !(1 << n) | u32::from(level.is_some()) << n;
        self.levels = self.levels & !(1 << n) | u32::from(level == Some(true)) << n;
    }

    /// Returns the level to which the harness drives pin `n`.
    pub fn driven_level(&self, n: u32) -> Option<bool> {
        (self.driven >> n & 1 == 1).then_some(self.levels >> n & 1 == 1)
    }

    /// Sets the timer's level for pin `n`, which applies as soon as the pin has that function; `None`: none. Returns
    /// whether the pin's output changes now.
    pub fn drive_by_timer(&mut self, n: u32, level: Option<bool>) -> bool {
        let before = self.outputs();
        self.timed = self.timed & !(1 << n) | u32::from(level.is_some()) << n;
        self.timed_levels = self.timed_levels & !(1 << n) | u32::from(level == Some(true)) << n;
        self.outputs() != before
    }

    fn is_timed(&self, n: u32) -> bool {
        self.timed >> n & 1 == 1 && self.alternate_function(n) == Some(TIMER_AF)
    }

    /// Levels of the pins, as IDR shows them.
    pub fn idr(&self) -> u32 {
        (0..16).fold(0, |idr, n| {
            let high = match self.mode(n) {
                OUTPUT => self.word(ODR) >> n & 1 == 1,
                ALTERNATE if self.is_timed(n) => self.timed_levels >> n & 1 == 1,
                INPUT | ALTERNATE if self.driven >> n & 1 == 1 => self.levels >> n & 1 == 1,
                INPUT | ALTERNATE => self.is_pulled_up(n),
                // Analog: the Schmitt trigger is off and reads low.
                _ => false,
            };
            idr | u32::from(high) << n
        })
    }

    /// Outputs that drive high, those of timers included; pins in other modes are 0.
    pub(super) fn outputs(&self) -> u32 {
        (0..16).fold(0, |out, n| match self.mode(n) {
            OUTPUT => out | self.word(ODR) & 1 << n,
            ALTERNATE if self.is_timed(n) => out | self.timed_levels & 1 << n,
            _ => out,
        })
    }

    /// A load; `None` for what does not exist.
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            IDR => Some(self.idr()),
            BSRR => Some(0),
            MODER..=AFRH => Some(self.word(offset)),
            _ => None,
        }
    }

    /// Stores at `at`; adds changes of outputs to `changes`. `None` for what does not exist.
    pub fn write(&mut self, at: Time, offset: u32, value: u32, changes: &mut Vec<PinChange>) -> Option<()> {
        let before = self.outputs();
        match offset {
            IDR => {}
            BSRR => {
                let odr = &mut self.words[ODR as usize / 4];
                // A pin both set and reset is set (RM0090 8.4.7).
                *odr = (*odr & !(value >> 16) | value) & 0xFFFF;
            }
            MODER..=AFRH => self.words[offset as usize / 4] = value,
            _ => return None,
        }
        let after = self.outputs();
        let port = (b'A' + self.port as u8) as char;
        changes.extend((0..16).filter(|n| (before ^ after) >> n & 1 == 1).map(|n| PinChange {
            at,
            pin: Pin::new(port, n),
            high: after >> n & 1 == 1,
        }));
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strap_wins_over_the_pull_and_the_pull_over_nothing() {
        let mut gpio = Gpio::new(2);
        assert_eq!(gpio.idr() & 1, 0);
        gpio.write(Time::ZERO, PUPDR, 0b01, &mut Vec::new()).unwrap();
        assert_eq!(gpio.idr() & 1, 1);
        gpio.drive(0, Some(false));
        assert_eq!(gpio.idr() & 1, 0);
        gpio.drive(0, None);
        assert_eq!(gpio.idr() & 1, 1);
    }

    #[test]
    fn output_changes_are_told_with_their_time() {
        let mut gpio = Gpio::new(1);
        let mut changes = Vec::new();
        gpio.write(Time(1), BSRR, 1 << 4, &mut changes).unwrap();
        assert!(changes.is_empty(), "the pin is no output yet");
        gpio.write(Time(2), MODER, OUTPUT << 8, &mut changes).unwrap();
        gpio.write(Time(3), BSRR, 1 << 20, &mut changes).unwrap();
        let pin = Pin::new('B', 4);
        assert_eq!(
            changes,
            [PinChange { at: Time(2), pin, high: true }, PinChange { at: Time(3), pin, high: false }]
        );
    }

    #[test]
    fn names_of_pins_are_read_and_others_are_not() {
        assert_eq!(Pin::named("PA0"), Some(Pin::new('A', 0)));
        assert_eq!(Pin::named("PK15"), Some(Pin::new('K', 15)));
        for other in ["", "P", "PA", "A0", "pa0", "PL0", "PA16", "PA00", "PA+1", "PA1 ", "PÄ1"] {
            assert_eq!(Pin::named(other), None, "{other}");
        }
    }

    #[test]
    fn an_alternate_function_counts_only_in_its_mode() {
        let mut gpio = Gpio::new(1);
        gpio.write(Time::ZERO, AFRH, 0x99, &mut Vec::new()).unwrap();
        assert_eq!(gpio.alternate_function(8), None);
        gpio.write(Time::ZERO, MODER, ALTERNATE << 16, &mut Vec::new()).unwrap();
        assert_eq!(gpio.alternate_function(8), Some(9));
    }
}
