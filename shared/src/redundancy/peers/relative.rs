//! Shifts the clock of the peers, for the model checker.

use super::{MEMORY, Peer, Peers};
use crate::redundancy::Parameters;
use crate::types::{Duration, Instant, NodeId, Rebase};

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

impl<const N: usize> Peers<N> {
    /// Shifts the clock from `now`, when everything due was polled.
    pub(in crate::redundancy) fn rebase(&mut self, now: Instant, parameters: &Parameters) {
        let to = Rebase::new(now);
        self.check = self.check.map(|check| to.due(check));
        for node in (0..N).filter_map(|raw| NodeId::new(raw as u8)) {
            let memory = if self.counts(node) { Duration::ZERO } else { parameters.consumer.times(MEMORY) };
            let time = self.time(node, parameters.consumer);
            if let Some(Some(peer)) = self.places.get_mut(usize::from(node.get())) {
                peer.rebase(&to, time, memory, parameters);
            }
        }
    }
}
