//! The device that is measured: its objects and PDOs.

use ecss_can::node::{Communication, assert_pdos};
use ecss_can::od::{Domain, Field, Objects};
use ecss_can::pdo::{CobIdOf, Mapping, PdoSet, Rpdo, Tpdo};
use ecss_can::types::{CobId, NodeId};

/// The slave.
pub const NODE: NodeId = NodeId::of::<2>();
/// Another one, whose heartbeat it consumes.
pub const PEER: NodeId = NodeId::of::<3>();

/// Bytes of the block.
pub const BLOCK: usize = 32 << 10;

/// Objects of the application.
#[derive(Objects)]
#[objects(pdos = FOUR)]
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
const FOUR: PdoSet = PdoSet::new(
    &[receive(Application::RECEIVED.sub(1))
        .map(Application::RECEIVED.sub(2))
        .map(Application::RECEIVED.sub(3))
        .map(Application::RECEIVED.sub(4))],
    &[transmit(Application::SENT.sub(1))
        .map(Application::SENT.sub(2))
        .map(Application::SENT.sub(3))
        .map(Application::SENT.sub(4))],
);

/// The same of four numbers that are objects of their own.
const SCATTERED: PdoSet = PdoSet::new(
    &[receive(Application::ONE).map(Application::THREE).map(Application::TWO).map(Application::FOUR)],
    &[transmit(Application::ONE).map(Application::THREE).map(Application::TWO).map(Application::FOUR)],
);
const _: () = assert_pdos::<Application, 8, 8>(&SCATTERED);

const fn receive(first: Field) -> Rpdo {
    Rpdo::new(1, CobIdOf::node(0x200)).map(first)
}

const fn transmit(first: Field) -> Tpdo {
    Tpdo::new(1, CobIdOf::node(0x180)).transmission(1).map(first)
}

/// With PDOs of arrays.
pub fn communication<M: Mapping>(node: NodeId) -> Communication<8, 8, M> {
    with(node, &FOUR)
}

/// With PDOs of numbers that are objects of their own.
pub fn scattered<M: Mapping>(node: NodeId) -> Communication<8, 8, M> {
    with(node, &SCATTERED)
}

fn with<M: Mapping>(node: NodeId, pdos: &PdoSet) -> Communication<8, 8, M> {
    let mut objects = Communication::new(node).with_pdos(node, pdos);
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
