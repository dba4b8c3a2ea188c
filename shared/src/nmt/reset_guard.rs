//! Stops a babbled reset from keeping a slave out of operation for ever.
//!
//! A reset without a heartbeat of the master since the last boot may come from anybody. It is obeyed three times in a
//! row. The fourth is ignored, and so is every further one, until a heartbeat was heard or no reset came for the pause
//! (two consumer times). An ignored reset begins the pause anew: a slave with selective access needs the time to search
//! on the other bus.

use crate::types::{Duration, Instant};

/// Decides whether a slave obeys "reset node" and "reset communication".
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ResetGuard {
    /// Resets obeyed in a row, each within the pause after a boot. It outlives a reset of the chip.
    row: u8,
    /// The last boot, or the last reset that was ignored; `None` after a heartbeat or a pause.
    since: Option<Instant>,
    /// The last reset was ignored.
    shut: bool,
}

/// What is to become of a reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ResetVerdict {
    /// Reset, and count it by [`ResetGuard::obeyed`].
    Obey,
    /// Go on as before.
    Ignore {
        /// The one before was obeyed: report this one, and none of those that follow.
        is_first: bool,
    },
}

impl ResetGuard {
    /// Resets that are obeyed in a row.
    pub const MOST: u8 = 3;

    /// A guard before the boot. `row` is what [`ResetGuard::row`] was before the chip was reset, 0 after power-on.
    pub const fn new(row: u8) -> Self {
        ResetGuard { row, since: None, shut: false }
    }

    /// Resets obeyed in a row, 0 to [`ResetGuard::MOST`]: keep it where it outlives a reset of the chip.
    pub const fn row(&self) -> u8 {
        self.row
    }

    /// Whether a heartbeat of the master means anything to it.
    pub const fn is_counting(&self) -> bool {
        self.since.is_some() || self.row != 0 || self.shut
    }

    /// The boot-up message goes out.
    pub fn on_boot(&mut self, now: Instant) {
        self.since = Some(now);
    }

    /// A reset that addresses this node. Call [`ResetGuard::poll`] before: it ends a pause that is over.
    pub fn on_reset(&mut self, now: Instant) -> ResetVerdict {
        if self.since.is_none() || self.row < Self::MOST {
            return ResetVerdict::Obey;
        }
        self.since = Some(now);
        ResetVerdict::Ignore { is_first: !core::mem::replace(&mut self.shut, true) }
    }

    /// The node is about to reset. After a heartbeat or a pause this reset does not count.
    pub fn obeyed(&mut self) {
        if self.since.is_some() {
            self.row = self.row.saturating_add(1);
        }
    }

    /// A heartbeat of the master: resets are obeyed again. Returns whether they were ignored.
    pub fn on_heartbeat(&mut self) -> bool {
        (self.row, self.since) = (0, None);
        core::mem::take(&mut self.shut)
    }

    /// Ends a pause that is over at `now`: resets are obeyed again. Returns whether they were ignored. A `pause` of zero
    /// switches the guard off.
    pub fn poll(&mut self, now: Instant, pause: Duration) -> bool {
        self.deadline(pause).is_some_and(|due| due <= now) && self.on_heartbeat()
    }

    /// When [`ResetGuard::poll`] has something to do.
    pub fn deadline(&self, pause: Duration) -> Option<Instant> {
        Some(self.since? + pause)
    }

    /// Shifts the clock.
    #[cfg(feature = "model")]
    pub fn rebase(&mut self, to: &crate::types::Rebase, pause: Duration) {
        self.since = self.since.map(|since| to.aged(since, pause));
    }
}
