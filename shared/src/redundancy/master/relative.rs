//! Shifts the clock of the redundancy of a master, for the model checker.

use super::{MasterBoards, MasterRedundancy};
use crate::redundancy::{Broken, PeerHeartbeat};
use crate::types::{Instant, Rebase};

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

    /// Shifts the clock from `now`, when everything due was polled.
    pub fn rebase(&mut self, now: Instant) {
        let to = Rebase::new(now);
        self.manager.rebase(now);
        if let Some(standby) = self.boards.standby_mut() {
            standby.rebase(now);
        }
        self.rivals.rebase(&to, self.manager.parameters().quiet_time());
        self.held.frames.iter_mut().for_each(|outgoing| outgoing.expires = to.due(outgoing.expires));
    }
}
