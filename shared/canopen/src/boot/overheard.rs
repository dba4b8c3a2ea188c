//! A standby learns about the slaves of the active master.

use super::BootProgress;
use super::progress::Phase;
use super::{Boot, bit, first};
use crate::types::{NmtState, NodeId};

impl Boot {
    /// Notes that another master is active. The knowledge of this one about its slaves is out of date when it
    /// takes over.
    pub fn stand_by(&mut self) {
        let mut rest = self.assigned;
        while let Some(node) = first(rest) {
            rest &= !bit(node);
            self.forget(node);
            self.set_progress(node, BootProgress::Awaited);
        }
        (self.deadline, self.failure, self.deviation, self.start) = (None, None, None, None);
        self.is_completed = false;
        (self.silent, self.excused, self.phase) = (0, 0, Phase::Configuring);
    }

    /// Takes a heartbeat or boot-up message of a slave while another master is active. That master started each
    /// slave that is Operational. After a takeover such a slave is not kept waiting, and its configuration is
    /// checked when it is heard.
    pub fn on_overheard(&mut self, node: NodeId, state: NmtState) {
        let bit = bit(node);
        if self.assigned & bit == 0 {
            return;
        }
        match state {
            NmtState::Operational => {
                (self.started, self.doubtful) = (self.started | bit, self.doubtful | bit)
            }
            NmtState::Initialising => self.forget(node),
            NmtState::PreOperational | NmtState::Stopped => {}
        }
    }

    /// Takes a SYNC of another active master: that master no longer waits for any slave.
    pub fn on_sync_overheard(&mut self) {
        if self.phase == Phase::Configuring {
            self.phase = Phase::Released;
        }
    }
}
