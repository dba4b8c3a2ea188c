//! The boot process of the model: a slave is checked by SDO before the master starts it.

use ecss_can::types::{NmtState, NodeId};

/// Slaves that are not checked since their last boot, a bit for each Node-ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BootProcess {
    is_used: bool,
    unchecked: u8,
}

impl BootProcess {
    /// Makes the process of a master before power-on: no slave is checked. Without `is_used` no check is needed.
    pub fn new(is_used: bool) -> Self {
        BootProcess { is_used, unchecked: if is_used { u8::MAX } else { 0 } }
    }

    /// Handles a heartbeat. `has_returned`: the slave was lost before. Returns whether the slave may start.
    pub fn may_start(&mut self, node: NodeId, state: NmtState, has_returned: bool) -> bool {
        if self.is_used && (state == NmtState::Initialising || has_returned) {
            self.unchecked |= bit(node);
        }
        self.unchecked & bit(node) == 0
    }

    /// Returns whether to ask a slave in this state.
    pub fn asks(&self, node: NodeId, state: NmtState) -> bool {
        self.unchecked & bit(node) != 0 && state.allows_sdo()
    }

    /// Handles an answer of a slave.
    pub fn on_answer(&mut self, node: NodeId) {
        self.unchecked &= !bit(node);
    }
}

fn bit(node: NodeId) -> u8 {
    1 << node.get()
}
