//! Objects of the demonstration mission's slaves, and the PDOs that carry them.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Communication, Device, Identity, LOCAL_TIME, SPACECRAFT_TIME, Slave, SlaveBuilder};
use ecss_can::od::{Domain, Objects, Record, U40, U48};
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};
use ecss_can::profile::Profile;
use ecss_can::types::NodeId;

use crate::Message;

/// Telecommand to a slave, code, data and sequence: 300h + node.
pub const TELECOMMAND: Pdo<MissionObjects, (u16, U40, u8)> = Pdo::new(CobIdOf::node(0x300))
    .map(MissionObjects::TELECOMMAND.field(Telecommand::CODE))
    .map(MissionObjects::TELECOMMAND.field(Telecommand::DATA))
    .map(MissionObjects::TELECOMMAND.field(Telecommand::SEQUENCE));
/// Request of telemetry from a slave, code and data: 400h + node.
pub const REQUEST: Pdo<MissionObjects, (u16, U48)> = Pdo::new(CobIdOf::node(0x400))
    .map(MissionObjects::REQUEST.field(TelemetryRequest::CODE))
    .map(MissionObjects::REQUEST.field(TelemetryRequest::DATA));

/// Objects of a slave of the mission besides those of every node. `S` is the memory of its data store.
#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
pub struct MissionObjects<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static = &'static mut [u8]> {
    /// Telemetry
    #[object(0x6100, record)]
    pub telemetry: Outgoing,
    /// Telemetry request
    #[object(0x6101, record)]
    pub request: TelemetryRequest,
    /// Telecommand
    #[object(0x6200, record)]
    pub telecommand: Telecommand,
    /// Value set by command
    #[object(0x6210, rw, pdo)]
    pub value: u32,
    /// Pulses per second
    ///
    /// At the pulse output of the board, at equal parts of a second of the spacecraft time.
    #[object(0x6310, rw, low = 1, high = 1000, default = 1)]
    pub pulses: u16,
    /// Data store
    ///
    /// A block of memory for software and tables. "save" does not keep it: it is larger than the parameter store.
    #[object(0x6300, rw)]
    pub store: Domain<S>,
}

impl<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static> Device for MissionObjects<S> {
    type Pdos = PdoObjects<8, 8>;
    type Consumers = HeartbeatConsumers<8>;

    const PDOS: PdoSet = PdoSet::new(
        &[SPACECRAFT_TIME, TELECOMMAND.receive(2), REQUEST.receive(3)],
        &[LOCAL_TIME, Self::TELEMETRY_PDO.transmit(3)],
    );

    fn communication(id: NodeId) -> Communication {
        Communication {
            device_name: "ECSS-E-ST-50-15C slave",
            hardware_version: "STM32F4, two bxCAN",
            software_version: env!("CARGO_PKG_VERSION"),
            identity: Identity { vendor: 0, product: 0x5015, revision: 1 << 16, serial: id.get().into() },
            ..Communication::new(id)
        }
    }
}

impl<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static> MissionObjects<S> {
    /// Telemetry of a slave, code and data: 380h + node.
    pub const TELEMETRY_PDO: Pdo<Self, (u16, U48)> = Pdo::new(CobIdOf::node(0x380))
        .map(MissionObjects::TELEMETRY.field(Outgoing::CODE))
        .map(MissionObjects::TELEMETRY.field(Outgoing::DATA));
}

/// The last telecommand received by PDO, repeats included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Telecommand {
    /// Code
    #[sub(1, rww, pdo)]
    pub code: u16,
    /// Data
    #[sub(2, rww, pdo)]
    pub data: U40,
    /// Sequence
    ///
    /// The master steps it with each command to this slave. The application drops a command with the sequence and the
    /// bytes of the last one.
    #[sub(3, rww, pdo)]
    pub sequence: u8,
}

/// The last telemetry request received by PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct TelemetryRequest {
    /// Code
    #[sub(1, rww, pdo)]
    pub code: u16,
    /// Data
    ///
    /// Zero in every request of this mission. A request may leave out some or all of it (ECSS Figure 9-2).
    #[sub(2, rww, pdo, optional)]
    pub data: U48,
}

/// A message that a PDO sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Outgoing {
    /// Code
    #[sub(1, ro, pdo)]
    pub code: u16,
    /// Data
    #[sub(2, ro, pdo)]
    pub data: U48,
}

impl From<Message> for Outgoing {
    fn from(message: Message) -> Outgoing {
        let (code, data) = message.values();
        Outgoing { code, data }
    }
}

/// Returns the builder of a slave of the mission; `memory` is its data store.
pub fn slave<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static>(
    id: NodeId,
    profile: &Profile,
    memory: S,
) -> SlaveBuilder<'_, MissionObjects<S>> {
    let application = MissionObjects { store: Domain::new(memory), ..Default::default() };
    Slave::builder(id, profile, application)
}
