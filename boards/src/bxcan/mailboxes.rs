//! Which transmit mailbox a frame goes into.
//!
//! bxCAN sends the pending mailbox with the lowest identifier first, and of equal identifiers the lowest mailbox number
//! (RM0090 32.7.1). So frames of one COB-ID keep their order when they are pending together in rising numbers only.

use ecss_can::link::port::{MAILBOXES, Mailbox, is_urgent};
use ecss_can::types::CobId;

/// What is in the mailboxes. One stays in use until its result has been reported.
#[derive(Default)]
pub(super) struct Mailboxes {
    in_use: [Option<CobId>; MAILBOXES],
}

impl Mailboxes {
    /// A mailbox for a frame with this identifier, in use from now on. `None`: not now.
    pub fn claim(&mut self, id: CobId) -> Option<Mailbox> {
        let is_free = |slot: &Option<CobId>| slot.is_none();
        let kept_free = if is_urgent(id) { 0 } else { 1 };
        if self.in_use.iter().filter(|slot| is_free(slot)).count() <= kept_free {
            return None;
        }
        let after = self.in_use.iter().rposition(|slot| *slot == Some(id)).map_or(0, |same| same + 1);
        let (number, slot) =
            self.in_use.iter_mut().enumerate().skip(after).find(|(_, slot)| is_free(slot))?;
        *slot = Some(id);
        Some(Mailbox(number as u8))
    }

    /// Whether it is in use by a frame with this identifier.
    pub fn holds(&self, mailbox: Mailbox, id: CobId) -> bool {
        self.in_use.get(usize::from(mailbox.0)) == Some(&Some(id))
    }

    /// Its result was reported.
    pub fn release(&mut self, mailbox: Mailbox) {
        if let Some(slot) = self.in_use.get_mut(usize::from(mailbox.0)) {
            *slot = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const URGENT: CobId = CobId::SYNC;

    fn id(raw: u16) -> CobId {
        CobId::new(raw).unwrap()
    }

    #[test]
    fn one_mailbox_is_left_for_urgent_frames() {
        let mut mailboxes = Mailboxes::default();
        assert_eq!(mailboxes.claim(id(0x382)), Some(Mailbox(0)));
        assert_eq!(mailboxes.claim(id(0x702)), Some(Mailbox(1)));
        assert_eq!(mailboxes.claim(id(0x382)), None);
        assert_eq!(mailboxes.claim(URGENT), Some(Mailbox(2)));
        assert_eq!(mailboxes.claim(URGENT), None);
    }

    #[test]
    fn a_mailbox_holds_an_identifier_until_its_result_was_reported() {
        let mut mailboxes = Mailboxes::default();
        assert_eq!(mailboxes.claim(URGENT), Some(Mailbox(0)));
        assert!(mailboxes.holds(Mailbox(0), URGENT));
        assert!(!mailboxes.holds(Mailbox(0), id(0x382)));
        assert!(!mailboxes.holds(Mailbox(1), URGENT));
        mailboxes.release(Mailbox(0));
        assert!(!mailboxes.holds(Mailbox(0), URGENT));
    }

    #[test]
    fn equal_identifiers_are_pending_in_rising_numbers_only() {
        let mut mailboxes = Mailboxes::default();
        assert_eq!(mailboxes.claim(id(0x382)), Some(Mailbox(0)));
        assert_eq!(mailboxes.claim(id(0x382)), Some(Mailbox(1)));
        mailboxes.release(Mailbox(0));
        assert_eq!(mailboxes.claim(id(0x382)), Some(Mailbox(2)), "behind the one that is pending in 1");
        mailboxes.release(Mailbox(1));
        assert_eq!(mailboxes.claim(id(0x382)), None, "0 and 1 would overtake 2");
        assert_eq!(mailboxes.claim(id(0x702)), Some(Mailbox(0)), "another identifier may have them");
        mailboxes.release(Mailbox(0));
        mailboxes.release(Mailbox(2));
        assert_eq!(mailboxes.claim(id(0x382)), Some(Mailbox(0)));
    }
}
