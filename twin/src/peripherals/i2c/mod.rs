//! I2C1 to I2C3 and the devices on their buses.

mod bus;
#[cfg(test)]
mod tests;

pub use bus::I2c;

use super::Clocks;
use crate::devices::I2cDevice;

/// NVIC inputs of I2C1 to I2C3, event and error (RM0090 table 61).
const IRQS: [[u16; 2]; 3] = [[31, 32], [33, 34], [72, 73]];

/// I2C1 to I2C3.
#[derive(Clone, Debug, Default)]
pub struct Buses(pub [I2c; 3]);

impl Buses {
    /// Resets all three with the whole part.
    pub fn reset(&mut self) {
        self.0.iter_mut().for_each(I2c::reset);
    }

    fn devices(&mut self) -> impl Iterator<Item = &mut Box<dyn I2cDevice>> {
        self.0.iter_mut().flat_map(|i2c| &mut i2c.devices)
    }

    /// Handles power-on, also of the devices.
    pub fn power_on(&mut self) {
        self.devices().for_each(|device| device.power_on());
    }

    /// Sets the temperature of the devices, in °C.
    pub fn set_temperature(&mut self, celsius: f64) {
        self.devices().for_each(|device| device.set_temperature(celsius));
    }

    /// Handles a change of the clock tree at `cycle`.
    pub fn set_clocks(&mut self, cycle: u64, clocks: Clocks) {
        let Clocks { hclk, apb1_divider, .. } = clocks;
        for i2c in &mut self.0 {
            i2c.catch_up(cycle);
            (i2c.divider, i2c.pclk) = (apb1_divider, hclk / apb1_divider);
        }
    }

    /// Simulates the buses until `cycle` and sets the lines of the NVIC.
    pub fn irqs(&mut self, cycle: u64, mut set: impl FnMut(u16, bool)) {
        for (i2c, irqs) in self.0.iter_mut().zip(IRQS).filter(|(i2c, _)| i2c.is_enabled()) {
            i2c.catch_up(cycle);
            for (irq, level) in irqs.into_iter().zip(i2c.irqs()) {
                set(irq, level);
            }
        }
    }

    /// Returns the cycle of the next change.
    pub fn next_event(&self) -> Option<u64> {
        self.0.iter().filter_map(I2c::next_event).min()
    }
}
