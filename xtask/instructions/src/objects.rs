//! The device that is measured: its objects and PDOs.

use ecss_can::node::Communication;
use ecss_can::od::{Domain, NO_REMOTE, Objects};
use ecss_can::pdo::Mapping;
use ecss_can::types::{CobId, NodeId};

/// The slave.
pub const NODE: NodeId = NodeId::of::<2>();
/// Another one, whose heartbeat it consumes.
pub const PEER: NodeId = NodeId::of::<3>();

/// Bytes of the block.
pub const BLOCK: usize = 32 << 10;

/// Objects of the application.
#[derive(Objects)]
pub struct Application {
    /// Received by PDO
    #[object(0x6000, array, rw, pdo)]
    pub received: [u16; 4],
    /// Sent by PDO
    #[object(0x6100, array, rw, pdo)]
    pub sent: [u16; 4],
    /// Number
    #[object(0x6200, rw)]
    pub number: u32,
    /// Single value 1
    #[object(0x6201, rw, pdo)]
    pub one: u16,
    /// Single value 2
    #[object(0x6202, rw, pdo)]
    pub two: u16,
    /// Single value 3
    #[object(0x6203, rw, pdo)]
    pub three: u16,
    /// Single value 4
    #[object(0x6204, rw, pdo)]
    pub four: u16,
    /// Block
    #[object(0x6300, rw)]
    pub block: Domain<Vec<u8>>,
}

/// RPDO 1 and TPDO 1 of an array of four numbers each, the latter with every SYNC.
pub fn communication<M: Mapping>(node: NodeId) -> Communication<8, 8, M> {
    let four = |index: u32| [1, 2, 3, 4].map(|sub| index << 16 | sub << 8 | 16);
    with(node, four(0x6000), four(0x6100))
}

/// The same of four numbers that are objects of their own.
pub fn scattered<M: Mapping>(node: NodeId) -> Communication<8, 8, M> {
    let four = [0x6201, 0x6203, 0x6202, 0x6204].map(|index| index << 16 | 16);
    with(node, four, four)
}

fn with<M: Mapping>(node: NodeId, received: [u32; 4], sent: [u32; 4]) -> Communication<8, 8, M> {
    let mut objects = Communication::<8, 8, M>::new(node);
    let [rpdo, ..] = &mut objects.rpdos;
    rpdo.cob_id = NO_REMOTE | u32::from(receive_id().raw());
    objects.rpdo_mappings[0].map(&received);
    let [tpdo, ..] = &mut objects.tpdos;
    (tpdo.cob_id, tpdo.transmission) = (NO_REMOTE | u32::from(transmit_id().raw()), 1);
    objects.tpdo_mappings[0].map(&sent);
    objects.consumer_heartbeat[1] = u32::from(PEER.get()) << 16 | 250;
    objects
}

/// COB-ID of RPDO 1.
pub fn receive_id() -> CobId {
    pre_defined(CobId::rpdo(1, NODE))
}

/// COB-ID of TPDO 1.
pub fn transmit_id() -> CobId {
    pre_defined(CobId::tpdo(1, NODE))
}

fn pre_defined(id: Option<CobId>) -> CobId {
    id.expect("the first four PDOs have pre-defined COB-IDs")
}
