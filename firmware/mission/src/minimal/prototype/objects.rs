//! The objects that the data sheet of the prototype's minimal slave shows (ECSS 9.2a). No node holds them.

use ecss_can::node::Identity;
use ecss_can::node::minimal::{MinimalDevice, assert_minimal};
use ecss_can::od::Objects;
use ecss_can::pdo::{Mapping, StaticMapping};
use ecss_can::profile::Profile;
use ecss_can::time::{ScetGet, ScetSet};
use ecss_can::types::NodeId;

use super::PrototypeMission;
use crate::minimal::objects::{
    FixedPdo, MinimalMessage, MinimalTelemetry, bytes, consumer, identity, mapped, message, parameters,
};

/// Objects of a minimal slave in profile `librecube`. All values are hard-coded.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct PrototypeObjects {
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
    ///
    /// The first is the Spacecraft Time PDO, and not that of Table 9-4 of the standard.
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
    /// Local SCET set
    #[object(0x2010, record)]
    pub scet_set: ScetSet,
    /// Local SCET get
    #[object(0x2011, record)]
    pub scet_get: ScetGet,
    /// Bytes that a slave keeps
    ///
    /// Of the last command by PDO 4, which may be shorter.
    #[object(0x6000, array, rwr, pdo)]
    pub kept: [u8; 8],
    /// Reply to a telemetry request
    #[object(0x6100, record)]
    pub telemetry: MinimalTelemetry,
    /// Command
    #[object(0x6200, record)]
    pub command: MinimalMessage,
    /// Telemetry request
    #[object(0x6201, record)]
    pub request: MinimalMessage,
    /// Bytes to be kept
    #[object(0x6203, array, rww, pdo)]
    pub keep: [u8; 8],
}

const _: () = assert_minimal::<PrototypeObjects>(&PrototypeMission::PDOS);

impl PrototypeObjects {
    /// Returns the hard-coded values of node `id` with this profile.
    pub fn new(id: NodeId, profile: &Profile) -> PrototypeObjects {
        let mut all = PrototypeObjects::default();
        (all.consumer_heartbeat, all.producer_heartbeat) = consumer(id, profile);
        all.identity = identity(id);
        (all.rpdos, all.tpdos) = parameters(&PrototypeMission::PDOS, id);
        let time = |index| [mapped(index, 2, 24), mapped(index, 1, 32)];
        let [first, second, third, fourth] = &mut all.rpdo_mappings;
        first.map(&time(Self::SCET_SET.index()));
        second.map(&message(Self::COMMAND.index()));
        third.map(&message(Self::REQUEST.index()));
        fourth.map(&bytes(Self::KEEP.index()));
        let [first, _, third, fourth] = &mut all.tpdo_mappings;
        first.map(&time(Self::SCET_GET.index()));
        third.map(&message(Self::TELEMETRY.index()));
        fourth.map(&bytes(Self::KEPT.index()));
        all
    }
}
