//! Rules of a master that tests break on purpose.

use super::{MasterBoards, MasterRedundancy};
use crate::redundancy::{Broken, PeerHeartbeat};

impl<B: MasterBoards, const N: usize, const H: usize> MasterRedundancy<B, N, H> {
    /// Breaks a rule, for tests.
    pub fn break_rule(&mut self, broken: Option<Broken>) {
        self.manager.break_rule(broken);
        if let Some(standby) = self.boards.standby_mut() {
            standby.break_rule(broken);
        }
    }

    /// Returns whether this rule is broken.
    pub fn is_broken(&self, rule: Broken) -> bool {
        self.manager.is_broken(rule)
    }

    /// A slave that returns was not reset, where that rule is broken.
    pub(super) fn trusted(&self, heard: PeerHeartbeat) -> PeerHeartbeat {
        PeerHeartbeat { returned: heard.returned && !self.is_broken(Broken::TrustsStarted), ..heard }
    }
}
