//! A receive FIFO, three deep: RM0090 32.7.3, RFxR in 32.9.2.

use std::collections::VecDeque;

use super::regs::{RFR_FOVR, RFR_FULL, RFR_RFOM, TIR_IDE, TIR_RTR};
use crate::wire::frame::{WireFrame, WireId};
use crate::wire::time::Time;

const DEPTH: usize = 3;

/// Result of storing a frame that passed the filters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storing {
    /// It is in the FIFO.
    Stored,
    /// The FIFO was full and this frame is lost: the new one if RFLM is set, otherwise the newest one before it.
    Overrun(WireFrame),
}

/// One message as the output mailbox shows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    pub(super) frame: WireFrame,
    pub(super) filter: u8,
}

/// RFxR and the messages behind it.
#[derive(Clone, Debug, Default)]
pub struct Fifo {
    pub(super) messages: VecDeque<Stored>,
    /// FULL and FOVR.
    pub(super) flags: u32,
    /// Releases since the last [`Fifo::settle`]. The CPU runs ahead of the wire, so a frame that was complete before
    /// them may still arrive.
    released: Vec<Time>,
}

impl Fifo {
    /// RFxR; RFOM acts at once and never reads 1.
    pub fn rfr(&self) -> u32 {
        self.messages.len() as u32 | self.flags
    }

    /// Writes RFxR; returns whether a message was released.
    pub fn write_rfr(&mut self, value: u32, now: Time) -> bool {
        self.flags &= !(value & (RFR_FULL | RFR_FOVR));
        let is_released = value & RFR_RFOM != 0 && self.messages.pop_front().is_some();
        if is_released {
            self.flags &= !RFR_FULL;
            self.released.push(now);
        }
        is_released
    }

    /// RIR, RDTR, RDLR and RDHR of the oldest message; zero when the FIFO is empty.
    ///
    /// TIME stays zero: the block's time stamps cannot be used (TTCM, errata). The DLC of a remote frame reads zero.
    pub fn output(&self, word: usize) -> u32 {
        let Some(Stored { frame, filter }) = self.messages.front() else { return 0 };
        match word {
            0 => rir(frame),
            1 => u32::from(*filter) << 8 | if frame.remote { 0 } else { u32::from(frame.dlc & 0xF) },
            2 => u32::from_le_bytes([frame.data[0], frame.data[1], frame.data[2], frame.data[3]]),
            _ => u32::from_le_bytes([frame.data[4], frame.data[5], frame.data[6], frame.data[7]]),
        }
    }

    /// Stores a frame that passed filter number `filter` and became valid at `at`. `locked` is RFLM.
    pub fn store(&mut self, at: Time, frame: WireFrame, filter: u8, locked: bool) -> Storing {
        let released_later = self.released.iter().filter(|&&released| released > at).count();
        let message = Stored { frame, filter };
        if self.messages.len() + released_later < DEPTH {
            self.messages.push_back(message);
            // A release after `at` has cleared FULL again.
            if self.messages.len() == DEPTH {
                self.flags |= RFR_FULL;
            }
            return Storing::Stored;
        }
        self.flags |= RFR_FOVR;
        if locked {
            return Storing::Overrun(frame);
        }
        match self.messages.back_mut() {
            Some(newest) => Storing::Overrun(std::mem::replace(newest, message).frame),
            // All three were released after `at`: the CPU has read the old frame already, the new one follows.
            None => {
                self.messages.push_back(message);
                Storing::Stored
            }
        }
    }

    /// Forgets past releases after the wire has reached the CPU's time.
    pub fn settle(&mut self) {
        self.released.clear();
    }
}

/// The identifier word of a frame as in RIR.
pub fn rir(frame: &WireFrame) -> u32 {
    let identifier = match frame.id {
        WireId::Standard(id) => u32::from(id) << 21,
        WireId::Extended(id) => id << 3 | TIR_IDE,
    };
    identifier | if frame.remote { TIR_RTR } else { 0 }
}
