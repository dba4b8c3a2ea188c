//! Shifts the clock of the hold-off, for the model checker.

use super::{Move, Rhythm, UNDER_WAY, Work};
use crate::redundancy::Parameters;
use crate::types::{Duration, Instant, PerBus, Rebase};

impl Rhythm {
    /// Makes records equal that will always have the same patience.
    pub fn rebase(&mut self) {
        // Oldest first; one that is shorter than a later one is forgotten before it and never counts.
        self.gaps.rotate_left(usize::from(self.count & 3));
        self.count = 0;
        let mut longest = 0;
        for gap in self.gaps.iter_mut().rev() {
            longest = longest.max(*gap);
            *gap = longest;
        }
    }
}

impl Move {
    /// Shifts the clock. `None`: the move can neither be taken back nor be contradicted any more.
    pub fn rebased(mut self, to: &Rebase, parameters: &Parameters, now: Instant) -> Option<Move> {
        if !self.is_open(now, parameters) && !self.was_under_way(now) {
            return None;
        }
        self.rhythm.rebase();
        let horizon = self.rhythm.patience(parameters).max(UNDER_WAY);
        (self.at, self.last) =
            (to.aged(self.at, horizon), to.aged(self.last, Duration::from_micros(u64::MAX)));
        Some(self)
    }
}

impl Work {
    /// Shifts the clock. Keeps only whether there was work on each bus.
    pub fn rebase(&mut self, to: &Rebase, patience: Duration) {
        let frames = PerBus::from_fn(|bus| u32::from(self.frames[bus] != self.before[bus]));
        (self.frames, self.before) = (frames, PerBus::default());
        self.since = to.aged(self.since, patience);
    }
}
