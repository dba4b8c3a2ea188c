//! The three transmit mailboxes and TSR: RM0090 32.7.1, 32.9.2 and 32.9.3.
//!
//! Requests and aborts carry the instant at which the CPU wrote them, because the CPU runs ahead of the wire: the
//! effect is determined only when the wire has reached that instant.

use super::regs::{
    TDTR_STORED, TIR_IDE, TIR_RTR, TIR_TXRQ, TSR_ABRQ, TSR_ALST, TSR_RQCP, TSR_TERR, TSR_TXOK,
};
use crate::wire::frame::{WireFrame, WireId};
use crate::wire::time::Time;

const MAILBOXES: usize = 3;

/// Result of one attempt to transmit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attempt {
    /// The frame completed.
    Succeeded,
    /// Another frame had a higher priority.
    ArbitrationLost,
    /// An error ended the frame, for example a missing acknowledgement.
    Failed,
}

/// A transmit request that ended by an abort.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Aborted {
    /// Instant of the abort: of the request for it, or of the end of the attempt during which it was requested.
    pub at: Time,
    /// Frame that was not sent.
    pub frame: WireFrame,
    /// Result of the latest attempt to send the frame; `None` if there was none.
    pub last: Option<Attempt>,
}

/// A requested transmission.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    pub(super) at: Time,
    /// Number of the request at this controller, for TXFP.
    pub(super) order: u64,
    pub(super) abort: Option<Time>,
    pub(super) on_wire: bool,
}

impl Request {
    /// Returns whether it may start at `at`: requested by then, and not yet aborted.
    fn ready(&self, at: Time) -> bool {
        !self.on_wire && self.at <= at && self.abort.is_none_or(|abort| abort > at)
    }
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mailbox {
    /// TIR without TXRQ, TDTR, TDLR, TDHR.
    pub(super) words: [u32; 4],
    /// RQCP, TXOK, ALST and TERR.
    pub(super) status: u32,
    pub(super) request: Option<Request>,
}

impl Mailbox {
    fn empties(&mut self, status: u32) {
        self.request = None;
        self.status = status;
    }

    /// Returns the result of the latest attempt that did not succeed, by the status bits.
    fn last_attempt(&self) -> Option<Attempt> {
        match self.status & (TSR_ALST | TSR_TERR) {
            0 => None,
            TSR_ALST => Some(Attempt::ArbitrationLost),
            _ => Some(Attempt::Failed),
        }
    }

    /// Returns a key in the order of arbitration: base identifier, RTR or SRR, IDE, identifier extension, RTR.
    fn arbitration_key(&self) -> u32 {
        let tir = self.words[0];
        let (base, extension) = (tir >> 21, tir >> 3 & 0x3_FFFF);
        let remote = u32::from(tir & TIR_RTR != 0);
        if tir & TIR_IDE == 0 {
            base << 21 | remote << 20
        } else {
            base << 21 | 1 << 20 | 1 << 19 | extension << 1 | remote
        }
    }

    fn frame(&self) -> WireFrame {
        let [tir, tdtr, low, high] = self.words;
        let mut data = [0; 8];
        data[..4].copy_from_slice(&low.to_le_bytes());
        data[4..].copy_from_slice(&high.to_le_bytes());
        let id = if tir & TIR_IDE == 0 {
            WireId::Standard((tir >> 21) as u16)
        } else {
            WireId::Extended(tir >> 3)
        };
        let mut frame = WireFrame { id, remote: tir & TIR_RTR != 0, dlc: (tdtr & 0xF) as u8, data };
        let len = frame.len();
        frame.data[len..].fill(0);
        frame
    }
}

/// The mailboxes of one controller.
#[derive(Clone, Debug, Default)]
pub struct Mailboxes {
    pub(super) boxes: [Mailbox; MAILBOXES],
    pub(super) requests: u64,
    /// Requests that ended by an abort, in chronological order.
    pub aborted: Vec<Aborted>,
}

impl Mailboxes {
    /// Forgets aborted requests, and the number of requests while none waits: only their order counts.
    pub fn forget_statistics(&mut self) {
        self.aborted.clear();
        if self.boxes.iter().all(|mailbox| mailbox.request.is_none()) {
            self.requests = 0;
        }
    }

    /// TSR; `by_request_order` is TXFP.
    pub fn tsr(&self, by_request_order: bool) -> u32 {
        let mut value = 0;
        for (n, mailbox) in self.boxes.iter().enumerate() {
            value |= mailbox.status << (8 * n);
            match mailbox.request {
                None => value |= 1 << (26 + n),
                Some(request) if request.abort.is_some() => value |= TSR_ABRQ << (8 * n),
                Some(_) => {}
            }
        }
        let lowest = self.pending().max_by_key(|&n| self.priority(n, by_request_order));
        if let Some(lowest) = lowest
            && self.pending().count() > 1
        {
            value |= 1 << (29 + lowest);
        }
        let next_free = self.boxes.iter().position(|mailbox| mailbox.request.is_none());
        value | (next_free.or(lowest).unwrap_or(0) as u32) << 24
    }

