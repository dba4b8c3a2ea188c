//! Devices beside the chip.

use can_wire::time::Time;

use super::EmulatedBoard;
use crate::devices::{I2cDevice, SpiDevice};
use crate::peripherals::Sent;
use crate::pin::Pin;

/// A word that left a board on TX of a serial port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialWord {
    /// When its last stop bit ended.
    pub at: Time,
    /// USART1 to USART6: 1 to 6.
    pub usart: u8,
    /// Its data bits.
    pub data: u16,
    /// Bits per second, by the nominal clock.
    pub baud: u32,
}

/// Place of an interface among those of its kind, which are numbered from 1 on.
fn place(kind: &str, number: u8, most: u8) -> usize {
    assert!((1..=most).contains(&number), "the part has {kind}1 to {kind}{most}, not {kind}{number}");
    usize::from(number) - 1
}

impl EmulatedBoard {
    /// The chip and the devices on its I2C buses get warmer or colder: °C.
    pub fn set_temperature(&mut self, celsius: f64) {
        self.chip.peripherals.set_temperature(celsius);
    }

    /// Wires a device with its pull-ups to I2C`bus`, 1 to 3.
    ///
    /// # Panics
    /// When there is no such bus: a mistake in a test, not an input.
    pub fn attach_i2c(&mut self, bus: u8, device: impl I2cDevice + 'static) {
        let cycle = self.chip.clock.now().cycle;
        self.chip.peripherals.attach_i2c(cycle, place("I2C", bus, 3), Box::new(device));
        self.refresh();
    }

    /// Unplugs all devices from I2C`bus`, 1 to 3, and with them the pull-ups of both lines.
    ///
    /// # Panics
    /// When there is no such bus: a mistake in a test, not an input.
    pub fn detach_i2c(&mut self, bus: u8) {
        self.chip.peripherals.detach_i2c(place("I2C", bus, 3));
        self.refresh();
    }

    /// Wires a device to SPI`bus`, 1 to 3; `select` is its chip select, active low.
    ///
    /// # Panics
    /// When there is no such bus: a mistake in a test, not an input.
    pub fn attach_spi(&mut self, bus: u8, device: impl SpiDevice + 'static, select: Option<Pin>) {
        let (cycle, bus) = (self.chip.clock.now().cycle, place("SPI", bus, 3));
        self.chip.peripherals.attach_spi(cycle, bus, Box::new(device), select);
        self.refresh();
    }

    /// Sends `bytes` to RX of USART`usart`, 1 to 6, one after the other at `baud`; they wait until the receiver is on.
    ///
    /// # Panics
    /// When there is no such interface: a mistake in a test, not an input.
    pub fn put_serial(&mut self, usart: u8, baud: u32, bytes: &[u8]) {
        let (cycle, usart) = (self.chip.clock.now().cycle, place("USART", usart, 6));
        self.chip.peripherals.put_serial(cycle, usart, baud, bytes);
        self.refresh();
    }

    /// Words that left the board on TX of its serial ports since the last call.
    pub fn take_serial(&mut self) -> Vec<SerialWord> {
        std::mem::take(&mut self.serial)
    }

    /// Keeps what left on TX.
    pub(super) fn keep_serial(&mut self, sent: Vec<Sent>, hclk: u64) {
        self.serial.extend(sent.into_iter().map(|Sent { cycle, usart, data, bit }| SerialWord {
            at: self.chip.clock.time_at(cycle),
            usart: usart as u8 + 1,
            data,
            baud: (hclk / bit) as u32,
        }));
    }
}
