//! The objects that the data sheet of a minimal slave shows (ECSS 9.2a). No node holds them, and no SDO reaches them.

use ecss_can::node::Identity;
use ecss_can::node::minimal::{MinimalDevice, MinimalPdos, MinimalTpdo, assert_minimal};
use ecss_can::od::{Objects, Record, U48};
use ecss_can::pdo::{Mapping, StaticMapping};
use ecss_can::profile::Profile;
use ecss_can::types::{CobId, Duration, NodeId};

use super::MinimalMission;

/// Objects of a minimal slave of the mission. All values are hard-coded.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct MinimalObjects {
    /// Device type
    #[object(0x1000, ro)]
    pub device_type: u32,
    /// Error register
    #[object(0x1001, ro)]
    pub error_register: u8,
    /// COB-ID SYNC message
    #[object(0x1005, ro, default = 0x80)]
    pub cob_id_sync: u32,
    /// Consumer heartbeat time
    ///
    /// Node-ID in bits 16 to 22, milliseconds below.
    #[object(0x1016, array, ro)]
    pub consumer_heartbeat: [u32; 1],
    /// Producer heartbeat time
    ///
    /// Milliseconds.
    #[object(0x1017, ro)]
    pub producer_heartbeat: u16,
    /// Identity object
    #[object(0x1018, record)]
    pub identity: Identity,
    /// Receive PDO communication parameter
    #[object(0x1400.., record)]
    pub rpdos: [FixedPdo; 4],
    /// Receive PDO mapping parameter
    #[object(0x1600.., record)]
    pub rpdo_mappings: [StaticMapping; 4],
    /// Transmit PDO communication parameter
    #[object(0x1800.., record)]
    pub tpdos: [FixedPdo; 4],
    /// Transmit PDO mapping parameter
    #[object(0x1A00.., record)]
    pub tpdo_mappings: [StaticMapping; 4],
    /// Bytes that a slave keeps
    ///
    /// Of the last command by PDO 1, which may be shorter.
    #[object(0x6000, array, rwr, pdo)]
    pub kept: [u8; 8],
    /// State
    #[object(0x6001, record)]
    pub state: CyclicState,
    /// Telemetry
    #[object(0x6002, record)]
    pub telemetry: MinimalTelemetry,
    /// Bytes to be kept
    #[object(0x6200, array, rww, pdo)]
    pub command: [u8; 8],
    /// Command or telemetry request by PDO {}
    #[object(0x6201.., record)]
    pub messages: [MinimalMessage; 2],
    /// Request for the bytes that are kept
    ///
    /// They mean nothing.
    #[object(0x6203, array, rww, pdo)]
    pub request: [u8; 8],
}

/// Constant communication parameters of a PDO (ECSS Tables 9-3 to 9-6).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x20)]
pub struct FixedPdo {
    /// COB-ID
    ///
    /// With bit 31 the PDO is not in use.
    #[sub(1, ro)]
    pub cob_id: u32,
    /// Transmission type
    #[sub(2, ro)]
    pub transmission: u8,
}

/// Content of the PDO that follows a SYNC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct CyclicState {
    /// Commands executed
    #[sub(1, ro, pdo)]
    pub executed: u32,
    /// State of the LED
    #[sub(2, ro, pdo)]
    pub led: u8,
}

/// Content of the PDO that answers a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct MinimalTelemetry {
    /// Code
    #[sub(1, ro, pdo)]
    pub code: u16,
    /// Data
    #[sub(2, ro, pdo)]
    pub data: U48,
}

/// A command or a telemetry request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct MinimalMessage {
    /// Code
    #[sub(1, rww, pdo)]
    pub code: u16,
    /// Data
    ///
    /// A request may leave out some or all of it.
    #[sub(2, rww, pdo)]
    pub data: U48,
}

const _: () = assert_minimal::<MinimalObjects>(&MinimalMission::PDOS);

/// Bit of a PDO's COB-ID: not in use.
const NOT_IN_USE: u32 = 1 << 31;
const NO_REMOTE: u32 = 1 << 30;
/// Transmission type of an event-driven PDO.
const ON_EVENT: u8 = 254;

impl MinimalObjects {
    /// Returns the hard-coded values of node `id` with this profile.
    pub fn new(id: NodeId, profile: &Profile) -> MinimalObjects {
        let mut all = MinimalObjects::default();
        (all.consumer_heartbeat, all.producer_heartbeat) = consumer(id, profile);
        all.identity = identity(id);
        (all.rpdos, all.tpdos) = parameters(&MinimalMission::PDOS, id);
        let [first, second, third, fourth] = &mut all.rpdo_mappings;
        first.map(&bytes(Self::COMMAND.index()));
        second.map(&message(Self::MESSAGES.nth(0).index()));
        third.map(&message(Self::MESSAGES.nth(1).index()));
        fourth.map(&bytes(Self::REQUEST.index()));
        let [_, second, third, fourth] = &mut all.tpdo_mappings;
        let state = Self::STATE.index();
        second.map(&[mapped(state, 1, 32), mapped(state, 2, 8)]);
        third.map(&message(Self::TELEMETRY.index()));
        fourth.map(&bytes(Self::KEPT.index()));
        all
    }
}

/// Returns 1016h for the heartbeat of the master, and 1017h.
pub(super) fn consumer(id: NodeId, profile: &Profile) -> ([u32; 1], u16) {
    let milliseconds = |time: Duration| time.as_millis();
    let redundancy = profile.minimal_redundancy(id);
    let consumer = milliseconds(redundancy.consumer) as u32;
    ([u32::from(NodeId::MASTER.get()) << 16 | consumer], milliseconds(redundancy.producer) as u16)
}

pub(super) fn identity(id: NodeId) -> Identity {
    Identity { vendor: 0, product: 0x9015, revision: 1 << 16, serial: id.get().into() }
}

/// Returns the communication parameters of receive and transmit PDOs.
pub(super) fn parameters(pdos: &MinimalPdos, id: NodeId) -> ([FixedPdo; 4], [FixedPdo; 4]) {
    let sent = |pdo: MinimalTpdo| (pdo.cob_id.of(id), pdo.trigger.transmission_type());
    (
        pdos.receive.map(|pdo| fixed(pdo.map(|pdo| (pdo.cob_id.of(id), ON_EVENT)))),
        pdos.transmit.map(|pdo| fixed(pdo.map(sent))),
    )
}

fn fixed(pdo: Option<(CobId, u8)>) -> FixedPdo {
    match pdo {
        Some((cob_id, transmission)) => {
            FixedPdo { cob_id: NO_REMOTE | u32::from(cob_id.raw()), transmission }
        }
        None => FixedPdo { cob_id: NOT_IN_USE | NO_REMOTE, transmission: ON_EVENT },
    }
}

pub(super) const fn mapped(index: u16, sub: u8, bits: u8) -> u32 {
    (index as u32) << 16 | (sub as u32) << 8 | bits as u32
}

pub(super) fn bytes(index: u16) -> [u32; 8] {
    core::array::from_fn(|nth| mapped(index, nth as u8 + 1, 8))
}

pub(super) const fn message(index: u16) -> [u32; 2] {
    [mapped(index, 1, 16), mapped(index, 2, 48)]
}
