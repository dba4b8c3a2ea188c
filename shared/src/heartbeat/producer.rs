//! Producer of one node's heartbeat (object 1017h).

use super::encode;
use crate::types::{Duration, Frame, Instant, NmtState, NodeId, Periodic};

/// The producer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Producer {
    node: NodeId,
    running: bool,
    timer: Periodic,
}

impl Producer {
    /// Silent until [`Producer::announce`]d or [`Producer::restart`]ed. A period of zero keeps it silent.
    pub const fn new(node: NodeId, period: Duration) -> Self {
        Producer { node, running: false, timer: Periodic::new(period) }
    }

    /// Its heartbeats are those of this node.
    pub const fn set_node(&mut self, node: NodeId) {
        self.node = node;
    }

    /// The next heartbeat is due at once.
    pub fn announce(&mut self, now: Instant) {
        self.running = true;
        self.timer.start(now);
    }

    /// The next heartbeat is due a period from now: one went out, or a boot-up message did.
    pub fn restart(&mut self, now: Instant) {
        self.running = true;
        self.timer.restart(now);
    }

    /// No more heartbeats.
    pub fn stop(&mut self) {
        self.running = false;
        self.timer.stop();
    }

    /// A new period, zero for none. When it runs, a heartbeat is due at once: consumers wait for none longer than for
    /// the old period or the new one.
    pub fn set_period(&mut self, period: Duration, now: Instant) {
        self.timer = Periodic::new(period);
        if self.running {
            self.timer.start(now);
        }
    }

    /// The heartbeat, when it is due.
    pub fn poll(&mut self, now: Instant, state: NmtState) -> Option<Frame> {
        self.timer.due(now).then(|| encode(self.node, state))
    }

    /// The period, zero for none.
    pub const fn period(&self) -> Duration {
        self.timer.period()
    }

    /// Moves the next heartbeat and all later ones by `us` microseconds; a negative value moves them earlier.
    pub fn shift(&mut self, us: i32) {
        self.timer.shift(us);
    }

    /// When the next one is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.timer.deadline()
    }

    /// Shifts the clock.
    #[cfg(feature = "model")]
    pub fn rebase(&mut self, to: &crate::types::Rebase) {
        self.timer.rebase(to);
    }
}
