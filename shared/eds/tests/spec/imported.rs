//! Constants that `eds!` makes of the committed data sheet of the slave, against the declaration that the file was made of.

use ecss_can::od::{DataType, Field, NotWritable, Readable, U40, U48, eds};
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};
use ecss_can::types::{Address, NodeId};
use mission::{MissionObjects, Outgoing, REQUEST, TELECOMMAND, Telecommand};

eds! {
    /// The slave, as a maker of another master knows it.
    struct Slave = "../../docs/eds/slave.eds";
}

const NODE: NodeId = NodeId::of::<3>();

const VALUE: Field<u32> = Slave::VALUE_SET_BY_COMMAND;
const CODE: Field<u16, Readable, NotWritable> = Slave::TELEMETRY_CODE;
const COMMAND: Pdo<Slave, (u16, U40, u8)> = Slave::RPDO_2;
const ASKED: Pdo<Slave, (u16, U48)> = Slave::RPDO_3;
const TELEMETRY: Pdo<Slave, (u16, U48)> = Slave::TPDO_3;

/// Address and type.
fn of<T, R, W>(field: Field<T, R, W>) -> (Address, DataType) {
    (field.address(), field.data_type())
}

#[test]
fn constants_have_addresses_and_types_of_the_declaration() {
    assert_eq!(of(VALUE), of(MissionObjects::VALUE));
    assert_eq!(of(CODE), of(MissionObjects::TELEMETRY.field(Outgoing::CODE)));
    let telecommand = MissionObjects::TELECOMMAND;
    assert_eq!(of(Slave::TELECOMMAND_DATA), of(telecommand.field(Telecommand::DATA)));
    assert_eq!(of(Slave::TELECOMMAND_SEQUENCE), of(telecommand.field(Telecommand::SEQUENCE)));
    assert_eq!(of(Slave::DATA_STORE), (Address::new(0x6300, 0), DataType::Domain));
    assert_eq!(of(Slave::MANUFACTURER_DEVICE_NAME), (Address::new(0x1008, 0), DataType::VisibleString));
    assert_eq!(of(Slave::IDENTITY_OBJECT_PRODUCT_CODE), (Address::new(0x1018, 2), DataType::Unsigned32));
}

/// Given the data sheet and the declaration, then PDOs of both are equal on the bus: COB-ID, values, and their frame.
#[test]
fn pdos_are_those_of_the_mission() {
    let values = (0x0102, U40::new(0x03_0405_0607), 8);
    assert_eq!(COMMAND.of(NODE).frame(values), TELECOMMAND.of(NODE).frame(values));
    assert_eq!(COMMAND.cob_id(), TELECOMMAND.cob_id());
    let values = (0x0102, U48::new(0x0304_0506_0708));
    assert_eq!(ASKED.of(NODE).frame(values), REQUEST.of(NODE).frame(values));
    assert_eq!(TELEMETRY.cob_id(), <MissionObjects>::TELEMETRY_PDO.cob_id());
    // The time of the master has one COB-ID for all nodes.
    assert_eq!(Slave::RPDO_1.cob_id(), CobIdOf::fixed(0x181));
    assert_eq!(Slave::TPDO_1.cob_id(), CobIdOf::node(0x180));
}

/// Given a set of the PDOs of the data sheet, then their objects are those of the file.
#[test]
fn pdos_have_the_mapping_of_the_file() {
    const PDOS: PdoSet = PdoSet::new(&[Slave::RPDO_2.receive(2)], &[Slave::TPDO_3.transmit(3)]);
    let all: PdoObjects<4, 4> = PDOS.at_power_on(NODE);
    assert_eq!((all.rpdos[1].cob_id, all.tpdos[2].cob_id), (0x4000_0303, 0x4000_0383));
    assert_eq!(all.rpdo_mappings[1].objects[..3], [0x6200_0110, 0x6200_0228, 0x6200_0308]);
    assert_eq!(all.tpdo_mappings[2].objects[..2], [0x6100_0110, 0x6100_0230]);
}
