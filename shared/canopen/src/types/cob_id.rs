//! COB-IDs: 11-bit CAN identifiers, their pre-defined and restricted ranges.
//!
//! CiA 301 7.3.3 (pre-defined connection set) and 7.3.5 (restricted CAN-IDs).

use crate::types::NodeId;

/// Communication object identifier, `000h..=7FFh`.
#[doc(alias("COB-ID", "CAN-ID", "pre-defined connection set"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CobId(u16);

impl CobId {
    /// COB-ID of NMT module control.
    pub const NMT: CobId = CobId(0x000);
    /// Default COB-ID of SYNC, 080h.
    pub const SYNC: CobId = CobId(0x080);

    /// Makes a COB-ID. `None` above 7FFh.
    pub const fn new(raw: u16) -> Option<CobId> {
        if raw <= 0x7FF { Some(CobId(raw)) } else { None }
    }

    /// The low eleven bits.
    pub(crate) const fn low_bits(raw: u32) -> CobId {
        CobId((raw & 0x7FF) as u16)
    }

    const fn with_node(base: u16, node: NodeId) -> CobId {
        CobId(base + node.get() as u16)
    }

    /// Returns the COB-ID of the EMCY of a node: 080h + node.
    pub const fn emcy(node: NodeId) -> CobId {
        Self::with_node(0x080, node)
    }

    /// Returns the COB-ID of TPDO 1 to 4 of a node: 180h, 280h, 380h, 480h + node. `None` for others, which have
    /// no pre-defined COB-ID.
    pub const fn tpdo(number: u16, node: NodeId) -> Option<CobId> {
        match number {
            1..=4 => Some(Self::with_node(0x080 + 0x100 * number, node)),
            _ => None,
        }
    }

    /// Returns the COB-ID of RPDO 1 to 4 of a node: 200h, 300h, 400h, 500h + node. `None` for others, which have
    /// no pre-defined COB-ID.
    pub const fn rpdo(number: u16, node: NodeId) -> Option<CobId> {
        match number {
            1..=4 => Some(Self::with_node(0x100 + 0x100 * number, node)),
            _ => None,
        }
    }

    /// Returns the COB-ID of SDO from the server in a node to its client: 580h + node.
    pub const fn sdo_response(node: NodeId) -> CobId {
        Self::with_node(0x580, node)
    }

    /// Returns the COB-ID of the answer to SDO requests with this one: 080h below it.
    pub(crate) const fn sdo_answer(self) -> CobId {
        CobId(self.0.saturating_sub(0x080))
    }

    /// Returns the COB-ID of SDO from a client to the server in a node: 600h + node.
    pub const fn sdo_request(node: NodeId) -> CobId {
        Self::with_node(0x600, node)
    }

    /// Returns the COB-ID of NMT error control (heartbeat and boot-up) of a node: 700h + node.
    pub const fn heartbeat(node: NodeId) -> CobId {
        Self::with_node(0x700, node)
    }

    /// Returns the identifier in the arbitration field, `0..=0x7FF`.
    pub const fn raw(self) -> u16 {
        self.0
    }

    /// Returns the node in the low seven bits. `None` for node 0 (broadcast objects).
    pub const fn node(self) -> Option<NodeId> {
        NodeId::new((self.0 & 0x7F) as u8)
    }

    /// Returns the node that sends this COB-ID in the pre-defined connection set, if it is an emergency or a
    /// TPDO.
    pub(crate) const fn sender(self) -> Option<NodeId> {
        match self.function() {
            0x080 | 0x180 | 0x280 | 0x380 | 0x480 => self.node(),
            _ => None,
        }
    }

    /// Returns the function code in the upper four bits, as the base identifier (`080h`, `180h`, .. `700h`).
    pub const fn function(self) -> u16 {
        self.0 & 0x780
    }

    /// Returns whether CANopen reserves it for one purpose, so that no configurable object may use it.
    pub const fn is_restricted(self) -> bool {
        matches!(
            self.0,
            0x000..=0x07F | 0x101..=0x180 | 0x581..=0x5FF | 0x601..=0x67F | 0x6E0..=0x6FF | 0x701..
        )
    }
}
