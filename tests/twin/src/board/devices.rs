//! What is soldered to a board beside the chip, and the memory that DMA reaches.

use std::ops::Range;

use super::EmulatedBoard;
use crate::cpu::Cpu;
use crate::devices::I2cDevice;
use crate::model::FLASH_BASE;
use crate::peripherals::Ram;

/// The SRAM that DMA reaches; CCM hangs on the core's data bus alone.
const SRAM: Range<u32> = 0x2000_0000..0x2002_0000;

/// Where CCM begins, above flash.
const CCM: u32 = 0x1000_0000;

/// The memory ports of the DMA controllers.
pub(super) struct DmaMemory<'a>(pub &'a mut dyn Cpu);

impl Ram for DmaMemory<'_> {
    fn load(&self, address: u32, bytes: &mut [u8]) -> bool {
        let reaches = SRAM.contains(&address) || (FLASH_BASE..CCM).contains(&address);
        reaches && self.0.read_memory(address, bytes).is_ok()
    }

    fn store(&mut self, address: u32, bytes: &[u8]) -> bool {
        SRAM.contains(&address) && self.0.write_memory(address, bytes).is_ok()
    }
}

/// Place of I2C1 to I2C3 among the interfaces.
fn i2c(bus: u8) -> usize {
    assert!((1..=3).contains(&bus), "the part has I2C1 to I2C3, not I2C{bus}");
    usize::from(bus) - 1
}

impl EmulatedBoard {
    /// The chip and the sensor of [`Fittings::thermometer`](super::Fittings::thermometer) get warmer or colder: °C.
    pub fn set_temperature(&mut self, celsius: f64) {
        self.link.peripherals().set_temperature(celsius);
        if let Some(thermometer) = &self.thermometer {
            thermometer.set_temperature(celsius);
        }
    }

    /// Wires a device with its pull-ups to I2C`bus`, 1 to 3.
    ///
    /// # Panics
    /// When there is no such bus: a mistake in a test, not an input.
    pub fn attach_i2c(&mut self, bus: u8, device: impl I2cDevice + 'static) {
        self.link.peripherals().attach_i2c(i2c(bus), Box::new(device));
        self.refresh();
    }

    /// Unplugs all devices from I2C`bus`, 1 to 3, and with them the pull-ups of both lines.
    ///
    /// # Panics
    /// When there is no such bus: a mistake in a test, not an input.
    pub fn detach_i2c(&mut self, bus: u8) {
        self.link.peripherals().detach_i2c(i2c(bus));
        self.refresh();
    }
}
