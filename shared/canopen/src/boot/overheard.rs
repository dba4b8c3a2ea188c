//! A standby learns about the slaves of the active master.

use super::progress::Phase;
use super::record::{Duty, Run};
use super::{Boot, BootProgress};
use crate::types::{NmtState, NodeId};

impl Boot {
    /// Notes that another master is active. The knowledge of this one about its slaves is out of date when it
    /// takes over.
    pub fn stand_by(&mut self) {
        for node in (1..=127).filter_map(NodeId::new) {
            let Some(record) = self.records.get_mut(node).filter(|record| record.duty != Duty::None) else {
                continue;
            };
            record.is_silent = false;
            if record.duty == Duty::Excused {
                record.duty = Duty::Mandatory;
            }
            self.forget(node);
            self.set_progress(node, BootProgress::Awaited);
        }
        (self.deadline, self.failure, self.deviation, self.start) = (None, None, None, None);
        self.is_completed = false;
        self.phase = Phase::Configuring;
    }

    /// Takes a heartbeat or boot-up message of a slave while another master is active. That master started each
    /// slave that is Operational. After a takeover such a slave is not kept waiting, and its configuration is
    /// checked when it is heard.
    pub fn on_overheard(&mut self, node: NodeId, state: NmtState) {
        let Some(record) = self.records.get_mut(node).filter(|record| record.duty != Duty::None) else {
            return;
        };
        match state {
            NmtState::Operational => {
                (record.run, record.is_doubtful) = (record.run.max(Run::Started), true);
                self.is_changed = true;
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
