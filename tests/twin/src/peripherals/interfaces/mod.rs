//! The serial interfaces.

mod i2c;
#[cfg(test)]
mod tests;

use super::Clocks;
pub use i2c::I2c;

/// NVIC inputs of I2C1 to I2C3: event, error (RM0090 table 61).
const I2C_IRQS: [[u16; 2]; 3] = [[31, 32], [33, 34], [72, 73]];

/// All of them.
#[derive(Debug, Default)]
pub struct Interfaces {
    /// I2C1 to I2C3.
    pub i2c: [I2c; 3],
}

impl Interfaces {
    /// A reset of the whole part.
    pub fn reset(&mut self) {
        self.i2c.iter_mut().for_each(I2c::reset);
    }

    /// Power comes up, for the devices as well.
    pub fn power_on(&mut self) {
        self.i2c.iter_mut().for_each(I2c::power_on);
    }

    /// The clock tree has changed at `cycle`.
    pub fn set_clocks(&mut self, cycle: u64, clocks: Clocks) {
        let pclk1 = clocks.hclk / clocks.apb1_divider;
        for i2c in &mut self.i2c {
            i2c.catch_up(cycle);
            i2c.set_clock(clocks.apb1_divider, pclk1);
        }
    }

    /// Does what happened until `cycle`; sets the lines of the NVIC.
    pub fn irqs(&mut self, cycle: u64, mut set: impl FnMut(u16, bool)) {
        for (i2c, irqs) in self.i2c.iter_mut().zip(I2C_IRQS).filter(|(i2c, _)| i2c.is_enabled()) {
            i2c.catch_up(cycle);
            for (irq, level) in irqs.into_iter().zip(i2c.irqs()) {
                set(irq, level);
            }
        }
    }

    /// The cycle at which something next changes.
    pub fn next_event(&self) -> Option<u64> {
        self.i2c.iter().filter_map(I2c::next_event).min()
    }
}
