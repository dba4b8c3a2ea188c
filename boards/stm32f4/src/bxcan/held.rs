//! A frame that waits in its mailbox until it may be requested.
//!
//! Of pending frames with equal identifiers bxCAN sends the one in the lowest mailbox first (RM0090 32.7.1). A frame
//! behind one in a higher mailbox would overtake it. So the frame is written into its mailbox without TXRQ, and the
//! transmit interrupt sets TXRQ when the frames before it have ended. This happens within the intermission, so there is
//! no gap on the bus.

use ecss_can::link::port::Mailbox;

use super::MAILBOXES;

/// One flag for each mailbox.
pub(super) type Flags = [bool; MAILBOXES];

/// The frame that waits: request `mailbox` when the frames in the mailboxes `behind` have ended.
#[derive(Clone, Copy)]
pub(super) struct Held {
    pub mailbox: Mailbox,
    /// Mailboxes with frames that have to end first. None set: no frame waits.
    pub behind: Flags,
}

impl Held {
    /// No frame waits. All zero, so that the statics of the events stay in `.bss`.
    pub const NOTHING: Held = Held { mailbox: Mailbox(0), behind: [false; MAILBOXES] };

    /// Returns whether a frame waits.
    pub fn waits(&self) -> bool {
        self.behind.contains(&true)
    }

    /// Removes the mailboxes that have ended. Returns the mailbox to request when the last one is removed.
    pub fn end(&mut self, ended: impl Fn(usize) -> bool) -> Option<Mailbox> {
        if !self.waits() {
            return None;
        }
        for (number, is_waited_for) in self.behind.iter_mut().enumerate() {
            *is_waited_for &= !ended(number);
        }
        (!self.waits()).then_some(self.mailbox)
    }

    /// Cancels the frame in this mailbox. Returns whether it waited.
    pub fn cancel(&mut self, mailbox: Mailbox) -> bool {
        let waited = self.waits() && self.mailbox == mailbox;
        if waited {
            *self = Held::NOTHING;
        }
        waited
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame in mailbox 0 that waits for mailboxes 1 and 2.
    const BEHIND_BOTH: Held = Held { mailbox: Mailbox(0), behind: [false, true, true] };

    #[test]
    fn frame_is_requested_once_when_all_before_it_have_ended() {
        let mut held = BEHIND_BOTH;
        assert_eq!(held.end(|n| n == 2), None, "1 is pending");
        assert_eq!(held.end(|n| n == 0), None, "another frame's result");
        assert_eq!(held.end(|n| n == 1), Some(Mailbox(0)));
        assert_eq!(held.end(|_| true), None);
    }

    #[test]
    fn cancelled_frame_is_not_requested() {
        let mut held = BEHIND_BOTH;
        assert!(!held.cancel(Mailbox(1)), "1 is pending, it does not wait");
        assert!(held.cancel(Mailbox(0)));
        assert!(!held.cancel(Mailbox(0)));
        assert_eq!(held.end(|_| true), None);
    }
}
