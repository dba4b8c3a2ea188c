//! A small device for tests inside the nodes, and an extension that guards its COB-IDs.

use super::{Device, Event};
use crate::heartbeat::HeartbeatConsumers;
use crate::node::services::Extension;
use crate::od::{NO_REMOTE, Objects};
use crate::pdo::{Mapping, PdoObjects, PdoSet};
use crate::store::machine::NoStore;
use crate::types::NodeId;

/// A number that PDO 1 of both directions carries.
#[derive(Debug, Objects)]
#[objects(device)]
pub struct Probe {
    /// Number
    #[object(0x6000, rw, pdo)]
    number: u8,
}

impl Device for Probe {
    type Pdos = PdoObjects<2, 2>;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PdoSet::NONE;

    fn pdos(id: NodeId) -> PdoObjects<2, 2> {
        let mut pdos: PdoObjects<2, 2> = PdoSet::NONE.at_power_on(id);
        pdos.rpdos[0].cob_id = 0x205;
        pdos.rpdo_mappings[0].map(&[0x6000_0008]);
        pdos.tpdos[0].cob_id = NO_REMOTE | 0x185;
        pdos.tpdo_mappings[0].map(&[0x6000_0008]);
        pdos
    }
}

/// A number, and two SDO servers.
#[derive(Debug, Objects)]
#[objects(device, sdo_servers = 2)]
pub struct TwoServers {
    /// Number
    #[object(0x6000, rw)]
    number: u8,
}

impl Device for TwoServers {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PdoSet::NONE;
}

/// Extension of a node that looks for flipped bits. It counts those that were mended.
#[derive(Debug, Objects)]
pub struct Guard {
    #[skip]
    pub mended: u16,
}

impl<D: Device> Extension<D> for Guard {
    type Storage = NoStore;
    type State = ();
    type Event = core::convert::Infallible;
    type SlaveEvent = Event;

    const IS_GUARDED: bool = true;

    fn count_mended(&mut self) -> u16 {
        self.mended += 1;
        self.mended
    }
}
