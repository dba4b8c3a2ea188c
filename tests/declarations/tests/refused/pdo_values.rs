//! PDOs of values that no PDO carries, or none of this direction, and of too many.

use ecss_can::emcy::EmcyObjects;
use ecss_can::node::Communication;
use ecss_can::od::{Objects, Record, VisibleString};
use ecss_can::pdo::{CobIdOf, Pdo, Rpdo, Tpdo};
use ecss_can::redundancy::{Redundancy, RedundancyObjects};

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

const READ_ONLY: Rpdo = Pdo::<()>::new(ID).map(Thermometer::TEMPERATURE).receive(1);
const WRITTEN: Tpdo = Pdo::<()>::new(ID).map(Thermometer::SET_POINT).transmit(1);
const PRIVATE: Tpdo = Pdo::<()>::new(ID).map(Thermometer::PRIVATE).transmit(1);
const NAME: Tpdo = Pdo::<()>::new(ID).map(Thermometer::NAME).transmit(1);
const HIGHEST_SUB: Tpdo = Pdo::<()>::new(ID).map(Thermometer::FLAGS.sub(0)).transmit(1);
const TOO_LONG: Tpdo = Pdo::<()>::new(ID)
    .map(Thermometer::READINGS.field(Readings::SUM))
    .map(Thermometer::READINGS.field(Readings::IS_VALID))
    .transmit(1);
const TOO_MANY: Rpdo = Pdo::<()>::new(ID)
    .map(Thermometer::FLAGS.sub(1))
    .map(Thermometer::FLAGS.sub(2))
    .map(Thermometer::FLAGS.sub(3))
    .map(Thermometer::FLAGS.sub(4))
    .map(Thermometer::FLAGS.sub(5))
    .map(Thermometer::FLAGS.sub(6))
    .map(Thermometer::FLAGS.sub(7))
    .map(Thermometer::FLAGS.sub(8))
    .map(Thermometer::FLAGS.sub(9))
    .receive(2);
const NO_DUMMY: Rpdo = Pdo::<()>::new(ID).skip::<u64>().receive(1);
const REGISTER: Rpdo = Pdo::<()>::new(ID).map(EmcyObjects::REGISTER).receive(1);
const DEVICE_TYPE: Tpdo = Pdo::<()>::new(ID).map(Communication::DEVICE_TYPE).transmit(1);
const BDEFAULT: Rpdo = Pdo::<()>::new(ID).map(RedundancyObjects::PARAMETERS.field(Redundancy::BDEFAULT)).receive(1);

fn main() {}
