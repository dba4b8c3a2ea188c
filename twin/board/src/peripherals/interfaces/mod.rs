//! The serial interfaces.

mod i2c;
mod spi;
#[cfg(test)]
mod tests;
mod usart;

use super::Clocks;
pub use i2c::I2c;
pub use spi::Spi;
pub use usart::{Sent, Usart};

/// NVIC inputs of I2C1 to I2C3 (event, error), USART1 to USART6, SPI1 to SPI3 (RM0090 table 61).
const I2C_IRQS: [[u16; 2]; 3] = [[31, 32], [33, 34], [72, 73]];
const USART_IRQS: [u16; 6] = [37, 38, 39, 52, 53, 71];
const SPI_IRQS: [u16; 3] = [35, 36, 51];
/// USART1, USART6 and SPI1 hang on APB2.
const USARTS_ON_APB2: [usize; 2] = [0, 5];
const SPI_ON_APB2: usize = 0;

/// All of them.
#[derive(Clone, Debug, Default)]
pub struct Interfaces {
    /// I2C1 to I2C3.
    pub i2c: [I2c; 3],
    /// USART1 to USART6.
    pub usart: [Usart; 6],
    /// SPI1 to SPI3.
    pub spi: [Spi; 3],
}

impl Interfaces {
    /// A reset of the whole part.
    pub fn reset(&mut self) {
        self.i2c.iter_mut().for_each(I2c::reset);
        self.usart.iter_mut().for_each(Usart::reset);
        self.spi.iter_mut().for_each(Spi::reset);
    }

    /// Power comes up, for the devices as well.
    pub fn power_on(&mut self) {
        self.i2c.iter_mut().for_each(I2c::power_on);
    }

    /// The temperature of the I2C devices from now on, °C.
    pub fn set_temperature(&mut self, celsius: f64) {
        self.i2c.iter_mut().for_each(|i2c| i2c.set_temperature(celsius));
    }

    /// The clock tree has changed at `cycle`.
    pub fn set_clocks(&mut self, cycle: u64, clocks: Clocks) {
        let Clocks { hclk, apb1_divider, apb2_divider, .. } = clocks;
        for i2c in &mut self.i2c {
            i2c.catch_up(cycle);
            i2c.set_clock(apb1_divider, hclk / apb1_divider);
        }
        for (n, usart) in self.usart.iter_mut().enumerate() {
            let divider = if USARTS_ON_APB2.contains(&n) { apb2_divider } else { apb1_divider };
            usart.catch_up(cycle);
            usart.set_clock(divider, hclk / divider);
        }
        for (n, spi) in self.spi.iter_mut().enumerate() {
            spi.catch_up(cycle);
            spi.set_clock(if n == SPI_ON_APB2 { apb2_divider } else { apb1_divider });
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
        for (usart, irq) in self.usart.iter_mut().zip(USART_IRQS).filter(|(usart, _)| usart.is_enabled()) {
            usart.catch_up(cycle);
            set(irq, usart.irq());
        }
        for (spi, irq) in self.spi.iter_mut().zip(SPI_IRQS).filter(|(spi, _)| spi.is_enabled()) {
            spi.catch_up(cycle);
            set(irq, spi.irq());
        }
    }

    /// The cycle at which something next changes.
    pub fn next_event(&self) -> Option<u64> {
        let i2c = self.i2c.iter().filter_map(I2c::next_event);
        let usart = self.usart.iter().filter_map(Usart::next_event);
        i2c.chain(usart).chain(self.spi.iter().filter_map(Spi::next_event)).min()
    }

    /// Words that left on TX since the last call.
    pub fn take_sent(&mut self) -> Vec<Sent> {
        if self.usart.iter().all(|usart| !usart.has_sent()) {
            return Vec::new();
        }
        let of = |(usart, words): (usize, &mut Usart)| {
            words.take_sent().into_iter().map(move |(cycle, data, bit)| Sent {
                cycle,
                usart,
                data: data as u16,
                bit,
            })
        };
        self.usart.iter_mut().enumerate().flat_map(of).collect()
    }
}
