//! What the refused sets should have been.
#![deny(warnings)]

use ecss_can::emcy::EmcyObjects;
use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{BusHealth, Communication, Device, Spacecraft};
use ecss_can::od::{INVALID, NO_REMOTE, Objects};
use ecss_can::pdo::{CobIdOf, Mapping, Pdo, PdoObjects, PdoSet};
use ecss_can::types::NodeId;

#[derive(Objects)]
#[objects(device)]
pub struct Thermometer {
    /// Temperature
    #[object(0x6000, ro, pdo)]
    pub temperature: i16,
    /// Set point
    #[object(0x6001, rww, pdo)]
    pub set_point: i16,
    /// Flags
    #[object(0x6004, array, rw, pdo)]
    pub flags: [bool; 9],
}

impl Device for Thermometer {
    type Pdos = PdoObjects<2, 512>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PDOS;
}

const PDOS: PdoSet = PdoSet::new(
    &[Pdo::<()>::new(CobIdOf::fixed(0x700)).skip::<u32>().map(Thermometer::SET_POINT).map(Thermometer::FLAGS.sub(9)).receive(2).transmission(240).event_timer(1_000)],
    &[
        Pdo::<()>::new(CobIdOf::node(0x500)).map(Thermometer::TEMPERATURE).map(EmcyObjects::REGISTER).map(Communication::STATUS_REGISTER).map(Spacecraft::HEALTH_NOMINAL.field(BusHealth::STATE)).transmit(512).transmission(1).sync_start(240),
        Pdo::<()>::new(CobIdOf::node(0x180)).map(Thermometer::FLAGS.sub(1)).transmit(1).inhibit(100).event_timer(250),
    ],
);

fn main() {
    let node = NodeId::of::<5>();
    let objects = Thermometer::pdos(node);
    assert_eq!(objects.rpdos[0].cob_id, INVALID | NO_REMOTE | 0x205);
    let rpdo = objects.rpdos[1];
    assert_eq!((rpdo.cob_id, rpdo.transmission, rpdo.event_timer), (NO_REMOTE | 0x700, 240, 1_000));
    assert_eq!(objects.rpdo_mappings[1].objects(), [0x0007_0020, 0x6001_0010, 0x6004_0901]);
    let first = objects.tpdos[0];
    assert_eq!((first.cob_id, first.transmission), (NO_REMOTE | 0x185, 254));
    assert_eq!((first.inhibit, first.event_timer), (100, 250));
    assert_eq!(objects.tpdo_mappings[0].objects(), [0x6004_0101]);
    let last = objects.tpdos[511];
    assert_eq!((last.cob_id, last.transmission, last.sync_start), (NO_REMOTE | 0x505, 1, 240));
    assert_eq!(objects.tpdo_mappings[511].objects(), [0x6000_0010, 0x1001_0008, 0x1002_0020, 0x2020_0108]);
}
