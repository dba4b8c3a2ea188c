//! Consumer time of each node.
//!
//! A node that neither 1F81h nor 1016h names may have a heartbeat period longer than the common consumer time. The master
//! observes that period: the node is lost after two of its periods, not between two of its heartbeats.

use super::{MEMORY, Parameters, PeerTimes, Peers, node_bit};
use crate::heartbeat::ConsumerTimes;
use crate::types::{Duration, Instant, NodeId};

impl<const N: usize> Peers<N> {
    /// Notes the heartbeat period of a node at its heartbeat, unless it is assigned.
    pub(super) fn observe(&mut self, node: NodeId, at: Instant, consumer: Duration) {
        let is_assigned = self.assigned & node_bit(node) != 0;
        let last = self.place(node).filter(|_| !is_assigned).and_then(|peer| peer.heartbeat.last());
        let gap = last.map_or(Duration::ZERO, |last| at.since(last));
        let is_long = consumer > Duration::ZERO && gap > consumer;
        if let Some(period) = self.periods.get_mut(usize::from(node.get())) {
            *period = if is_long { gap.as_millis().min(u64::from(u16::MAX)) as u16 } else { 0 };
        }
    }

    /// The consumer time of a node: its own of 1016h, else two of its observed periods, else the common one. A foreign node is
    /// lost before it is forgotten.
    pub(super) fn time(&self, node: NodeId, consumer: Duration) -> Duration {
        let of = |array: &[u16; N]| {
            let milliseconds = array.get(usize::from(node.get())).copied().unwrap_or(0);
            Duration::from_millis(u64::from(milliseconds))
        };
        let (own, period) = (of(&self.times), of(&self.periods));
        match () {
            () if own > Duration::ZERO => own,
            () if period == Duration::ZERO => consumer,
            () if self.counts(node) => period.times(2),
            () => period.times(2).min(consumer.times(MEMORY)),
        }
    }

    /// Times for which what is noted of the node with Node-ID `raw` has an effect. Of a miss it has one on nodes
    /// alone that may be forgotten.
    pub(super) fn times_of(&self, raw: usize, parameters: &Parameters) -> PeerTimes {
        let node = NodeId::new(raw as u8);
        let common = parameters.consumer;
        let is_forgettable = node.is_none_or(|node| self.is_forgettable(node));
        let memory = if is_forgettable { common.times(MEMORY) } else { Duration::ZERO };
        let consumer = node.map_or(common, |node| self.time(node, common));
        PeerTimes { heartbeat: ConsumerTimes { consumer, memory }, hold: parameters.hold_time() }
    }
}
