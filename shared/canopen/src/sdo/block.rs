//! Sub-blocks: the receiver acknowledges segments, the sender repeats lost ones (CiA 301 7.2.4.3.9 to 7.2.4.3.14).
//!
//! The server receives the segments of a download, the client those of an upload. The rules are the same. A segment
//! counts if it is the next one. After a lost segment, all others of the sub-block are ignored. The acknowledgement
//! has the number of the last segment that counted. The next sub-block begins after it, numbered from 1.

use super::wire::LAST_OF_BLOCKS;
use crate::link::port::LATE_RESULTS;
use crate::types::{AbortCode, Instant};

/// Most segments of a sub-block.
pub(super) const MOST: u8 = 127;

/// Bytes of a segment.
pub(super) const SEGMENT: u8 = 7;

/// Most segments of a sub-block that are given to the bus before the first of them has left.
pub const WINDOW: u8 = 8;

/// Number of sub-blocks in a row that may have no effect. If there are more, the peer has begun another transfer,
/// which is not understood in a sub-block, or does not understand acknowledgements.
const PATIENCE: u8 = 8;

/// Checks the size of sub-blocks that a peer requests.
pub(super) fn check_size(block_size: u8) -> Result<(), AbortCode> {
    if (1..=MOST).contains(&block_size) { Ok(()) } else { Err(AbortCode::BlockSize) }
}

fn count_fruitless(fruitless: &mut u8, ackseq: u8) -> Result<(), AbortCode> {
    *fruitless = if ackseq == 0 { *fruitless + 1 } else { 0 };
    if *fruitless > PATIENCE { Err(AbortCode::SequenceNumber) } else { Ok(()) }
}

/// Bytes of the last segment that do not count, when the value has `total` bytes.
pub(super) fn unused(total: u32) -> u8 {
    let step = u32::from(SEGMENT);
    if total == 0 { SEGMENT } else { ((step - total % step) % step) as u8 }
}

/// The receiving side of a sub-block.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Receiver {
    /// The segment that counts next.
    next: u8,
    /// Segments of the sub-block.
    size: u8,
    /// [`Receiver::size`] once anything came since the last acknowledgement; zero before.
    open: u8,
    /// First byte of the segment that came last, if it ended a sub-block; else zero.
    ended_by: u8,
    /// Segments of the sub-block that did not count.
    astray: u8,
    /// Sub-blocks in a row of which nothing counted.
    fruitless: u8,
}

/// Meaning of a segment.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum SegmentOutcome {
    /// Its data count.
    Taken,
    /// Its data count, and it ends the sub-block: an acknowledgement is due.
    TakenAtEnd,
    /// Its data count, and it is the last one of the value.
    TakenLast,
    /// It ends the sub-block but does not count.
    Ends,
    /// It does not count.
    Ignored,
}

impl Receiver {
    pub const fn new(size: u8) -> Receiver {
        Receiver { next: 1, size, open: 0, ended_by: 0, astray: 0, fruitless: 0 }
    }

    #[inline]
    pub fn on_segment(&mut self, command: u8) -> SegmentOutcome {
        // First what nearly all are.
        if command != self.next || command >= self.size {
            return self.on_special(command);
        }
        self.open = self.size;
        self.take_plain();
        SegmentOutcome::Taken
    }

    /// Returns whether the segment is the next one, and is neither the first nor the last of its sub-block.
    #[inline]
    pub fn is_plain(&self, command: u8) -> bool {
        command == self.next && command < self.open
    }

    /// Takes a segment that [is plain](Receiver::is_plain).
    #[inline]
    pub fn take_plain(&mut self) {
        self.next += 1;
        self.ended_by = 0;
    }

    fn on_special(&mut self, command: u8) -> SegmentOutcome {
        let seqno = command & !LAST_OF_BLOCKS;
        let is_last = command & LAST_OF_BLOCKS != 0;
        let is_taken = seqno == self.next;
        if !is_taken && self.is_repeat(command) {
            return SegmentOutcome::Ignored;
        }
        // After a lost segment fewer follow than the sub-block has; a peer that sends more brings nothing, for ever.
        self.astray = self.astray.saturating_add(u8::from(!is_taken));
        let ends = is_last || seqno >= self.size || self.astray >= self.size;
        (self.open, self.ended_by) = (self.size, if ends { command } else { 0 });
        if !is_taken {
            return if ends { SegmentOutcome::Ends } else { SegmentOutcome::Ignored };
        }
        self.next += 1;
        if is_last { SegmentOutcome::TakenLast } else { SegmentOutcome::TakenAtEnd }
    }

    /// Returns whether it may be the segment that ended the last sub-block, received twice. A frame is valid for
    /// its receivers one bit before it is valid for its transmitter. The transmitter repeats it after an error in
    /// that bit (ISO 11898-1).
    pub fn is_repeat(&self, command: u8) -> bool {
        command == self.ended_by && command != 0
    }

