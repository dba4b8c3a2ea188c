//! COB-IDs that the slaves of a network send: no two nodes may send the same one.

use heapless::Vec;

use super::{BootCause, PLACES};
use crate::types::{Address, CobId, NodeId};

/// COB-IDs outside the pre-defined connection set that the table holds.
const CAPACITY: usize = 64;

/// COB-IDs that the boot-up process read, with the slaves that send them.
#[derive(Clone, Debug)]
pub(super) struct Senders {
    /// For each node the functions of the pre-defined connection set that it sends with its own Node-ID: bit 0 is its
    /// emergencies, bits 1 to 4 are its TPDOs 1 to 4.
    own: [u8; PLACES],
    others: Vec<(CobId, NodeId), CAPACITY>,
}

impl Senders {
    pub const fn new() -> Senders {
        Senders { own: [0; PLACES], others: Vec::new() }
    }

    /// Removes the COB-IDs of a node.
    pub fn forget(&mut self, node: NodeId) {
        if let Some(functions) = self.own.get_mut(usize::from(node.get())) {
            *functions = 0;
        }
        self.others.retain(|(_, sender)| *sender != node);
    }

    /// Notes that `node` sends `id`, as its object `at` says.
    ///
    /// # Errors
    /// [`BootCause::CobIdInUse`] if another slave sends it. [`BootCause::TooManyCobIds`] if the table is full.
    pub fn add(&mut self, at: Address, id: CobId, node: NodeId) -> Result<(), BootCause> {
        if let Some((_, other)) = self.others.iter().find(|(other, _)| *other == id) {
            return if *other == node {
                Ok(())
            } else {
                Err(BootCause::CobIdInUse { at, id, other: *other })
            };
        }
        if let Some(other) = id.sender()
            && let Some(functions) = self.own.get_mut(usize::from(other.get()))
        {
            let function = 1 << (id.function() >> 8);
            if other == node {
                *functions |= function;
                return Ok(());
            }
            if *functions & function != 0 {
                return Err(BootCause::CobIdInUse { at, id, other });
            }
        }
        self.others.push((id, node)).map_err(|_| BootCause::TooManyCobIds)
    }
}
