//! Devices on the boards' I2C buses.

mod lm75;

use std::fmt;

use dyn_clone::DynClone;
pub use lm75::Lm75;

/// A slave on an I2C bus, with pull-ups on both of its lines. A copy of a board contains copies of its devices, so
/// their state must not be shared.
pub trait I2cDevice: fmt::Debug + Send + DynClone {
    /// Handles a START or repeated START with `address` (7 bits) and direction. Returns whether the device
    /// acknowledges.
    fn start(&mut self, address: u8, read: bool) -> bool;

    /// Receives a byte. Returns whether the device acknowledges.
    fn write(&mut self, byte: u8) -> bool;

    /// Returns the byte that the device sends next.
    fn read(&mut self) -> u8;

    /// Handles a STOP or the release of the bus.
    fn stop(&mut self) {}

    /// Handles power-on, together with the board.
    fn power_on(&mut self) {}

    /// Sets the temperature of the board, in °C.
    fn set_temperature(&mut self, _celsius: f64) {}
}

dyn_clone::clone_trait_object!(I2cDevice);
