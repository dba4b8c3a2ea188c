//! COB-IDs of PDOs, for a device whose Node-ID is not known when it is built.

use crate::od::Reason;
use crate::types::{CobId, NodeId};

/// COB-ID of a PDO: the same in every node, or a base to which the Node-ID is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CobIdOf {
    base: u16,
    with_node: bool,
}

/// EMCY of the node itself.
pub(super) const OWN_EMCY: CobIdOf = CobIdOf { base: 0x080, with_node: true };

/// Highest Node-ID.
const NODES: u16 = 127;

impl CobIdOf {
    /// Makes a COB-ID that is the same in every node, such as 181h for the time of the master.
    ///
    /// # Panics
    /// For a restricted COB-ID (CiA 301 7.3.5) and that of SYNC. In a constant this is a compile
    /// error.
    #[track_caller]
    pub const fn fixed(raw: u16) -> CobIdOf {
        assert_allowed(raw);
        CobIdOf { base: raw, with_node: false }
    }

    /// Makes the COB-ID `base` + Node-ID.
    ///
    /// # Panics
    /// If the result is a restricted COB-ID for any node of 1 to 127. In a constant this is a compile error.
    #[track_caller]
    pub const fn node(base: u16) -> CobIdOf {
        let mut node = 1;
        while node <= NODES {
            assert_allowed(base.saturating_add(node));
            node += 1;
        }
        CobIdOf { base, with_node: true }
    }

    /// Returns the COB-ID in a node.
    pub const fn of(self, node: NodeId) -> CobId {
        CobId::low_bits(if self.with_node { self.base as u32 + node.get() as u32 } else { self.base as u32 })
    }

    /// Returns this COB-ID, the same in every node.
    pub(super) const fn of_node(id: CobId) -> CobIdOf {
        CobIdOf { base: id.raw(), with_node: false }
    }

    /// Returns the node whose COB-ID the other one is.
    pub(super) const fn node_of(self, other: CobIdOf) -> Option<NodeId> {
        if !self.with_node || other.with_node {
            return None;
        }
        match other.base.checked_sub(self.base) {
            Some(node) if node <= NODES => NodeId::new(node as u8),
            _ => None,
        }
    }

    /// Returns whether both are one COB-ID in some node.
    pub const fn may_equal(self, other: CobIdOf) -> bool {
        let apart = self.base.abs_diff(other.base);
        match (self.with_node, other.with_node) {
            (true, false) => other.base > self.base && apart <= NODES,
            (false, true) => self.base > other.base && apart <= NODES,
            (true, true) | (false, false) => apart == 0,
        }
    }

    /// Begins a text.
    pub(super) const fn tell(self) -> Reason {
        let id = Reason::new("COB-ID ").hex(self.base, 3);
        if self.with_node { id.text(" + node") } else { id }
    }
}

#[track_caller]
const fn assert_allowed(raw: u16) {
    let is_allowed = match CobId::new(raw) {
        Some(id) => !id.is_restricted() && raw != CobId::SYNC.raw(),
        None => false,
    };
    if !is_allowed {
        let id = Reason::new("COB-ID ").hex(raw, if raw > 0xFFF { 4 } else { 3 });
        id.text(" is not for PDOs: allowed are 081h to 100h, 181h to 580h, 600h, 680h to 6DFh and 700h")
            .refuse();
    }
}
