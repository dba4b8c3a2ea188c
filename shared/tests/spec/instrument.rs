//! The slave of these tests: a message in, a message out, a request, a number and a block of bytes.

use ecss_can::boot::{AssignedSlave, Expected, Setting};
use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Communication, Device, Identity, Slave, SlaveBuilder};
use ecss_can::od::{Domain, Objects, Record, U48};
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, Rpdo, Tpdo};
use ecss_can::profile::Profile;
use ecss_can::time::{LocalScet, ScetGet, ScetSet};
use ecss_can::types::{Address, Duration, NodeId};

/// Heartbeat and SYNC 100 ms, consumer time 250 ms, Ttoggle 2, no slave assigned.
pub const STANDARD: Profile = Profile { name: "standard", ..Profile::DEFAULT };

/// Slow, slave 4 with selective access, slaves 2 to 4 assigned and configured.
pub const SLOW: Profile = Profile {
    name: "slow",
    heartbeat: Duration::from_millis(250),
    consumer: Duration::from_millis(2_500),
    ttoggle: 5,
    ntoggle: 10,
    sync: Duration::from_millis(5_000),
    time: Duration::from_millis(10_000),
    selective: &[NodeId::of::<4>()],
    slaves: &[assigned(NodeId::of::<2>()), assigned(NodeId::of::<3>()), assigned(NodeId::of::<4>())],
    settings: &[setting(NodeId::of::<2>()), setting(NodeId::of::<3>()), setting(NodeId::of::<4>())],
    ..STANDARD
};

const fn assigned(node: NodeId) -> AssignedSlave {
    let expected = Expected { device_type: 0, identity: [0, 0x5015, 0, 0], stamp: [12_321, 43_200_000] };
    AssignedSlave { node, mandatory: false, expected }
}

/// A missed heartbeat of a peer changes nothing.
const fn setting(node: NodeId) -> Setting {
    Setting { node, at: Address::new(0x1029, 1), value: &[1] }
}

/// Transmit PDO of telemetry, as requests number it.
pub const TELEMETRY_TPDO: usize = 2;

/// 181h: the spacecraft time.
const TIME: Rpdo = Pdo::<()>::new(CobIdOf::fixed(0x181))
    .map(LocalScet::SCET_SET.field(ScetSet::FINE))
    .map(LocalScet::SCET_SET.field(ScetSet::COARSE))
    .receive(1);
/// 300h + node.
const COMMAND: Rpdo = Pdo::<()>::new(CobIdOf::node(0x300))
    .map(Instrument::TELECOMMAND.field(Incoming::CODE))
    .map(Instrument::TELECOMMAND.field(Incoming::DATA))
    .receive(2);
/// 400h + node.
const REQUEST: Rpdo = Pdo::<()>::new(CobIdOf::node(0x400))
    .map(Instrument::REQUEST.field(Incoming::CODE))
    .map(Instrument::REQUEST.field(Incoming::DATA))
    .receive(3);
/// 180h + node, with every SYNC.
const LOCAL_TIME: Tpdo = Pdo::<()>::new(CobIdOf::node(0x180))
    .map(LocalScet::SCET_GET.field(ScetGet::FINE))
    .map(LocalScet::SCET_GET.field(ScetGet::COARSE))
    .transmit(1)
    .transmission(1);
/// 380h + node.
const TELEMETRY: Tpdo = Pdo::<()>::new(CobIdOf::node(0x380))
    .map(Instrument::TELEMETRY.field(Outgoing::CODE))
    .map(Instrument::TELEMETRY.field(Outgoing::DATA))
    .transmit(3);

#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
pub struct Instrument {
    /// Telemetry
    #[object(0x6100, record)]
    pub telemetry: Outgoing,
    /// Telemetry request
    #[object(0x6101, record)]
    pub request: Incoming,
    /// Telecommand
    #[object(0x6200, record)]
    pub telecommand: Incoming,
    /// Number
    #[object(0x6210, rw, pdo)]
    pub value: u32,
    /// Block
    #[object(0x6300, rw)]
    pub store: Domain<Vec<u8>>,
}

impl Device for Instrument {
    type Pdos = PdoObjects<8, 8>;
    type Consumers = HeartbeatConsumers<8>;

    const PDOS: PdoSet = PdoSet::new(&[TIME, COMMAND, REQUEST], &[LOCAL_TIME, TELEMETRY]);

    fn communication(id: NodeId) -> Communication {
        Communication {
            device_name: "Instrument",
            software_version: "1.0",
            identity: Identity { vendor: 0, product: 0x5015, revision: 1 << 16, serial: id.get().into() },
            ..Communication::new(id)
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Incoming {
    /// Code
    #[sub(1, rww, pdo)]
    pub code: u16,
    /// Data
    #[sub(2, rww, pdo)]
    pub data: U48,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Outgoing {
    /// Code
    #[sub(1, ro, pdo)]
    pub code: u16,
    /// Data
    #[sub(2, ro, pdo)]
    pub data: U48,
}

/// An instrument with this block, to be built.
pub fn builder(id: NodeId, profile: &Profile, memory: Vec<u8>) -> SlaveBuilder<'_, Instrument> {
    let application = Instrument { store: Domain::new(memory), ..Instrument::default() };
    Slave::builder(id, profile, application)
}

/// An instrument with this block, without a parameter store.
pub fn slave(id: NodeId, profile: &Profile, memory: Vec<u8>) -> Slave<Instrument> {
    builder(id, profile, memory).build()
}
