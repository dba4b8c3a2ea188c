//! The device that is measured: its objects and PDOs.

use core::marker::PhantomData;

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, assert_device};
use ecss_can::od::{Domain, Objects};
use ecss_can::pdo::{CobIdOf, Mapping, Pdo, PdoMapping, PdoObjects, PdoSet};
use ecss_can::types::{CobId, NodeId};

/// The slave.
pub const NODE: NodeId = NodeId::of::<2>();
/// Another one, whose heartbeat it consumes.
pub const PEER: NodeId = NodeId::of::<3>();

/// Bytes of the block.
pub const BLOCK: usize = 32 << 10;

/// Objects of the application, with PDOs of arrays or of numbers that are objects of their own.
#[derive(Objects)]
#[objects(device)]
pub struct Application<M: Mapping = PdoMapping, const SCATTERED: bool = false> {
    #[skip]
    pub mapping: PhantomData<M>,
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
const OF_ARRAYS: PdoSet = PdoSet::new(
    &[Pdo::<()>::new(RECEIVE)
        .map(Application::RECEIVED.sub(1))
        .map(Application::RECEIVED.sub(2))
        .map(Application::RECEIVED.sub(3))
        .map(Application::RECEIVED.sub(4))
        .receive(1)],
    &[Pdo::<()>::new(TRANSMIT)
        .map(Application::SENT.sub(1))
        .map(Application::SENT.sub(2))
        .map(Application::SENT.sub(3))
        .map(Application::SENT.sub(4))
        .transmit(1)
        .transmission(1)],
);

/// The same of four numbers that are objects of their own.
const OF_OBJECTS: PdoSet = PdoSet::new(
    &[Pdo::<()>::new(RECEIVE)
        .map(Application::ONE)
        .map(Application::THREE)
        .map(Application::TWO)
        .map(Application::FOUR)
        .receive(1)],
    &[Pdo::<()>::new(TRANSMIT)
        .map(Application::ONE)
        .map(Application::THREE)
        .map(Application::TWO)
        .map(Application::FOUR)
        .transmit(1)
        .transmission(1)],
);
const RECEIVE: CobIdOf = CobIdOf::node(0x200);
const TRANSMIT: CobIdOf = CobIdOf::node(0x180);
const _: () = assert_device::<Application<PdoMapping, true>>();

impl<M: Mapping, const SCATTERED: bool> Device for Application<M, SCATTERED> {
    type Pdos = PdoObjects<8, 8, M>;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = if SCATTERED { OF_OBJECTS } else { OF_ARRAYS };

    fn consumers(_: NodeId) -> HeartbeatConsumers {
        let mut consumers = HeartbeatConsumers::default();
        consumers.consumer_heartbeat[1] = u32::from(PEER.get()) << 16 | 250;
        consumers
    }
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
