//! Shifts the clock of the redundancy of a master, for the model checker.

use super::{MasterBoards, MasterRedundancy};
use crate::types::{Instant, Rebase};

impl<B: MasterBoards, const N: usize, const H: usize> MasterRedundancy<B, N, H> {
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
