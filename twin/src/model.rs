//! Boards: part, oscillator and pins. [`Description`](crate::description::Description) reads them from a file.

use crate::bxcan::Side;
pub use crate::part::Part;
use crate::pin::Pin;

/// First address of the main flash memory, which is mapped at zero as well.
pub const FLASH_BASE: u32 = 0x0800_0000;

/// Each byte of RAM after power-on. Not zero, so that a program that relies on zeros does not work by chance.
pub const RAM_AT_POWER_ON: u8 = 0xA5;

/// LEDs that a description may name.
pub const MOST_LEDS: usize = 8;

/// Oscillator or external clock at OSC_IN.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Oscillator {
    /// Nominal frequency.
    pub hz: u64,
    /// True for an external clock, for which the program must bypass the oscillator of the part; false for a crystal.
    pub external: bool,
}

/// A board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Model {
    /// The microcontroller.
    pub part: Part,
    /// Its high-speed oscillator.
    pub oscillator: Oscillator,
    /// Connections of its pins.
    pub pins: Pins,
}

/// Pins of a board, by their use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Pins {
    /// Pins of CAN1 and CAN2 at their transceivers.
    pub can: [CanPins; 2],
    /// Capture inputs to which CAN_RX of CAN1 and CAN2 are wired: two of PA0 to PA3, TIM5_CH1 to TIM5_CH4. `None`: no
    /// wires.
    pub capture: Option<[Pin; 2]>,
    /// Pulse output: a channel of TIM3.
    pub pulse: Option<Pin>,
    /// Straps of the harness.
    pub straps: Option<Straps>,
    /// LEDs, by the names that the description gives them.
    pub leds: [Option<Pin>; MOST_LEDS],
    /// Pin that selects the transceiver on a board with two of them on one controller.
    pub transceiver_switch: Option<Pin>,
}

impl Pins {
    /// Each pin that the board uses.
    pub fn all(&self) -> impl Iterator<Item = Pin> {
        let straps = self
            .straps
            .into_iter()
            .flat_map(|straps| straps.bits.into_iter().chain([straps.parity]).chain(straps.maintenance));
        let single = [self.pulse, self.transceiver_switch].into_iter().chain(self.leds);
        let buses = self.can.into_iter().flat_map(|CanPins { rx, tx }| [rx, tx]);
        buses.chain(self.capture.into_iter().flatten()).chain(straps).chain(single.flatten())
    }

    /// Pins of a controller.
    pub const fn can(&self, side: Side) -> CanPins {
        self.can[side as usize]
    }
}

/// Pins of a CAN controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CanPins {
    /// CAN_RX.
    pub rx: Pin,
    /// CAN_TX.
    pub tx: Pin,
}

/// Straps: tied to ground they are 1, open they are 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Straps {
    /// Bits 0 to 3 of the number of the board.
    pub bits: [Pin; 4],
    /// Odd parity over all five.
    pub parity: Pin,
    /// Maintenance mode.
    pub maintenance: Option<Pin>,
}

impl Straps {
    /// Returns the pins that the harness ties to ground for a number, `0..=15`: its bits from the lowest, then odd
    /// parity.
    pub fn closed(&self, number: u8) -> Vec<(Pin, bool)> {
        let bits =
            self.bits.into_iter().enumerate().filter(|(bit, _)| number >> bit & 1 == 1).map(|(_, pin)| pin);
        let parity = number.count_ones().is_multiple_of(2).then_some(self.parity);
        bits.chain(parity).map(|pin| (pin, false)).collect()
    }
}
