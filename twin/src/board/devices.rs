//! Devices outside of the chip.

use super::EmulatedBoard;
use crate::devices::I2cDevice;

/// Returns the index, from 0, of I2C`bus`, which is numbered from 1.
fn place(bus: u8) -> usize {
    assert!((1..=3).contains(&bus), "the part has I2C1 to I2C3, not I2C{bus}");
    usize::from(bus) - 1
}

impl EmulatedBoard {
    /// Sets the temperature of the devices on the I2C buses, in °C.
    pub fn set_temperature(&mut self, celsius: f64) {
        self.chip.peripherals.i2c.set_temperature(celsius);
    }

    /// Wires a device with its pull-ups to I2C`bus`, 1 to 3.
    ///
    /// # Panics
    /// When there is no such bus: a mistake in a test, not an input.
    pub fn attach_i2c(&mut self, bus: u8, device: impl I2cDevice + 'static) {
        let cycle = self.chip.clock.now().cycle;
        self.chip.peripherals.attach_i2c(cycle, place(bus), Box::new(device));
        self.refresh();
    }

    /// Unplugs all devices from I2C`bus`, 1 to 3, and with them the pull-ups of both lines.
    ///
    /// # Panics
    /// When there is no such bus: a mistake in a test, not an input.
    pub fn detach_i2c(&mut self, bus: u8) {
        self.chip.peripherals.i2c.0[place(bus)].detach_all();
        self.refresh();
    }
}
