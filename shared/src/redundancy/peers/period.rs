//! Consumer time of each node.
//!
//! A node that neither 1F81h nor 1016h names may have a heartbeat period longer than the common consumer time. The master
//! observes that period: the node is lost after two of its periods, not between two of its heartbeats.

use super::remote::{MEMORY, Remote, RemoteTimes};
use super::{Parameters, Peers};
use crate::heartbeat::machine::ConsumerTimes;
use crate::types::{Duration, Instant};

impl Remote {
    /// Notes the heartbeat period of the node at its heartbeat, unless it is assigned.
    pub(super) fn observe(&mut self, at: Instant, consumer: Duration) {
        let is_assigned = self.is_assigned();
        let Some(heard) = &mut self.heard else { return };
        let last = heard.heartbeat.last().filter(|_| !is_assigned);
        let gap = last.map_or(Duration::ZERO, |last| at.since(last));
        let is_long = consumer > Duration::ZERO && gap > consumer;
        heard.period = if is_long { gap.as_millis().min(u64::from(u16::MAX)) as u16 } else { 0 };
    }

    /// The consumer time of the node: its own of 1016h, else two of its observed periods, else the common one. A foreign node
    /// is lost before it is forgotten.
    pub(super) fn time(&self, consumer: Duration) -> Duration {
        let of = |milliseconds: u16| Duration::from_millis(u64::from(milliseconds));
        let (own, period) = (of(self.time), of(self.heard.as_ref().map_or(0, |heard| heard.period)));
        match () {
            () if own > Duration::ZERO => own,
            () if period == Duration::ZERO => consumer,
            () if self.counts() => period.times(2),
            () => period.times(2).min(consumer.times(MEMORY)),
        }
    }
}

impl<const N: usize> Peers<N> {
    /// Times for which what is noted of the node with Node-ID `raw` has an effect. Of a miss it has one on nodes
    /// alone that may be forgotten.
    pub(super) fn times_of(&self, raw: usize, parameters: &Parameters) -> RemoteTimes {
        let remote = self.remotes.get(raw).unwrap_or(&Remote::UNKNOWN);
        let common = parameters.consumer;
        let memory = if remote.is_forgettable() { common.times(MEMORY) } else { Duration::ZERO };
        let heartbeat = ConsumerTimes { consumer: remote.time(common), memory };
        RemoteTimes { heartbeat, hold: parameters.hold_time() }
    }
}
