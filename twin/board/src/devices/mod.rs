//! Devices on the boards' I2C buses.

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
