//! Three transmit mailboxes: lowest COB-ID first, equal ones by number.

use can_twin::wire::time::Time;
use ecss_can::link::port::is_urgent;
use ecss_can::types::Frame;

/// Transmit mailboxes of a controller.
pub(super) const MAILBOXES: usize = 3;

#[derive(Clone, Copy, Debug, Default)]
enum Slot {
    #[default]
    Free,
    Pending {
        frame: Frame,
        since: Time,
        on_wire: bool,
        aborted: bool,
    },
    /// Its result is not yet reported.
    Ended,
}

#[derive(Debug, Default)]
pub(super) struct Mailboxes([Slot; MAILBOXES]);

impl Mailboxes {
    /// Puts a frame into a mailbox. Returns `None` if no mailbox may take it now.
    pub fn put(&mut self, frame: Frame, now: Time) -> Option<usize> {
        let free = self.0.iter().filter(|slot| matches!(slot, Slot::Free)).count();
        if free < if is_urgent(frame.id()) { 1 } else { 2 } {
            return None;
        }
        // Equal COB-IDs are sent in the order of mailbox numbers, so only mailboxes above waiting ones are allowed.
        let same =
            |slot: &Slot| matches!(slot, Slot::Pending { frame: other, .. } if other.id() == frame.id());
        let first = self.0.iter().rposition(same).map_or(0, |last| last + 1);
        let mailbox = (first..MAILBOXES).find(|&mailbox| matches!(self.0[mailbox], Slot::Free))?;
        self.0[mailbox] = Slot::Pending { frame, since: now, on_wire: false, aborted: false };
        Some(mailbox)
    }

    /// Returns the frame for an arbitration that begins at `at`.
    pub fn best(&self, at: Time) -> Option<(usize, Frame)> {
        let ready = self.0.iter().enumerate().filter_map(|(mailbox, slot)| match slot {
            Slot::Pending { frame, since, aborted: false, .. } if *since <= at => Some((mailbox, *frame)),
            _ => None,
        });
        ready.min_by_key(|(mailbox, frame)| (frame.id(), *mailbox))
    }

    /// Returns since when a frame waits.
    pub fn waiting_since(&self) -> Option<Time> {
        let waiting = self.0.iter().filter_map(|slot| match slot {
            Slot::Pending { since, aborted: false, .. } => Some(*since),
            _ => None,
        });
        waiting.min()
    }

    /// Records the start of the frame of this mailbox.
    pub fn start(&mut self, mailbox: usize) {
        if let Slot::Pending { on_wire, .. } = &mut self.0[mailbox] {
            *on_wire = true;
        }
    }

    /// Returns the mailbox whose frame is on the wire.
    pub fn on_wire(&self) -> Option<usize> {
        self.0.iter().position(|slot| matches!(slot, Slot::Pending { on_wire: true, .. }))
    }

    /// Handles a failed frame on the wire: it waits again. Returns its mailbox if it was to be aborted.
    pub fn retry(&mut self) -> Option<usize> {
        let mailbox = self.on_wire()?;
        let Slot::Pending { on_wire, aborted, .. } = &mut self.0[mailbox] else { return None };
        *on_wire = false;
        aborted.then_some(mailbox)
    }

    /// Aborts a mailbox. Returns whether the abort takes effect now; a frame on the wire is completed first.
    pub fn abort(&mut self, mailbox: usize) -> bool {
        match self.0.get_mut(mailbox) {
            Some(Slot::Pending { on_wire, aborted, .. }) => {
                *aborted = true;
                !*on_wire
            }
            _ => false,
        }
    }

    pub fn is_pending(&self, mailbox: usize) -> bool {
        matches!(self.0[mailbox], Slot::Pending { .. })
    }

    pub fn end(&mut self, mailbox: usize) {
        self.0[mailbox] = Slot::Ended;
    }

    pub fn free(&mut self, mailbox: usize) {
        self.0[mailbox] = Slot::Free;
    }
}
