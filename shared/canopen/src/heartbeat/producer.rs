//! Producer of one node's heartbeat (object 1017h).

use super::encode;
use crate::types::{Canonical, Duration, Frame, Instant, NmtState, NodeId, Periodic};

/// Produces the heartbeat of a node (1017h).
#[doc(alias("1017h", "producer heartbeat time", "heartbeat producer"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Producer {
    node: NodeId,
    running: bool,
    timer: Periodic,
}

impl Producer {
    /// Makes a producer that is silent until [`Producer::announce`] or [`Producer::restart`]. With a period of
    /// zero it stays silent.
    pub const fn new(node: NodeId, period: Duration) -> Self {
        Producer { node, running: false, timer: Periodic::new(period) }
    }

    /// Returns the Node-ID of the heartbeats.
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// Sets the Node-ID of the heartbeats.
    pub(crate) const fn set_node(&mut self, node: NodeId) {
        self.node = node;
    }

    /// Makes the next heartbeat due at once.
    pub fn announce(&mut self, now: Instant) {
        self.running = true;
        self.timer.start(now);
    }

    /// Makes the next heartbeat due a period from `now`, after a heartbeat or boot-up message was sent.
    pub fn restart(&mut self, now: Instant) {
        self.running = true;
        self.timer.restart(now);
    }

    /// Stops the heartbeats.
    pub fn stop(&mut self) {
        self.running = false;
        self.timer.stop();
    }

    /// Takes a new period, zero for none. If the producer runs, a heartbeat is due at once. So no consumer waits
    /// longer than the old or the new period.
    pub fn set_period(&mut self, period: Duration, now: Instant) {
        self.timer = Periodic::new(period);
        if self.running {
            self.timer.start(now);
        }
    }

    /// Returns the heartbeat when it is due.
    pub fn poll(&mut self, now: Instant, state: NmtState) -> Option<Frame> {
        // A flipped bit must not stop it.
        if self.running && self.timer.deadline().is_none() {
            self.timer.start(now);
        }
        self.timer.due(now).then(|| encode(self.node, state))
    }

    /// Returns the period, zero for none.
    pub const fn period(&self) -> Duration {
        self.timer.period()
    }

    /// Moves the next heartbeat and all later ones by `us` microseconds; a negative value moves them earlier.
    pub fn shift(&mut self, us: i32) {
        self.timer.shift(us);
    }

    /// Returns whether the heartbeats are stopped, or the next one is due within two periods, or was due less than two
    /// periods ago.
    pub fn is_on_schedule(&self, now: Instant) -> bool {
        !self.running || self.timer.is_on_schedule(now)
    }

    /// Returns when the next heartbeat is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.timer.deadline()
    }
}
