//! Rules that tests break on purpose.

use super::Master;
use crate::nmt::Target;
use crate::node::Device;
use crate::redundancy::{Broken, MasterBoards};
use crate::types::NodeId;

impl<D: Device, B: MasterBoards> Master<D, B> {
    /// Breaks a rule, for tests.
    pub fn break_rule(&mut self, broken: Option<Broken>) {
        self.redundancy.break_rule(broken);
    }

    /// A slave that waits is explained, where that rule is broken.
    pub(super) fn trust(&mut self, node: NodeId) {
        if self.redundancy.is_broken(Broken::TrustsStarted) {
            self.boot.on_commanded(Target::Node(node));
        }
    }
}
