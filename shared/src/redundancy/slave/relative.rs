//! Shifts the clock of a slave's redundancy, for the model checker.

use super::SlaveRedundancy;
use super::clash::PERIODS;
use crate::types::{Instant, PerBus, Rebase};

impl SlaveRedundancy {
    /// Shifts the clock from `now`, when everything due was polled. `received`: frames received on each bus. Returns the
    /// numbers of received frames to continue with.
    pub fn rebase(&mut self, received: PerBus<u32>, now: Instant) -> PerBus<u32> {
        let to = Rebase::new(now);
        let work = self.work(received);
        let pause = self.pause();
        self.guard.rebase(&to, pause);
        self.warning = self.warning.map(|end| to.due(end));
        // No heartbeat of the model is late.
        let (probation, quiet) = (self.probation(PERIODS), self.parameters().hold_off_time());
        self.clashes.rebase(&to, [probation, quiet]);
        self.control_frames = PerBus::default();
        self.selector.rebase(work, now)
    }
}
