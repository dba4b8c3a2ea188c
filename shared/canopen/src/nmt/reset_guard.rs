//! Guard against a reset that is sent again and again and would keep a slave out of operation.

use crate::types::{Canonical, Duration, Instant};

/// Decides whether a slave obeys "reset node" and "reset communication".
///
/// Any node can send a reset. A heartbeat of the master since the last boot makes a reset credible. Without one,
/// the slave obeys three resets in a row. It ignores the fourth and all further ones, until it hears a heartbeat of
/// the master, or receives no reset for a *pause* of two consumer times. An ignored reset starts the pause again: a
/// slave with selective access needs the time to search on the other bus.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[canonical(context = Duration)] // the pause
pub struct ResetGuard {
    /// Resets obeyed in a row, each within the pause after a boot. It outlives a reset of the chip.
    row: u8,
    /// The last boot, or the last reset that was ignored; `None` after a heartbeat or a pause.
    #[canonical(age = *context)]
    since: Option<Instant>,
    /// The last reset was ignored.
    shut: bool,
}

/// Decision on a received reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ResetVerdict {
    /// Reset, and count it with [`ResetGuard::obeyed`].
    Obey,
    /// Ignore the reset and continue.
    Ignore {
        /// `true`: the reset before was obeyed. Report this one, and none of those that follow.
        is_first: bool,
    },
}

impl ResetGuard {
    /// Number of resets in a row that a slave obeys.
    pub const MOST: u8 = 3;

    /// Makes a guard before the boot. `row`: value of [`ResetGuard::row`] before the chip was reset, 0 after
    /// power-on.
    pub const fn new(row: u8) -> Self {
        ResetGuard { row, since: None, shut: false }
    }

    /// Returns the number of resets obeyed in a row, 0 to [`ResetGuard::MOST`]. Keep it in memory that outlives a
    /// reset of the chip.
    pub const fn row(&self) -> u8 {
        self.row
    }

    /// Returns whether resets count: from boot-up to a heartbeat of the master or a pause.
    pub const fn is_counting(&self) -> bool {
        self.since.is_some()
    }

    /// Notes that the boot-up message is sent.
    pub fn on_boot(&mut self, now: Instant) {
        self.since = Some(now);
    }

    /// Takes a reset that addresses this node. Call [`ResetGuard::poll`] before: it ends a pause that is over.
    pub fn on_reset(&mut self, now: Instant) -> ResetVerdict {
        if self.since.is_none() || self.row < Self::MOST {
            return ResetVerdict::Obey;
        }
        self.since = Some(now);
        ResetVerdict::Ignore { is_first: !core::mem::replace(&mut self.shut, true) }
    }

    /// Counts a reset that the node is about to make. After a heartbeat or a pause this reset does not count.
    pub fn obeyed(&mut self) {
        if self.since.is_some() {
            self.row = self.row.saturating_add(1);
        }
    }

    /// Takes a heartbeat of the master: resets are obeyed again. Returns whether they were ignored.
    pub fn on_heartbeat(&mut self) -> bool {
        (self.row, self.since) = (0, None);
        core::mem::take(&mut self.shut)
    }

    /// Ends a pause that is over at `now`: resets are obeyed again. Returns whether they were ignored. A `pause`
    /// of zero disables the guard.
    pub fn poll(&mut self, now: Instant, pause: Duration) -> bool {
        self.deadline(pause).is_some_and(|due| due <= now) && self.on_heartbeat()
    }

    /// Returns when to call [`ResetGuard::poll`] next.
    pub fn deadline(&self, pause: Duration) -> Option<Instant> {
        Some(self.since? + pause)
    }
}
