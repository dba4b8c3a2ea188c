//! COB-IDs: 11-bit CAN identifiers and their pre-defined ranges (CiA 301 7.3.3).

use crate::nmt::NodeId;

/// A communication object identifier, `000h..=7FFh`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CobId(u16);

impl CobId {
    /// NMT module control.
    pub const NMT: CobId = CobId(0x000);
    /// SYNC object.
    pub const SYNC: CobId = CobId(0x080);

    /// `None` above 7FFh.
    pub const fn new(raw: u16) -> Option<CobId> {
        if raw <= 0x7FF { Some(CobId(raw)) } else { None }
    }

    const fn with_node(base: u16, node: NodeId) -> CobId {
        CobId(base + node.get() as u16)
    }

    /// EMCY of a node: 080h + node.
    pub const fn emcy(node: NodeId) -> CobId {
        Self::with_node(0x080, node)
    }

    /// TPDO1 of a node, 180h + node: the Local Time PDO; that of the master is the Spacecraft Time PDO.
    pub const fn local_time(node: NodeId) -> CobId {
        Self::with_node(0x180, node)
    }

    /// Unconfirmed command to a slave: RPDO2, 300h + node.
    pub const fn telecommand(node: NodeId) -> CobId {
        Self::with_node(0x300, node)
    }

    /// Telemetry from a slave: TPDO3, 380h + node.
    pub const fn telemetry(node: NodeId) -> CobId {
        Self::with_node(0x380, node)
    }

    /// Telemetry request to a slave: RPDO3, 400h + node.
    pub const fn telemetry_request(node: NodeId) -> CobId {
        Self::with_node(0x400, node)
    }

    /// NMT error control (heartbeat and boot-up) of a node: 700h + node.
    pub const fn heartbeat(node: NodeId) -> CobId {
        Self::with_node(0x700, node)
    }

    /// The identifier as it stands in the arbitration field, `0..=0x7FF`.
    pub const fn raw(self) -> u16 {
        self.0
    }

    /// The node in the low seven bits, `None` for node 0 (broadcast objects).
    pub const fn node(self) -> Option<NodeId> {
        NodeId::new((self.0 & 0x7F) as u8)
    }

    /// The function code in the upper four bits, as the base identifier (`080h`, `180h`, .. `700h`).
    pub const fn function(self) -> u16 {
        self.0 & 0x780
    }
}
