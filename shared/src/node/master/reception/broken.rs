//! Rules that tests break on purpose.

use crate::nmt::Target;
use crate::node::Device;
use crate::node::master::Master;
use crate::node::master::boards::MasterBoards;
use crate::redundancy::{Broken, PeerHeartbeat};
use crate::types::NodeId;

impl<D: Device, B: MasterBoards> Master<D, B> {
    /// Breaks a rule, for tests.
    pub fn break_rule(&mut self, broken: Option<Broken>) {
        self.manager.break_rule(broken);
        if let Some(standby) = self.boards.standby_mut() {
            standby.break_rule(broken);
        }
    }

    /// A slave that waits is explained, where that rule is broken.
    pub(in crate::node::master) fn trusted(&mut self, node: NodeId, heard: PeerHeartbeat) -> PeerHeartbeat {
        if !self.manager.is_broken(Broken::TrustsStarted) {
            return heard;
        }
        self.boot.on_commanded(Target::Node(node));
        PeerHeartbeat { returned: false, ..heard }
    }
}
