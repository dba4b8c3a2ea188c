//! LM75B, a temperature sensor on I2C (NXP data sheet LM75B, rev. 6.1, section 7).
//!
//! Modelled: the pointer, the four registers with their power-on values, shutdown. A conversion takes no time: the
//! register has the present temperature unless the sensor is shut down. The output OS is not wired.

use super::I2cDevice;

/// Registers by pointer (table 5): Temp, Conf, Thyst, Tos.
const CONF: u8 = 1;
const THYST: u8 = 2;
const TOS: u8 = 3;

/// Bit 0 of Conf (table 7).
const SHUTDOWN: u8 = 1;
/// Bits of Conf that are kept; the others are reserved.
const CONF_BITS: u8 = 0x1F;
/// The limits have 9 bits (section 7.4.4).
const LIMIT_BITS: u16 = 0xFF80;
/// 75 °C and 80 °C.
const THYST_AT_POWER_ON: u16 = 0x4B00;
const TOS_AT_POWER_ON: u16 = 0x5000;

/// The sensor.
#[derive(Clone, Debug)]
pub struct Lm75 {
    address: u8,
    temperature_c: f64,
    temp: u16,
    conf: u8,
    thyst: u16,
    tos: u16,
    pointer: u8,
    /// Bytes since the last START.
    bytes: usize,
}

impl Lm75 {
    /// Address with A2 to A0 at ground (table 4). The pins add 0 to 7.
    pub const ADDRESS: u8 = 0x48;

    /// Makes a powered sensor at `address` with `temperature_c` °C.
    ///
    /// # Panics
    /// When no LM75 has this address: a mistake in a test, not an input.
    pub fn new(address: u8, temperature_c: f64) -> Self {
        assert!(
            (0x48..=0x4F).contains(&address),
            "an LM75 has one of the addresses 48h to 4Fh, not {address:02X}h"
        );
        let (thyst, tos) = (THYST_AT_POWER_ON, TOS_AT_POWER_ON);
        let mut sensor = Lm75 { address, temperature_c, temp: 0, conf: 0, thyst, tos, pointer: 0, bytes: 0 };
        sensor.convert();
        sensor
    }

    /// Updates Temp: eleven bits, two's complement, 0.125 °C each, in the upper bits (section 7.4.3).
    fn convert(&mut self) {
        if self.conf & SHUTDOWN == 0 {
            let steps = (self.temperature_c.clamp(-55.0, 125.0) * 8.0).round() as i16;
            self.temp = (steps << 5) as u16;
        }
    }

    fn register(&self) -> [u8; 2] {
        match self.pointer {
            CONF => [self.conf; 2],
            THYST => self.thyst.to_be_bytes(),
            TOS => self.tos.to_be_bytes(),
            _ => self.temp.to_be_bytes(),
        }
    }
}

impl I2cDevice for Lm75 {
    fn start(&mut self, address: u8, _read: bool) -> bool {
        self.bytes = 0;
        address == self.address
    }

    fn write(&mut self, byte: u8) -> bool {
        let high = |limit: u16| limit & 0x00FF | u16::from(byte) << 8;
        let low = |limit: u16| (limit & 0xFF00 | u16::from(byte)) & LIMIT_BITS;
        match (self.bytes, self.pointer) {
            (0, _) => self.pointer = byte & 0b11,
            (1, CONF) => {
                self.conf = byte & CONF_BITS;
                self.convert();
            }
            (1, THYST) => self.thyst = high(self.thyst),
            (2, THYST) => self.thyst = low(self.thyst),
            (1, TOS) => self.tos = high(self.tos),
            (2, TOS) => self.tos = low(self.tos),
            // Temp is read-only.
            _ => {}
        }
        self.bytes += 1;
        true
    }

    fn read(&mut self) -> u8 {
        let byte = self.register()[self.bytes % 2];
        self.bytes += 1;
        byte
    }

    fn power_on(&mut self) {
        *self = Lm75::new(self.address, self.temperature_c);
    }

    fn set_temperature(&mut self, celsius: f64) {
        self.temperature_c = celsius;
        self.convert();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(sensor: &mut Lm75, pointer: u8) -> [u8; 2] {
        assert!(sensor.start(0x48, false) && sensor.write(pointer));
        assert!(sensor.start(0x48, true));
        [sensor.read(), sensor.read()]
    }

    /// Table 10 of the data sheet.
    #[test]
    fn temperatures_read_as_in_the_data_sheet() {
        for (celsius, register) in [
            (127.0, 0x7D00),
            (125.0, 0x7D00),
            (25.0, 0x1900),
            (0.125, 0x0020),
            (0.0, 0x0000),
            (-0.125, 0xFFE0),
            (-25.0, 0xE700),
            (-54.875, 0xC920),
            (-55.0, 0xC900),
        ] {
            let mut sensor = Lm75::new(0x48, celsius);
            assert_eq!(u16::from_be_bytes(read(&mut sensor, 0)), register, "{celsius} °C");
        }
    }

    #[test]
    fn registers_begin_as_in_the_data_sheet() {
        let mut sensor = Lm75::new(0x48, 20.0);
        assert_eq!([1, 2, 3].map(|pointer| read(&mut sensor, pointer)), [[0, 0], [0x4B, 0], [0x50, 0]]);
    }

    #[test]
    fn limits_keep_nine_bits_and_the_temperature_is_read_only() {
        let mut sensor = Lm75::new(0x48, 20.0);
        for pointer in [0, 2, 3] {
            assert!(sensor.start(0x48, false));
            for byte in [pointer, 0x12, 0xFF] {
                assert!(sensor.write(byte));
            }
        }
        assert_eq!(
            [0, 2, 3].map(|pointer| read(&mut sensor, pointer)),
            [[0x14, 0], [0x12, 0x80], [0x12, 0x80]]
        );
    }

    #[test]
    fn a_sensor_that_is_shut_down_keeps_its_last_temperature() {
        let mut sensor = Lm75::new(0x48, 20.0);
        assert!(sensor.start(0x48, false) && sensor.write(1) && sensor.write(1));
        sensor.set_temperature(30.0);
        assert_eq!(read(&mut sensor, 0), [0x14, 0]);
        assert!(sensor.start(0x48, false) && sensor.write(1) && sensor.write(0));
        assert_eq!(read(&mut sensor, 0), [0x1E, 0]);
    }

    #[test]
    fn another_address_is_not_acknowledged() {
        let mut sensor = Lm75::new(0x49, 20.0);
        assert!(!sensor.start(0x48, true));
        assert!(sensor.start(0x49, true));
    }
}
