//! Assignment of the slaves: object 1F81h, and what the parts of the master take from it.

use super::Master;
use super::declared::MasterServices;
use crate::boot::machine::Assignment;
use crate::node::SpacecraftDevice;
use crate::redundancy::MasterBoards;
use crate::types::{Ecc, NodeId};

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Takes objects 1016h and 1F81h, before power-on and after "reset communication".
    pub(super) fn take_assignments(&mut self) {
        self.follow_consumers();
        self.note_assignments();
        (1..=127).filter_map(NodeId::new).for_each(|node| self.assign(node));
    }

    /// Takes the entry of a node, as it was written.
    pub(super) fn take_assignment(&mut self, node: NodeId) {
        self.note_assignments();
        self.assign(node);
    }

    fn note_assignments(&mut self) {
        self.assignments = Ecc::of(&self.services.network().assignment);
    }

    /// Corrects the entries by their code, and what the boot-up process and the redundancy took from them. Returns whether a bit
    /// was wrong.
    pub(super) fn compare_assignments(&mut self) -> bool {
        let entries = &mut self.services.network_mut().assignment;
        let mut is_wrong = self.assignments.correct(entries).unwrap_or_else(|_| {
            self.assignments = Ecc::of(entries);
            true
        });
        for node in (1..=127).filter_map(NodeId::new) {
            let assignment = self.assignment(node);
            let peers = self.redundancy.peers();
            if !self.boot.agrees(node, assignment) || !peers.agrees(node, assignment.is_slave()) {
                self.assign(node);
                is_wrong = true;
            }
        }
        is_wrong
    }

    fn assign(&mut self, node: NodeId) {
        let assignment = self.assignment(node);
        self.boot_mut().assign(node, assignment);
        self.redundancy_mut().peers_mut().assign(node, assignment.is_slave());
    }

    fn assignment(&self, node: NodeId) -> Assignment {
        let nth = usize::from(node.get()).wrapping_sub(1);
        Assignment::from_raw(self.services.network().assignment.get(nth).copied().unwrap_or(0))
    }
}
