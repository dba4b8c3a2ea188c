//! Relative to now, for the model checker.

use super::{MEMORY, Peer, Peers};
use crate::redundancy::{Broken, Parameters};
use crate::types::{Duration, Instant, Rebase};

impl Peer {
    fn rebase(&mut self, to: &Rebase, time: Duration, memory: Duration, parameters: &Parameters) {
        let hold = parameters.hold_time();
        self.heartbeat.rebase(to, time, memory);
        // Its age counts together with that of the first heartbeat on the other bus only.
        let is_elsewhere = self.first_there < Instant::NEVER;
        self.silent_at = to.aged(self.silent_at, if is_elsewhere { hold } else { Duration::ZERO });
        self.first_there = to.aged(self.first_there, hold);
        self.last_there = to.aged(self.last_there, hold);
    }
}

/// Slaves that somebody else stopped stay so, where that rule is broken.
pub(super) fn leaves_stopped(broken: Option<Broken>) -> bool {
    broken == Some(Broken::LeavesStopped)
}

impl<const N: usize> Peers<N> {
    /// Shifts the clock from `now`, when everything due was polled.
    pub(in crate::redundancy) fn rebase(&mut self, now: Instant, parameters: &Parameters) {
        let to = Rebase::new(now);
        self.check = self.check.map(|check| to.due(check));
        let counted = self.counted();
        for (raw, (place, time)) in self.places.iter_mut().zip(&self.times).enumerate() {
            let is_stranger = counted & (1 << raw) == 0;
            let memory = if is_stranger { parameters.consumer.times(MEMORY) } else { Duration::ZERO };
            if let Some(peer) = place {
                peer.rebase(&to, super::own_time(*time, parameters.consumer), memory, parameters);
            }
        }
    }
}
