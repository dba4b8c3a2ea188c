//! Reset of slaves that are lost, or stay in Stopped unasked, by the master.
//!
//! An upset may leave a slave in a state that no heartbeat or start command ends: it acknowledges frames but sends none, or
//! it stays in Stopped. The master resets such a slave after a bounded time. A slave that is without power or on the
//! other bus does not receive the reset. So the master repeats it, each time after twice the pause.

use crate::types::{Canonical, Duration, Instant, NodeId};

/// Time from the loss of a slave to its first reset. A slave that is reset, or searches on this bus, is heard before.
const FIRST: Duration = Duration::from_millis(5_000);
/// Longest pause between two resets of a slave.
const LONGEST: Duration = Duration::from_millis(600_000);
/// Time between the resets of two slaves: other frames find the bus free in between.
const SPACING: Duration = Duration::from_millis(10);

/// Decides when the master resets slaves that do not recover by themselves.
///
/// One pause counts for all slaves. A slave that is lost later begins it again.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct Rescue {
    pause: Duration,
    /// Next reset, or end of the pause.
    #[canonical(due)]
    due: Option<Instant>,
    /// Node-ID of the last slave that was reset in this round, zero before.
    last: u8,
}

/// No slave to reset.
impl Default for Rescue {
    fn default() -> Self {
        Rescue { pause: FIRST, due: None, last: 0 }
    }
}

impl Rescue {
    /// Notes that a slave was lost.
    pub fn on_lost(&mut self, now: Instant) {
        let first = now + FIRST;
        (self.pause, self.last) = (FIRST, 0);
        self.due = Some(self.due.map_or(first, |due| due.min(first)));
    }

    /// Notes that a slave sent a heartbeat in Stopped, which the master did not command.
    pub fn on_stopped(&mut self, now: Instant) {
        if self.due.is_none() {
            self.on_lost(now);
        }
    }

    /// Ends all resets: another master is active.
    pub fn stand_by(&mut self) {
        *self = Self::default();
    }

    /// Returns the slave to reset now. `stranded`: the slaves that do not recover, in the order of their Node-IDs. Call it until
    /// `None`.
    pub fn poll(&mut self, now: Instant, stranded: impl IntoIterator<Item = NodeId>) -> Option<NodeId> {
        // Later than the longest pause: a bit flipped.
        self.due.filter(|due| *due <= now || due.since(now) > LONGEST)?;
        let next = stranded.into_iter().find(|node| node.get() > self.last);
        if let Some(node) = next {
            (self.last, self.due) = (node.get(), Some(now + SPACING));
        } else if self.last == 0 {
            (self.pause, self.due) = (FIRST, None);
        } else {
            self.pause = self.pause.times(2).min(LONGEST);
            (self.last, self.due) = (0, Some(now + self.pause));
        }
        next
    }

    /// Returns when to call [`Rescue::poll`] next.
    pub fn deadline(&self) -> Option<Instant> {
        self.due
    }
}
