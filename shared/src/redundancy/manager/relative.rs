//! Shifts the clock of the manager, for the model checker.

use super::Manager;
use crate::types::{Instant, Rebase};

impl<const N: usize> Manager<N> {
    /// Shifts the clock from `now`, when everything due was polled.
    pub fn rebase(&mut self, now: Instant) {
        let (to, parameters) = (Rebase::new(now), self.parameters);
        self.heartbeat.rebase(&to);
        self.peers.rebase(now, &parameters);
        self.guard = to.due(self.guard);
        self.alone_since = self.alone_since.map(|since| to.aged(since, self.grace));
        self.search.rebase(&to, &mut self.parameters);
        self.trial.rebase(&to);
        self.report = self.report.map(|at| to.due(at));
    }
}
