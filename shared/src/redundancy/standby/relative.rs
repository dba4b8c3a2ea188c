//! Shifts the clock of the standby, for the model checker.

use super::{Encounter, Standby};
use crate::types::{Instant, Rebase};

impl Standby {
    /// Shifts the clock from `now`, when everything due was polled.
    pub fn rebase(&mut self, now: Instant) {
        let (to, consumer) = (Rebase::new(now), self.pair.consumer);
        self.until = if self.is_active() { Instant::NEVER } else { to.due(self.until) };
        let encounter = self.encounter.filter(|encounter| now < encounter.last + consumer);
        self.encounter = encounter.map(|encounter| Encounter {
            last: to.aged(encounter.last, consumer),
            pause: to.due(encounter.pause),
            ..encounter
        });
    }
}
