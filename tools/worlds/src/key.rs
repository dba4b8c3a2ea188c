//! Identification of the boards in a world.

use ecss_can::types::NodeId;

/// A board of a world, identified by its Node-ID. Two master boards share one; [`NodeKey::SECOND_MASTER`] is the other
/// one. Two slave boards with equal straps by mistake also share one: [`NodeKey::double`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeKey {
    node: NodeId,
    is_second: bool,
}

impl NodeKey {
    /// The first master board, or the only one.
    pub const MASTER: NodeKey = NodeKey { node: NodeId::MASTER, is_second: false };
    /// The other one of two master boards (ECSS 8.1a, Figure 4-2).
    pub const SECOND_MASTER: NodeKey = NodeKey { node: NodeId::MASTER, is_second: true };

    /// The only board with this Node-ID, or the first one.
    pub const fn of(node: NodeId) -> NodeKey {
        NodeKey { node, is_second: false }
    }

    /// A second slave board with this Node-ID.
    pub const fn double(node: NodeId) -> NodeKey {
        NodeKey { node, is_second: true }
    }

    /// Returns whether it is the second board with its Node-ID.
    pub const fn is_second(self) -> bool {
        self.is_second
    }

    /// Returns a number that is unique in a world.
    pub(crate) const fn number(self) -> u32 {
        2 * self.node.get() as u32 + self.is_second as u32
    }

    /// Its Node-ID.
    pub const fn node(self) -> NodeId {
        self.node
    }
}

impl From<NodeId> for NodeKey {
    fn from(node: NodeId) -> NodeKey {
        NodeKey::of(node)
    }
}
