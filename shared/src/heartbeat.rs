//! Heartbeat and boot-up: producer, messages, consumer (CiA 301 7.2.8.2.2, 7.2.8.2.3).

use crate::link::{CobId, Frame};
use crate::nmt::{NmtState, NodeId};
use crate::time::{Duration, Instant, Periodic};

/// The heartbeat of `node`; with [`NmtState::Initialising`] it is the boot-up message.
pub fn encode(node: NodeId, state: NmtState) -> Frame {
    Frame::of(CobId::heartbeat(node), [state.byte()])
}

/// State told by a heartbeat or boot-up message; `None` when malformed: length other than 1, unknown state.
pub fn decode(frame: &Frame) -> Option<NmtState> {
    let &[byte] = frame.data() else { return None };
    NmtState::from_byte(byte)
}

/// Producer of one node's heartbeat (object 1017h).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Producer {
    node: NodeId,
    timer: Periodic,
}

impl Producer {
    /// Silent until [`Producer::announce`]d or [`Producer::restart`]ed. A period of zero keeps it silent.
    pub const fn new(node: NodeId, period: Duration) -> Self {
        Producer { node, timer: Periodic::new(period) }
    }

    /// The next heartbeat is due at once.
    pub fn announce(&mut self, now: Instant) {
        self.timer.start(now);
    }

    /// The next heartbeat is due a period from now: one went out, or a boot-up message did.
    pub fn restart(&mut self, now: Instant) {
        self.timer.restart(now);
    }

    /// No more heartbeats.
    pub fn stop(&mut self) {
        self.timer.stop();
    }

    /// The heartbeat, when it is due.
    pub fn poll(&mut self, now: Instant, state: NmtState) -> Option<Frame> {
        self.timer.due(now).then(|| encode(self.node, state))
    }

    /// When the next one is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.timer.deadline()
    }
}

/// Consumer of one node's heartbeat (object 1016h).
///
/// Armed by the first heartbeat; one timeout event; the next heartbeat resolves it. The consumer time is an argument
/// because many consumers share it. A consumer time of zero disables the monitoring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Consumer {
    /// No heartbeat yet.
    #[default]
    Unarmed,
    /// Heard in time.
    Armed {
        /// The last heartbeat.
        last: Instant,
    },
    /// Missed, and told so.
    Missed {
        /// The last heartbeat.
        last: Instant,
    },
}

impl Consumer {
    /// A heartbeat ended at `at`. Whether it resolves a miss.
    pub fn on_heartbeat(&mut self, at: Instant) -> bool {
        let resolved = matches!(self, Consumer::Missed { .. });
        *self = Consumer::Armed { last: at };
        resolved
    }

    /// The instant of the last heartbeat, once, when the next is overdue.
    pub fn poll(&mut self, now: Instant, time: Duration) -> Option<Instant> {
        match (*self, self.deadline(time)) {
            (Consumer::Armed { last }, Some(deadline)) if deadline <= now => {
                *self = Consumer::Missed { last };
                Some(last)
            }
            _ => None,
        }
    }

    /// When the next heartbeat is overdue.
    pub fn deadline(&self, time: Duration) -> Option<Instant> {
        match *self {
            Consumer::Armed { last } if time > Duration::ZERO => Some(last + time),
            _ => None,
        }
    }

    /// Whether a heartbeat is missed now.
    pub fn is_missed(&self) -> bool {
        matches!(self, Consumer::Missed { .. })
    }
}
