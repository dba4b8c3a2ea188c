//! A thermometer: its objects, its PDOs, the numbers of its mission, and its application, for a board and for tests on the host.

#![no_std]
#![forbid(unsafe_code)]

mod application;

pub use application::{Hardware, application};
use ecss_can::prelude::*;

/// Profile of the mission, the same in all its nodes.
pub const PROFILE: Profile = Profile { name: "thermometer", ..Profile::DEFAULT }.checked();

/// I2C address of the sensor, an LM75 with A2 to A0 at ground.
pub const LM75: u8 = 0x48;

/// Relation of the temperature to its limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[repr(u8)]
pub enum Alarm {
    /// Within the limits.
    #[default]
    Within = 0,
    /// Above the upper limit.
    Above = 1,
    /// Below the lower limit.
    Below = 2,
    /// The sensor does not answer.
    NoSensor = 3,
}

/// Origin of the temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(u8)]
pub enum Mode {
    /// As the sensor has it.
    #[default]
    Plain = 0,
    /// Corrected by the table.
    Corrected = 1,
}

/// Values of [`Thermometer::CHANGE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PdoValues)]
pub struct Change {
    /// Temperature, 0.1 °C; 8000h while there is none.
    pub temperature: i16,
    /// Relation to the limits.
    pub alarm: Alarm,
}

/// Objects of the thermometer besides those of every node. `S` is the memory of its table.
#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device, check = Thermometer::check_limits)]
pub struct Thermometer<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static = &'static mut [u8]> {
    /// Temperature
    ///
    /// 0.1 °C; 8000h while there is none.
    #[object(0x6000, ro, pdo, default = i16::MIN)]
    pub temperature: i16,
    /// Highest temperature
    ///
    /// Since power-on or the last command, 0.1 °C.
    #[object(0x6001, ro, pdo, default = i16::MIN)]
    pub highest: i16,
    /// Alarm
    #[object(0x6002, ro, pdo)]
    pub alarm: Alarm,
    /// Upper limit
    ///
    /// 0.1 °C.
    #[object(0x6010, rw, low = -400, high = 1_250, default = 850)]
    pub upper: i16,
    /// Lower limit
    ///
    /// 0.1 °C.
    #[object(0x6011, rw, low = -400, high = 1_250, default = -200)]
    pub lower: i16,
    /// Mode
    #[object(0x6012, rw)]
    pub mode: Mode,
    /// Command
    ///
    /// 1: forget the highest temperature.
    #[object(0x6020, rww, pdo)]
    pub command: u8,
    /// Calibration table
    ///
    /// A correction for every quarter of a degree from -128 °C on: 1024 times INTEGER16, 0.1 °C.
    #[object(0x6030, rw, keep)]
    pub table: Domain<S>,
}

impl<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static> Device for Thermometer<S> {
    type Pdos = PdoObjects<4, 4>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(
        &[Self::COMMAND_PDO.receive(1)],
        &[Self::CHANGE.transmit(2).state().inhibit(1_000), Self::CYCLE.transmit(4).transmission(1)],
    );

    fn communication(id: NodeId) -> Communication {
        Communication {
            device_name: "Thermometer",
            identity: Identity { vendor: 0, product: 0x7E, revision: 1 << 16, serial: 0 },
            ..Communication::new(id)
        }
    }
}

impl<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static> Thermometer<S> {
    /// Command: 200h + node.
    pub const COMMAND_PDO: Pdo<Self, (u8,)> = Pdo::new(CobIdOf::node(0x200)).map(Thermometer::COMMAND);
    /// Temperature and alarm when they change, at most ten times a second: 280h + node.
    pub const CHANGE: Pdo<Self, Change> =
        Pdo::new(CobIdOf::node(0x280)).map(Thermometer::TEMPERATURE).map(Thermometer::ALARM).into_struct();
    /// Temperature and highest temperature with every SYNC: 480h + node.
    pub const CYCLE: Pdo<Self, (i16, i16)> =
        Pdo::new(CobIdOf::node(0x480)).map(Thermometer::TEMPERATURE).map(Thermometer::HIGHEST);

    /// Checks that the lower limit stays below the upper one.
    fn check_limits(&self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        let (lower, upper) = match (at.index, value) {
            (0x6010, &[low, high]) => (self.lower, i16::from_le_bytes([low, high])),
            (0x6011, &[low, high]) => (i16::from_le_bytes([low, high]), self.upper),
            _ => return Ok(()),
        };
        if lower < upper { Ok(()) } else { Err(AbortCode::ParameterIncompatible) }
    }

