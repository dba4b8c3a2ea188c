//! Devices on the boards' serial buses.

mod lm75;

use std::fmt;

use dyn_clone::DynClone;
pub use lm75::Lm75;

/// A slave on an I2C bus, with pull-ups on both of its lines. A copy of its board has a copy of it: its state must not be shared.
pub trait I2cDevice: fmt::Debug + Send + DynClone {
    /// A START or repeated START, then `address` (7 bits) and direction. Returns whether the device acknowledges.
    fn start(&mut self, address: u8, read: bool) -> bool;

    /// A byte for the device. Returns whether it acknowledges.
    fn write(&mut self, byte: u8) -> bool;

    /// The byte that the device sends next.
    fn read(&mut self) -> u8;

    /// A STOP, or the bus is released.
    fn stop(&mut self) {}

    /// Power comes up with that of the board.
    fn power_on(&mut self) {}

    /// The board gets warmer or colder: °C.
    fn set_temperature(&mut self, _celsius: f64) {}
}

dyn_clone::clone_trait_object!(I2cDevice);

/// CPOL and CPHA of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpiMode {
    /// SCK idles high (CPOL).
    pub idles_high: bool,
    /// Data are sampled on the second edge (CPHA).
    pub second_edge: bool,
}

/// A slave on an SPI bus. A copy of its board has a copy of it: its state must not be shared.
pub trait SpiDevice: fmt::Debug + Send + DynClone {
    /// Its chip select becomes active, or inactive.
    fn select(&mut self, _selected: bool) {}

    /// A word of 8 or 16 bits, the first bit on the line in the highest place; returns the word on MISO.
    fn transfer(&mut self, mode: SpiMode, bits: u32, word: u16) -> u16;
}

dyn_clone::clone_trait_object!(SpiDevice);

/// A wire from MOSI to MISO.
#[derive(Clone, Copy, Debug, Default)]
pub struct Loopback;

impl SpiDevice for Loopback {
    fn transfer(&mut self, _mode: SpiMode, _bits: u32, word: u16) -> u16 {
        word
    }
}