    /// Ends the sub-block. The next one has `size` segments. Returns the number to acknowledge.
    pub fn acknowledge(&mut self, size: u8) -> Result<u8, AbortCode> {
        let good = self.next.saturating_sub(1);
        count_fruitless(&mut self.fruitless, good)?;
        (self.next, self.size, self.open, self.astray) = (1, size, 0, 0);
        Ok(good)
    }

    /// Returns whether a sub-block has begun and not ended.
    pub fn is_heard(&self) -> bool {
        self.open > 0
    }

    /// Returns the segments that a sender may still send after its transfer was ended.
    pub fn strays(&self, until: Instant) -> Strays {
        Strays { next: self.next, until }
    }
}

/// Segments that a sender had on the way when its transfer was ended. They have no command specifier and would be taken
/// for commands.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Strays {
    next: u8,
    until: Instant,
}

impl Strays {
    pub const NONE: Strays = Strays { next: 0, until: Instant::ZERO };

    /// Number of segments that may be missing before a late one.
    const GAP: u8 = 3;

    /// Returns whether the segment is one of them. They arrive in rising order within a short time.
    pub fn claim(&mut self, command: u8, now: Instant) -> bool {
        let seqno = command & !LAST_OF_BLOCKS;
        let claimed = now < self.until && (self.next..=self.next.saturating_add(Self::GAP)).contains(&seqno);
        if claimed && command & LAST_OF_BLOCKS == 0 {
            self.next = seqno + 1;
        } else {
            self.until = Instant::ZERO;
        }
        claimed
    }
}

/// The sending side of a sub-block.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Sender {
    /// Offset of the sub-block in the value.
    base: u32,
    /// Segments sent of it.
    sent: u8,
    /// Most segments of it.
    size: u8,
    /// Segments whose transmission the bus has not reported.
    in_flight: u8,
    /// The number acknowledged last.
    acked: u8,
    /// Sub-blocks in a row of which nothing was acknowledged.
    fruitless: u8,
}

/// A segment to send.
pub(super) struct Next {
    pub seqno: u8,
    pub offset: u32,
    pub last: bool,
}

/// Meaning of an acknowledgement.
pub(super) enum Ack {
    /// There is more to send, from this offset on.
    More(u32),
    /// All was received.
    Complete,
    /// It was here already: a frame that is received twice meets the sub-block after its own.
    Repeat,
}

impl Sender {
    pub const fn new(size: u8) -> Sender {
        Sender { base: 0, sent: 0, size, in_flight: 0, acked: 0, fruitless: 0 }
    }

    /// Returns whether no sub-block was acknowledged yet.
    pub fn is_first(&self) -> bool {
        self.base == 0 && self.acked == 0
    }

    /// Returns the next segment of a value of `total` bytes, if the sub-block has one and the bus has room.
    pub fn next(&self, total: u32) -> Option<Next> {
        let offset = self.base.saturating_add(u32::from(self.sent) * u32::from(SEGMENT));
        let is_due = self.sent < self.size && self.in_flight < WINDOW && (offset < total || self.sent == 0);
        let last = offset.saturating_add(u32::from(SEGMENT)) >= total;
        is_due.then(|| Next { seqno: self.sent + 1, offset, last })
    }

    /// Notes that this segment was sent.
    pub fn on_send(&mut self) {
        self.sent += 1;
        self.in_flight += 1;
    }

    /// Notes that a segment left the bus, or failed.
    pub fn on_sent(&mut self) {
        self.in_flight = self.in_flight.saturating_sub(1);
    }

    /// Takes the acknowledgement of the receiver, which ends the sub-block.
    pub fn on_ack(&mut self, ackseq: u8, size: u8, total: u32) -> Result<Ack, AbortCode> {
        let left = self.sent.saturating_sub(self.in_flight);
        if ackseq == self.acked && ackseq > left.saturating_add(LATE_RESULTS).min(self.sent) {
            return Ok(Ack::Repeat);
        }
        if ackseq > self.sent {
            return Err(AbortCode::SequenceNumber);
        }
        let base = self.base.saturating_add(u32::from(ackseq) * u32::from(SEGMENT));
        if ackseq > 0 && base >= total {
            return Ok(Ack::Complete);
        }
        check_size(size)?;
        count_fruitless(&mut self.fruitless, ackseq)?;
        // What the bus still holds of a sub-block that was ended early goes out; of a complete one it holds nothing.
        let in_flight = if ackseq == self.sent { 0 } else { self.in_flight };
        *self = Sender { base, sent: 0, size, in_flight, acked: ackseq, fruitless: self.fruitless };
        Ok(Ack::More(base))
    }
}
