//! Transmit status register: requests that have ended, and their results.

use ecss_can::link::Stamp;
use ecss_can::link::port::{Mailbox, PortEvent};

/// Bits in the byte of a mailbox: request completed, transmission OK.
const RQCP: u32 = 1 << 0;
const TXOK: u32 = 1 << 1;

/// TSR as read (RM0090 32.9.2). Reading it changes nothing.
#[derive(Clone, Copy)]
pub(super) struct Results(pub u32);

impl Results {
    /// Returns whether the request of this mailbox has ended.
    pub fn ended(self, mailbox: usize) -> bool {
        self.of(mailbox) & RQCP != 0
    }

    /// Returns the value that clears these results when it is written to TSR. RQCP clears the other result bits of its
    /// mailbox. The results of mailboxes that end later are kept.
    pub fn clearing(self) -> u32 {
        self.0 & (RQCP | RQCP << 8 | RQCP << 16)
    }

    /// Returns the event to report for a mailbox whose request has ended. With automatic retransmission it ends by
    /// success or abort; ALST and TERR describe the last attempt.
    pub fn event(self, mailbox: usize, stamp: Stamp) -> PortEvent {
        let number = Mailbox(mailbox as u8);
        if self.of(mailbox) & TXOK != 0 {
            PortEvent::Transmitted { mailbox: number, stamp }
        } else {
            PortEvent::Failed { mailbox: number }
        }
    }

    fn of(self, mailbox: usize) -> u32 {
        self.0 >> (8 * mailbox)
    }
}

#[cfg(test)]
mod tests {
    use ecss_can::types::Instant;

    use crate::bxcan::MAILBOXES;

    use super::*;

    const STAMP: Stamp = Stamp::interrupt(Instant::from_micros(7));

    /// TSR with all mailboxes empty (TME) and the priority code that hardware shows then.
    const EMPTY: u32 = 0x1C00_0000;

    fn told(status: u32) -> Vec<PortEvent> {
        let results = Results(EMPTY | status);
        let ended = (0..MAILBOXES).filter(|mailbox| results.ended(*mailbox));
        ended.map(|mailbox| results.event(mailbox, STAMP)).collect()
    }

    fn sent(number: u8) -> PortEvent {
        PortEvent::Transmitted { mailbox: Mailbox(number), stamp: STAMP }
    }

    fn failed(number: u8) -> PortEvent {
        PortEvent::Failed { mailbox: Mailbox(number) }
    }

    /// ALST (bit 2) and TERR (bit 3) of an attempt before the last one change nothing.
    #[test]
    fn each_mailbox_that_ended_is_reported_once() {
        assert_eq!(told(0), []);
        assert_eq!(told(0x00_00_03), [sent(0)]);
        assert_eq!(told(0x00_0F_00), [sent(1)]);
        assert_eq!(told(0x0D_00_00), [failed(2)]);
        assert_eq!(told(0x03_01_03), [sent(0), failed(1), sent(2)]);
        // Results of requests that software has cleared.
        assert_eq!(told(0x0E_0E_0E), []);
    }

    /// A mailbox that ends between the read and the write of TSR keeps its result for the next interrupt.
    #[test]
    fn only_the_results_that_were_read_are_cleared() {
        for (status, clearing) in [
            (0x00_00_00, 0x00_00_00),
            (0x00_00_03, 0x00_00_01),
            (0x00_0D_00, 0x00_01_00),
            (0x0F_00_01, 0x01_00_01),
            (0x03_03_03, 0x01_01_01),
        ] {
            // ABRQ (bit 7) of each mailbox is read as 1 while a frame is being aborted: it is not requested again.
            assert_eq!(Results(EMPTY | 0x80_80_80 | status).clearing(), clearing, "{status:06X}");
        }
    }
}
