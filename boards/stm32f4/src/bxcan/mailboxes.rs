//! Choice of the transmit mailbox for a frame.
//!
//! bxCAN sends the pending mailbox with the lowest identifier first, and of equal identifiers the lowest mailbox number
//! (RM0090 32.7.1). So frames of one COB-ID may be pending together only in mailboxes with rising numbers. When no
//! higher mailbox is free, the next frame waits in a lower one.

use ecss_can::link::port::{Mailbox, is_urgent};
use ecss_can::types::CobId;

use super::MAILBOXES;
use super::held::Flags;

/// No mailbox has to end first.
const NONE: Flags = [false; MAILBOXES];

/// Identifiers in the mailboxes. A mailbox stays in use until its result has been reported.
#[derive(Default)]
pub(super) struct Mailboxes {
    in_use: [Option<CobId>; MAILBOXES],
}

impl Mailboxes {
    /// Reserves a mailbox for a frame with this identifier. Returns it and the mailboxes that must end before it is
    /// requested. Returns `None` if no mailbox can be used now. `holds_one`: a frame waits already, and only one can
    /// wait.
    pub fn claim(&mut self, id: CobId, holds_one: impl FnOnce() -> bool) -> Option<(Mailbox, Flags)> {
        let mut same = NONE;
        let (mut free, mut lowest, mut higher) = (0, None, None);
        for ((number, slot), is_same) in self.in_use.iter().enumerate().zip(&mut same) {
            if slot.is_none() {
                free += 1;
                lowest = lowest.or(Some(number));
                higher = higher.or(Some(number));
            } else if *slot == Some(id) {
                (*is_same, higher) = (true, None);
            }
        }
        let kept_free = if is_urgent(id) { 0 } else { 1 };
        if free <= kept_free || same != NONE && holds_one() {
            return None;
        }
        let (number, before) = match higher {
            Some(number) => (number, NONE),
            None => (lowest?, same),
        };
        *self.in_use.get_mut(number)? = Some(id);
        Some((Mailbox(number as u8), before))
    }

    /// Returns whether the mailbox is in use by a frame with this identifier.
    pub fn holds(&self, mailbox: Mailbox, id: CobId) -> bool {
        self.in_use.get(usize::from(mailbox.0)) == Some(&Some(id))
    }

    /// Frees a mailbox whose result was reported.
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

    /// Reserves a mailbox. Returns its number if the frame may be requested at once.
    fn at_once(mailboxes: &mut Mailboxes, id: CobId) -> Option<u8> {
        let (mailbox, before) = mailboxes.claim(id, || false)?;
        assert_eq!(before, NONE);
        Some(mailbox.0)
    }

    #[test]
    fn one_mailbox_is_left_for_urgent_frames() {
        let mut mailboxes = Mailboxes::default();
        assert_eq!(at_once(&mut mailboxes, id(0x382)), Some(0));
        assert_eq!(at_once(&mut mailboxes, id(0x702)), Some(1));
        assert_eq!(mailboxes.claim(id(0x382), || false), None);
        assert_eq!(at_once(&mut mailboxes, URGENT), Some(2));
        assert_eq!(mailboxes.claim(URGENT, || false), None);
    }

    #[test]
    fn a_mailbox_holds_an_identifier_until_its_result_was_reported() {
        let mut mailboxes = Mailboxes::default();
        assert_eq!(at_once(&mut mailboxes, URGENT), Some(0));
        assert!(mailboxes.holds(Mailbox(0), URGENT));
        assert!(!mailboxes.holds(Mailbox(0), id(0x382)));
        assert!(!mailboxes.holds(Mailbox(1), URGENT));
        mailboxes.release(Mailbox(0));
        assert!(!mailboxes.holds(Mailbox(0), URGENT));
    }

    #[test]
    fn equal_identifiers_are_pending_in_rising_numbers_only() {
        let mut mailboxes = Mailboxes::default();
        assert_eq!(at_once(&mut mailboxes, id(0x382)), Some(0));
        assert_eq!(at_once(&mut mailboxes, id(0x382)), Some(1));
        mailboxes.release(Mailbox(0));
        assert_eq!(at_once(&mut mailboxes, id(0x382)), Some(2), "behind the one that is pending in 1");
        mailboxes.release(Mailbox(1));
        let waits = Some((Mailbox(0), [false, false, true]));
        assert_eq!(mailboxes.claim(id(0x382), || false), waits, "0 would overtake 2");
        mailboxes.release(Mailbox(2));
        assert_eq!(at_once(&mut mailboxes, id(0x382)), Some(1), "0 was requested when 2 ended");
    }

    #[test]
    fn frame_waits_behind_all_of_its_identifier() {
        let mut mailboxes = Mailboxes::default();
        assert_eq!(at_once(&mut mailboxes, id(0x382)), Some(0));
        assert_eq!(at_once(&mut mailboxes, URGENT), Some(1));
        assert_eq!(at_once(&mut mailboxes, URGENT), Some(2));
        mailboxes.release(Mailbox(0));
        assert_eq!(mailboxes.claim(URGENT, || false), Some((Mailbox(0), [false, true, true])));
    }

    #[test]
    fn while_a_frame_waits_only_other_identifiers_are_taken() {
        let mut mailboxes = Mailboxes::default();
        assert_eq!(at_once(&mut mailboxes, id(0x382)), Some(0));
        assert_eq!(mailboxes.claim(id(0x382), || true), None);
        assert_eq!(mailboxes.claim(id(0x702), || true), Some((Mailbox(1), NONE)));
    }
}
