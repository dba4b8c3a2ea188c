//! Stamps of heartbeats, from which the length of the cable to a slave is measured (objects 2016h and 2044h).

use easy_ext::ext;

use super::{MasterObjects, MasterServices};
use crate::link::Stamp;
use crate::node::SpacecraftDevice;
use crate::node::services::{Services, TimeServices};
use crate::types::{CobId, NodeId};

#[ext(RangingServices)]
impl<D: SpacecraftDevice> Services<MasterObjects<D>> {
    /// Returns whether the end of a heartbeat is needed: of the slave in 2044h, or of this node.
    pub fn is_ranged(&self, id: CobId) -> bool {
        let slave = NodeId::new(self.network().ranging.node);
        slave.is_some_and(|node| id == CobId::heartbeat(node))
            || self.time().is_ranged() && id == CobId::heartbeat(NodeId::MASTER)
    }

    /// Takes a heartbeat of a slave on the active bus.
    pub fn on_ranged(&mut self, node: NodeId, stamp: &Stamp) {
        if node.get() == self.network().ranging.node {
            let heard = self.time().clock().at(stamp.fine()).units();
            self.network_mut().ranging.heard = heard;
        }
    }
}