    /// Updates the temperature and the alarm from the sensor's register Temp: two's complement, 1/256 °C (NXP LM75B,
    /// 7.4.3). `None`: the sensor did not answer.
    pub fn measured(&mut self, register: Option<i16>) {
        let Some(register) = register else {
            (self.temperature, self.alarm) = (i16::MIN, Alarm::NoSensor);
            return;
        };
        let tenths = (i32::from(register) * 10 + 128) >> 8;
        self.temperature = tenths as i16
            + match self.mode {
                Mode::Plain => 0,
                Mode::Corrected => self.correction(register),
            };
        self.highest = self.highest.max(self.temperature);
        self.alarm = match self.temperature {
            high if high > self.upper => Alarm::Above,
            low if low < self.lower => Alarm::Below,
            _ => Alarm::Within,
        };
    }

    /// Returns the correction of the table for a register value; zero beyond its end.
    fn correction(&self, register: i16) -> i16 {
        let at = (register >> 6).abs_diff(-512) as usize * 2;
        let entry = self.table.as_bytes().get(at..at + 2);
        entry.and_then(|bytes| bytes.try_into().ok()).map_or(0, i16::from_le_bytes)
    }

    /// Executes the command that a PDO wrote. Returns the highest temperature from now on.
    pub fn obey(&mut self) -> i16 {
        if self.command == 1 {
            self.highest = self.temperature;
        }
        self.highest
    }
}

/// Returns the builder of a thermometer; `memory` holds its table.
pub fn slave<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static>(
    id: NodeId,
    memory: S,
) -> SlaveBuilder<'static, Thermometer<S>> {
    let application = Thermometer { table: Domain::new(memory), ..Default::default() };
    Slave::builder(id, &PROFILE, application)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::boxed::Box;

    use ecss_can::od::Bytes;

    use super::*;

    /// Uses register values of the data sheet's table 10 (1900h is 25 °C, E700h -25 °C), and values on both sides of 85
    /// °C.
    #[test]
    fn registers_are_temperatures_and_set_the_alarm() {
        let mut thermometer = Thermometer::<[u8; 0]>::default();
        for (register, temperature, alarm) in [
            (0xE700_u16 as i16, -250, Alarm::Below),
            (0xFFE0_u16 as i16, -1, Alarm::Within),
            (0x1900, 250, Alarm::Within),
            (0x5500, 850, Alarm::Within),
            (0x5520, 851, Alarm::Above),
        ] {
            thermometer.measured(Some(register));
            assert_eq!((thermometer.temperature, thermometer.alarm), (temperature, alarm), "{register}");
        }
        assert_eq!(thermometer.highest, 851);
    }

    #[test]
    fn a_silent_sensor_leaves_no_temperature() {
        let mut thermometer = Thermometer::<[u8; 0]>::default();
        thermometer.measured(Some(0x1900));
        thermometer.measured(None);
        assert_eq!((thermometer.temperature, thermometer.alarm), (i16::MIN, Alarm::NoSensor));
        assert_eq!(thermometer.highest, 250);
    }

    /// Entries 0, 612 and 1023 are for -128 °C, 25 °C and 127.75 °C.
    #[test]
    fn the_table_has_an_entry_for_each_quarter_of_a_degree() {
        let mut table = [0; 2048];
        for (entry, correction) in [(0, 1), (612, 2), (1023, 3)] {
            table[2 * entry] = correction;
        }
        let mut thermometer: Thermometer = Thermometer { mode: Mode::Corrected, ..Default::default() };
        thermometer.table = Domain::new(&mut Box::leak(Box::new([0; 2048]))[..]);
        thermometer.table.write(&table).unwrap();
        for (register, temperature) in
            [(i16::MIN, -1_279), (0x1900, 252), (0x193F, 254), (0x1940, 253), (i16::MAX, 1_283)]
        {
            thermometer.measured(Some(register));
            assert_eq!(thermometer.temperature, temperature, "{register}");
        }
    }

    #[test]
    fn only_command_1_forgets_the_highest_temperature() {
        let mut thermometer = Thermometer::<[u8; 0]> { highest: 900, temperature: 250, ..Default::default() };
        assert_eq!(thermometer.obey(), 900);
        thermometer.command = 1;
        assert_eq!(thermometer.obey(), 250);
    }

    #[test]
    fn limits_in_the_wrong_order_are_refused() {
        let thermometer = Thermometer::<[u8; 0]>::default();
        let write = |at: Address, value: i16| thermometer.check(at, &value.to_le_bytes());
        assert_eq!(write(Thermometer::UPPER.address(), -200), Err(AbortCode::ParameterIncompatible));
        assert_eq!(write(Thermometer::UPPER.address(), -199), Ok(()));
        assert_eq!(write(Thermometer::LOWER.address(), 850), Err(AbortCode::ParameterIncompatible));
    }
}