    /// Writes TSR: writing 1 clears status bits, RQCP clears all of its mailbox; ABRQ requests an abort.
    pub fn write_tsr(&mut self, value: u32, now: Time) {
        for (n, mailbox) in self.boxes.iter_mut().enumerate() {
            let bits = value >> (8 * n);
            mailbox.status &= !(bits & (TSR_RQCP | TSR_TXOK | TSR_ALST | TSR_TERR));
            if bits & TSR_RQCP != 0 {
                mailbox.status = 0;
            }
            if bits & TSR_ABRQ != 0
                && let Some(request) = &mut mailbox.request
            {
                request.abort.get_or_insert(now);
            }
        }
    }

    /// Word `word` of mailbox `n`: TIR, TDTR, TDLR, TDHR.
    pub fn read(&self, n: usize, word: usize) -> u32 {
        let mailbox = &self.boxes[n];
        let txrq = if word == 0 && mailbox.request.is_some() { TIR_TXRQ } else { 0 };
        mailbox.words[word] | txrq
    }

    /// Writes a word; `false` when the hardware ignores it because the mailbox is not empty.
    pub fn write(&mut self, n: usize, word: usize, value: u32, now: Time) -> bool {
        let mailbox = &mut self.boxes[n];
        if mailbox.request.is_some() {
            return false;
        }
        mailbox.words[word] = match word {
            0 => value & !TIR_TXRQ,
            1 => value & TDTR_STORED,
            _ => value,
        };
        if word == 0 && value & TIR_TXRQ != 0 {
            mailbox.status = 0;
            mailbox.request = Some(Request { at: now, order: self.requests, abort: None, on_wire: false });
            self.requests += 1;
        }
        true
    }

    /// Returns whether a completed request waits for software, which raises the transmit interrupt.
    pub fn any_completed(&self) -> bool {
        self.boxes.iter().any(|mailbox| mailbox.status & TSR_RQCP != 0)
    }

    /// Returns whether a mailbox is transmitting.
    pub fn transmitting(&self) -> bool {
        self.on_wire().is_some()
    }

    /// Earliest request that does not yet transmit.
    pub fn request_at(&self) -> Option<Time> {
        let waiting = self.boxes.iter().filter_map(|mailbox| mailbox.request);
        waiting.filter(|request| request.ready(request.at)).map(|request| request.at).min()
    }

    /// Returns the frame that would enter an arbitration that begins at `at`.
    pub fn contend(&self, at: Time, by_request_order: bool) -> Option<WireFrame> {
        self.winner(at, by_request_order).map(|n| self.boxes[n].frame())
    }

    /// Starts the arbitration at `at`. Returns the frame that entered it.
    pub fn start(&mut self, at: Time, by_request_order: bool) -> Option<WireFrame> {
        let mailbox = &mut self.boxes[self.winner(at, by_request_order)?];
        mailbox.request.as_mut()?.on_wire = true;
        Some(mailbox.frame())
    }

    /// Ends the attempt at `at` and returns its frame. The mailbox becomes empty after a success, in single-shot mode,
    /// or if an abort was requested by then. Otherwise it waits for the next attempt.
    pub fn finish(&mut self, at: Time, attempt: Attempt, single_shot: bool) -> Option<WireFrame> {
        let mailbox = &mut self.boxes[self.on_wire()?];
        let request = mailbox.request.as_mut()?;
        request.on_wire = false;
        let abort = request.abort.is_some_and(|abort| abort <= at);
        // TXOK, ALST and TERR describe only the latest attempt.
        let status = match attempt {
            Attempt::Succeeded => TSR_TXOK,
            Attempt::ArbitrationLost => TSR_ALST,
            Attempt::Failed => TSR_TERR,
        };
        if attempt == Attempt::Succeeded || single_shot || abort {
            mailbox.empties(status | TSR_RQCP);
            if abort && attempt != Attempt::Succeeded {
                self.aborted.push(Aborted { at, frame: mailbox.frame(), last: Some(attempt) });
            }
        } else {
            mailbox.status = status;
        }
        Some(mailbox.frame())
    }

    /// Empties mailboxes whose abort was requested by `now`, which the wire has reached, and that are not transmitting.
    pub fn settle(&mut self, now: Time) {
        for mailbox in &mut self.boxes {
            if let Some(Request { on_wire: false, abort: Some(at), .. }) = mailbox.request
                && at <= now
            {
                self.aborted.push(Aborted { at, frame: mailbox.frame(), last: mailbox.last_attempt() });
                mailbox.empties(mailbox.status | TSR_RQCP);
            }
        }
    }

    fn pending(&self) -> impl Iterator<Item = usize> {
        (0..MAILBOXES).filter(|&n| self.boxes[n].request.is_some())
    }

    fn on_wire(&self) -> Option<usize> {
        self.boxes.iter().position(|mailbox| mailbox.request.is_some_and(|request| request.on_wire))
    }

    fn winner(&self, at: Time, by_request_order: bool) -> Option<usize> {
        let ready =
            self.pending().filter(|&n| self.boxes[n].request.is_some_and(|request| request.ready(at)));
        ready.min_by_key(|&n| self.priority(n, by_request_order))
    }

    /// Returns the priority: the smallest value goes first, the mailbox number breaks ties.
    fn priority(&self, n: usize, by_request_order: bool) -> (u64, usize) {
        let mailbox = &self.boxes[n];
        let key = match mailbox.request {
            Some(request) if by_request_order => request.order,
            _ => u64::from(mailbox.arbitration_key()),
        };
        (key, n)
    }
}
