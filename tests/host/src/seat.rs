//! Who is who in a world.

use ecss_can::types::NodeId;

/// A board of a world: by its Node-ID. Two master boards share theirs, [`Seat::SECOND_MASTER`] is the other one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Seat {
    node: NodeId,
    is_second: bool,
}

impl Seat {
    /// The first master board, or the only one.
    pub const MASTER: Seat = Seat { node: NodeId::MASTER, is_second: false };
    /// The other one of two master boards (ECSS 8.1a, Figure 4-2).
    pub const SECOND_MASTER: Seat = Seat { node: NodeId::MASTER, is_second: true };

    /// Its Node-ID.
    pub const fn node(self) -> NodeId {
        self.node
    }
}

impl From<NodeId> for Seat {
    fn from(node: NodeId) -> Seat {
        Seat { node, is_second: false }
    }
}
