//! The slave of these targets: records with values of several widths, one of them optional, a number and a block.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Communication, Device, Slave};
use ecss_can::od::{Domain, Objects, Record, U40, U48};
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, Rpdo, Tpdo};
use ecss_can::profile::Profile;
use ecss_can::time::{LocalScet, ScetGet, ScetSet};
use ecss_can::types::NodeId;

const TIME: Rpdo = Pdo::<()>::new(CobIdOf::fixed(0x181))
    .map(LocalScet::SCET_SET.field(ScetSet::FINE))
    .map(LocalScet::SCET_SET.field(ScetSet::COARSE))
    .receive(1);
const COMMAND: Rpdo = Pdo::<()>::new(CobIdOf::node(0x300))
    .map(Instrument::TELECOMMAND.field(Telecommand::CODE))
    .map(Instrument::TELECOMMAND.field(Telecommand::DATA))
    .map(Instrument::TELECOMMAND.field(Telecommand::SEQUENCE))
    .receive(2);
const REQUEST: Rpdo = Pdo::<()>::new(CobIdOf::node(0x400))
    .map(Instrument::REQUEST.field(Request::CODE))
    .map(Instrument::REQUEST.field(Request::DATA))
    .receive(3);
const LOCAL_TIME: Tpdo = Pdo::<()>::new(CobIdOf::node(0x180))
    .map(LocalScet::SCET_GET.field(ScetGet::FINE))
    .map(LocalScet::SCET_GET.field(ScetGet::COARSE))
    .transmit(1)
    .transmission(1);
const TELEMETRY: Tpdo = Pdo::<()>::new(CobIdOf::node(0x380))
    .map(Instrument::TELEMETRY.field(Telemetry::CODE))
    .map(Instrument::TELEMETRY.field(Telemetry::DATA))
    .transmit(3);

/// Objects of the slave in addition to those of every node.
#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
pub struct Instrument {
    /// Telemetry
    #[object(0x6100, record)]
    pub telemetry: Telemetry,
    /// Telemetry request
    #[object(0x6101, record)]
    pub request: Request,
    /// Telecommand
    #[object(0x6200, record)]
    pub telecommand: Telecommand,
    /// Number
    #[object(0x6210, rw, pdo)]
    pub number: u32,
    /// Block
    #[object(0x6300, rw)]
    pub block: Domain<Vec<u8>>,
}

impl Device for Instrument {
    type Pdos = PdoObjects<8, 8>;
    type Consumers = HeartbeatConsumers<8>;

    const PDOS: PdoSet = PdoSet::new(&[TIME, COMMAND, REQUEST], &[LOCAL_TIME, TELEMETRY]);

    fn communication(id: NodeId) -> Communication {
        Communication { device_name: "Instrument", ..Communication::new(id) }
    }
}

/// Telemetry of the slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Telemetry {
    /// Code
    #[sub(1, ro, pdo)]
    pub code: u16,
    /// Data
    #[sub(2, ro, pdo)]
    pub data: U48,
}

/// Request for telemetry. Its data is optional.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Request {
    /// Code
    #[sub(1, rww, pdo)]
    pub code: u16,
    /// Data
    #[sub(2, rww, pdo, optional)]
    pub data: U48,
}

/// Command to the slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Telecommand {
    /// Code
    #[sub(1, rww, pdo)]
    pub code: u16,
    /// Data
    #[sub(2, rww, pdo)]
    pub data: U40,
    /// Sequence
    #[sub(3, rww, pdo)]
    pub sequence: u8,
}

/// Returns the slave before power-on.
pub fn slave(id: NodeId, profile: &Profile) -> Slave<Instrument> {
    let application = Instrument { block: Domain::new(vec![0; 64]), ..Instrument::default() };
    Slave::builder(id, profile, application).build()
}
