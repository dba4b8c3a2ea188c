//! Journal of a controller: the frames that it and its program hand over to each other, and the errors that the program saw.
//!
//! A wire shows what was sent. It does not show which frames a program requested in vain, and when a program took a frame from
//! its FIFO or read an error state. The journal has all of them, at the instants of the program's accesses.

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
    /// The program read this value of ESR: another one than before, or the first one after it cleared ERRI.
    Errors(u32),
    /// The chip was reset.
    Reset,
    /// The chip lost its power, or got it.
    Power,
}

/// Journal of a controller, if it is kept.
#[derive(Clone, Debug, Default)]
pub struct Journal {
    /// Entries since the last call of [`Journal::take`].
    entries: Option<Vec<(Time, Exchange)>>,
    /// The latest ESR that the program read since it cleared ERRI.
    errors: Option<u32>,
}

impl Journal {
    /// Begins the journal.
    pub fn begin(&mut self) {
        self.entries.get_or_insert_default();
    }

    /// Adds an entry.
    pub fn note(&mut self, at: Time, exchange: Exchange) {
        if let Some(entries) = &mut self.entries {
            entries.push((at, exchange));
        }
    }

    /// The program read ESR.
    pub fn note_errors(&mut self, at: Time, esr: u32) {
        if self.errors.replace(esr) != Some(esr) {
            self.note(at, Exchange::Errors(esr));
        }
    }

    /// The program cleared ERRI.
    pub fn clear_errors(&mut self) {
        self.errors = None;
    }

    /// Takes all entries.
    pub fn take(&mut self) -> Vec<(Time, Exchange)> {
        self.entries.as_mut().map(std::mem::take).unwrap_or_default()
    }
}
