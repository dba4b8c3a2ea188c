//! Stamps of heartbeats, from which the length of the cable to a slave is measured (objects 2016h and 2044h).

use super::Master;
use super::MasterServices;
use crate::link::Stamp;
use crate::node::Ranging;
use crate::node::SpacecraftDevice;
use crate::node::services::TimeServices;
use crate::redundancy::MasterBoards;
use crate::types::{Bus, CobId, NodeId};

/// Values of a slave whose cable is measured, in the master.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ranged {
    /// The active bus.
    pub bus: Bus,
    /// Local SCET at the end of the last heartbeat, units of 2^-32 s; zero before the first.
    pub heard: u64,
    /// Correction of the master's stamps on that bus, in nanoseconds.
    pub correction: i32,
}

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// A heartbeat whose end is of interest: of the slave in 2044h, or its own.
    pub(super) fn is_ranged(&self, id: CobId) -> bool {
        let of_slave = NodeId::new(self.ranging().node).is_some_and(|node| id == CobId::heartbeat(node));
        of_slave || self.services.time().is_ranged() && id == CobId::heartbeat(NodeId::MASTER)
    }

    /// A heartbeat of a slave on the active bus.
    pub(super) fn on_ranged(&mut self, node: NodeId, stamp: &Stamp) {
        if node.get() == self.ranging().node {
            let heard = self.services.time().clock().at(stamp.fine()).units();
            self.services.network_mut().ranging.heard = heard;
        }
    }

    /// Ends the measurement: 2044h names no slave.
    pub(crate) fn stop_ranging(&mut self) {
        let ranging = &mut self.services.network_mut().ranging;
        (ranging.node, ranging.heard) = (0, 0);
    }

    fn ranging(&self) -> &Ranging {
        &self.services.network().ranging
    }

    /// Returns the values of the slave in 2044h.
    pub(crate) fn ranged(&self) -> Ranged {
        let bus = self.redundancy.active();
        let correction = self.services.objects().extension.correction();
        Ranged { bus, heard: self.ranging().heard, correction: correction.of(bus).unwrap_or(0) }
    }
}
