//! Journal of a controller: the frames that it and its program hand over to each other.
//!
//! A wire shows what was sent. It does not show which frames a program requested in vain, and when a program took a frame from
//! its FIFO. The journal has both, at the instants of the program's accesses.

use can_wire::frame::WireFrame;
use can_wire::time::Time;

/// Entry of the journal of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchange {
    /// The program requested the transmission of this frame: TXRQ.
    Requested(WireFrame),
    /// The program acknowledged that this frame was sent: RQCP with TXOK.
    Sent(WireFrame),
    /// The program acknowledged that the request of this frame was aborted: RQCP without TXOK.
    Aborted(WireFrame),
    /// The program took this frame: RFOM.
    Taken(WireFrame),
    /// The chip was reset.
    Reset,
    /// The chip lost its power, or got it.
    Power,
}

/// Entries since the last call of [`Journal::take`], if the journal is kept.
#[derive(Clone, Debug, Default)]
pub struct Journal(Option<Vec<(Time, Exchange)>>);

impl Journal {
    /// Begins the journal.
    pub fn begin(&mut self) {
        self.0.get_or_insert_default();
    }

    /// Adds an entry.
    pub fn note(&mut self, at: Time, exchange: Exchange) {
        if let Some(entries) = &mut self.0 {
            entries.push((at, exchange));
        }
    }

    /// Takes all entries.
    pub fn take(&mut self) -> Vec<(Time, Exchange)> {
        self.0.as_mut().map(std::mem::take).unwrap_or_default()
    }
}
