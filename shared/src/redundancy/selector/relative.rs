//! Shifts the clock of the selector, for the model checker.

use super::{Phase, Selector};
use crate::types::{Instant, PerBus, Rebase};

impl Selector {
    /// Shifts the clock from `now`, when everything due was polled. `frames`: as for [`Selector::on_work`].
    /// Returns the counts to continue with.
    pub fn rebase(&mut self, frames: PerBus<u32>, now: Instant) -> PerBus<u32> {
        let (to, parameters) = (Rebase::new(now), self.parameters);
        // Later than that, a switch that is overdue does not count from its time.
        let late = parameters.toggling_time().times(2);
        match &mut self.phase {
            Phase::Following { last } => {
                *last = to.aged(*last, parameters.consumer);
                // Shows the last search, decides nothing.
                self.parameters.ctoggle = 0;
            }
            Phase::Unconfirmed { until, search, .. } => {
                *until = to.due(*until);
                search.since = search.since.map(|since| to.aged(since, late));
            }
            Phase::Searching(search) => {
                search.since = search.since.map(|since| to.aged(since, late));
            }
        }
        self.rhythm.rebase();
        self.moved = self.moved.and_then(|moved| moved.rebased(&to, &parameters, now));
        self.hold_off = self.hold_off.map(|until| to.due(until));
        self.keep = self.keep.map(|(at, bus)| (to.due(at), bus));
        self.on_work(frames);
        if self.moved.is_none() && self.hold_off.is_none() {
            // The next move looks at what comes after it.
            self.work.restart(now);
        }
        self.work.rebase(&to, parameters.consumer.max(parameters.producer).times(2));
        self.work.frames
    }
}
