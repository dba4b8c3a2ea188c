//! COB-IDs that the nodes of a network send: no two nodes may send the same one (ECSS 6.10l, m).

use heapless::Vec;

use crate::types::{CobId, NodeId};

/// COB-IDs that the table holds: nine each of 28 nodes.
const CAPACITY: usize = 256;

/// COB-IDs with the node that sends them, as the boot-up process read them.
#[derive(Clone, Debug)]
pub(super) struct Senders {
    sent: Vec<(CobId, NodeId), CAPACITY>,
}

/// Reason why a COB-ID was not taken into the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refused {
    /// This node sends it as well.
    SentBy(NodeId),
    /// The table is full.
    Full,
}

impl Senders {
    pub const fn new() -> Senders {
        Senders { sent: Vec::new() }
    }

    /// Removes the COB-IDs of a node.
    pub fn forget(&mut self, node: NodeId) {
        self.sent.retain(|(_, sender)| *sender != node);
    }

    /// Notes that `node` sends `id`.
    pub fn add(&mut self, id: CobId, node: NodeId) -> Result<(), Refused> {
        match self.sent.iter().find(|(sent, _)| *sent == id) {
            Some((_, sender)) if *sender == node => Ok(()),
            Some((_, sender)) => Err(Refused::SentBy(*sender)),
            None => self.sent.push((id, node)).map_err(|_| Refused::Full),
        }
    }
}
