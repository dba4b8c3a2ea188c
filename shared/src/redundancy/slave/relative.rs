//! Shifts the clock of a slave's redundancy, for the model checker.

use super::SlaveRedundancy;
use crate::nmt::ClashWatch;
use crate::redundancy::Broken;
use crate::types::{Instant, PerBus, Rebase};

impl SlaveRedundancy {
    /// Breaks a rule, for tests.
    pub fn break_rule(&mut self, broken: Option<Broken>) {
        self.selector.break_rule(broken);
    }

    /// Shifts the clock from `now`, when everything due was polled. `received`: as of [`SlaveNode::received`]. Returns the
    /// numbers of received frames to continue with.
    pub fn rebase(&mut self, received: PerBus<u32>, now: Instant) -> PerBus<u32> {
        let to = Rebase::new(now);
        let work = self.work(received);
        let pause = self.pause();
        self.guard.rebase(&to, pause);
        self.warning = self.warning.map(|end| to.due(end));
        // No other node of the model has this Node-ID.
        self.clashes = ClashWatch::new();
        self.control_frames = PerBus::default();
        self.selector.rebase(work, now)
    }
}
