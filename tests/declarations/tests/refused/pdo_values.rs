//! PDOs of values that no PDO carries, or none of this direction, and of too many.

use ecss_can::emcy::EmcyObjects;
use ecss_can::node::Communication;
use ecss_can::od::{DataType, Objects, Record, VisibleString};
use ecss_can::pdo::{CobIdOf, Rpdo, Tpdo};
use ecss_can::redundancy::RedundancyObjects;

#[derive(Objects)]
struct Thermometer {
    /// Temperature
    #[object(0x6000, ro, pdo)]
    temperature: i16,
    /// Set point
    #[object(0x6001, rww, pdo)]
    set_point: i16,
    /// Private
    #[object(0x6002, rw)]
    private: u8,
    /// Name
    #[object(0x6003, rw)]
    name: VisibleString<8>,
    /// Flags
    #[object(0x6004, array, rw, pdo)]
    flags: [bool; 9],
    /// Readings
    #[object(0x6005, record)]
    readings: Readings,
}

#[derive(Record)]
struct Readings {
    /// Sum
    #[sub(1, ro, pdo)]
    sum: u64,
    /// Is valid
    #[sub(2, ro, pdo)]
    is_valid: bool,
}

const ID: CobIdOf = CobIdOf::node(0x280);

const READ_ONLY: Rpdo = Rpdo::new(1, ID).map(Thermometer::TEMPERATURE);
const WRITTEN: Tpdo = Tpdo::new(1, ID).map(Thermometer::SET_POINT);
const PRIVATE: Tpdo = Tpdo::new(1, ID).map(Thermometer::PRIVATE);
const NAME: Tpdo = Tpdo::new(1, ID).map(Thermometer::NAME);
const HIGHEST_SUB: Tpdo = Tpdo::new(1, ID).map(Thermometer::FLAGS.sub(0));
const TOO_LONG: Tpdo = Tpdo::new(1, ID)
    .map(Thermometer::READINGS.field(Readings::SUM))
    .map(Thermometer::READINGS.field(Readings::IS_VALID));
const TOO_MANY: Rpdo = Rpdo::new(2, ID)
    .map(Thermometer::FLAGS.sub(1))
    .map(Thermometer::FLAGS.sub(2))
    .map(Thermometer::FLAGS.sub(3))
    .map(Thermometer::FLAGS.sub(4))
    .map(Thermometer::FLAGS.sub(5))
    .map(Thermometer::FLAGS.sub(6))
    .map(Thermometer::FLAGS.sub(7))
    .map(Thermometer::FLAGS.sub(8))
    .map(Thermometer::FLAGS.sub(9));
const NO_DUMMY: Rpdo = Rpdo::new(1, ID).skip(DataType::Unsigned64);
const REGISTER: Rpdo = Rpdo::new(1, ID).map(EmcyObjects::REGISTER);
const DEVICE_TYPE: Tpdo = Tpdo::new(1, ID).map(Communication::DEVICE_TYPE);
const BDEFAULT: Rpdo = Rpdo::new(1, ID).map(RedundancyObjects::PARAMETERS.sub(1));

fn main() {}
