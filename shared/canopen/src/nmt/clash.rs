//! Detects another node with the Node-ID of this one.

use crate::types::{Canonical, Duration, Instant, NmtState};

/// Within this time after its own heartbeat a node does not yield: that of the other one was on its way already,
/// and the other one yields. Both would otherwise.
pub(crate) const CROSSING: Duration = Duration::from_millis(1);

/// Watches for another node with the Node-ID of this one.
///
/// Two boards with one Node-ID answer the same requests at the same time and destroy each other's frames. A board
/// detects the other one by its heartbeats. The node that booted last *yields*: it is silent until the other one is
/// silent. So a faulty or forged heartbeat does not silence a node that has worked for a while.
///
/// Two nodes that booted together with equal clocks hear each other only if one of them sends a heartbeat late
/// (`heartbeat::Staggered`). That may be the thirty-second one. The late node then still yields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[canonical(context = ClashTimes)]
pub struct ClashWatch {
    /// The last boot-up, `None` since a heartbeat showed that this node is the elder.
    #[canonical(value = self.booted.filter(|booted| now < *booted + context.probation), age = context.probation)]
    booted: Option<Instant>,
    /// End of the last boot-up message or heartbeat of this node since its boot-up.
    #[canonical(age = CROSSING)]
    sent: Option<Instant>,
    /// The last heartbeat of the other node.
    #[canonical(age = context.quiet)]
    heard: Option<Instant>,
    has_yielded: bool,
    /// The node is silent. It yields before that if its boot-up message still waits for an acknowledgement.
    is_silent: bool,
}

/// Times of a [`ClashWatch`] that its owner knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClashTimes {
    /// Time after a boot-up for which a node is a newcomer, as for [`ClashWatch::on_heartbeat`].
    pub probation: Duration,
    /// Silence of the other node that ends a clash, as for [`ClashWatch::poll`].
    pub quiet: Duration,
}

/// Meaning of a heartbeat with the node's own Node-ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Clash {
    /// The other node is known already.
    Known,
    /// The other node was not known. This node continues.
    Elder,
    /// This node booted last: it yields and becomes silent.
    Newcomer,
}

impl ClashWatch {
    /// Makes a watch before boot-up. No other node is known.
    pub const fn new() -> Self {
        ClashWatch { booted: None, sent: None, heard: None, has_yielded: false, is_silent: false }
    }

    /// Notes that the node queues its boot-up message.
    pub fn boot(&mut self, now: Instant) {
        (self.booted, self.sent) = (Some(now), None);
        (self.has_yielded, self.is_silent) = (false, false);
    }

    /// Takes a boot-up message or heartbeat of this node that ended at `at`.
    pub fn on_sent(&mut self, at: Instant) {
        self.sent = Some(at);
    }

    /// Takes a heartbeat or boot-up message of the other node that ended at `at`. A node is a newcomer for
    /// `probation` after its boot-up. Of two boot-up messages the second one is the newcomer's. `is_due`: a heartbeat
    /// of this node was due just before, and perhaps waits.
    pub fn on_heartbeat(&mut self, state: NmtState, at: Instant, probation: Duration, is_due: bool) -> Clash {
        let is_known = self.heard.replace(at).is_some();
        let is_crossing = self.sent.is_some_and(|sent| at < sent + CROSSING);
        let is_newcomer = if state == NmtState::Initialising {
            self.sent.is_none()
        } else {
            !is_crossing && self.booted.is_some_and(|booted| at < booted + probation)
        };
        if is_newcomer && !self.has_yielded {
            self.has_yielded = true;
            return Clash::Newcomer;
        }
        // The other one booted later, or on another grid: this node is the elder from now on.
        if !(is_crossing || is_due) {
            self.booted = None;
        }
        if is_known { Clash::Known } else { Clash::Elder }
    }

    /// Returns whether this node yielded: it is silent, or will be.
    pub const fn has_yielded(&self) -> bool {
        self.has_yielded
    }

    /// Returns whether this node must fall silent now: it yielded, and its boot-up message was sent. Before that no emergency may be
    /// sent, and the other node has not heard this one.
    pub const fn must_fall_silent(&self) -> bool {
        self.has_yielded && !self.is_silent && self.sent.is_some()
    }

    /// Notes that this node is silent.
    pub const fn fall_silent(&mut self) {
        self.is_silent = true;
    }

    /// Returns whether another node is known.
    pub const fn is_known(&self) -> bool {
        self.heard.is_some()
    }

    /// Returns `true` once when the other node has been silent for `quiet`.
    pub fn poll(&mut self, now: Instant, quiet: Duration) -> bool {
        let is_over = self.deadline(quiet).is_some_and(|end| end <= now);
        if is_over {
            self.heard = None;
        }
        is_over
    }

    /// Ends the clash. Returns whether this node yielded.
    pub fn restore(&mut self) -> bool {
        self.is_silent = false;
        core::mem::take(&mut self.has_yielded)
    }

    /// Returns when the other node will have been silent for `quiet`.
    pub fn deadline(&self, quiet: Duration) -> Option<Instant> {
        self.heard.map(|heard| heard + quiet)
    }
}
