//! Consumer of SYNC (objects 1007h, 1019h).

use thiserror::Error;

use super::objects::{COB_ID, OVERFLOW, SyncObjects, WINDOW};
use crate::types::{Address, Duration, Frame, Instant};

/// Error: the length of a SYNC does not match 1019h. The SYNC is ignored, and EMCY 8240h reports it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the length of a SYNC does not match 1019h")]
pub struct UnexpectedLength;

/// Consumer of SYNC: checks its length, reads its counter, and opens the synchronous window.
#[doc(alias("1005h", "1007h", "1019h", "COB-ID SYNC", "synchronous window length"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Consumer {
    counted: bool,
    /// Plain SYNC: no counter, no window, the last SYNC was good, and no other part needs every SYNC.
    plain: bool,
    /// Somebody wants to know of each.
    watched: bool,
    /// The last SYNC was of unexpected length.
    wrong: bool,
    window: Duration,
    window_end: Instant,
}

impl Consumer {
    /// Makes a consumer whose window is open until the first SYNC. `overflow`: value of 1019h. `window`: value of
    /// 1007h in microseconds, zero for none.
    pub const fn new(overflow: u8, window: u32) -> Self {
        Consumer {
            counted: overflow != 0,
            plain: overflow == 0 && window == 0,
            watched: false,
            wrong: false,
            window: Duration::from_micros(window as u64),
            window_end: Instant::NEVER,
        }
    }

    /// Takes new values of 1019h and 1007h, which hold from the next SYNC on. Without a window everything is open
    /// at once.
    pub fn configure(&mut self, overflow: u8, window: u32) {
        let window_end = if window == 0 { Instant::NEVER } else { self.window_end };
        *self =
            Consumer { window_end, wrong: self.wrong, watched: self.watched, ..Self::new(overflow, window) };
        self.note_plain();
    }

    /// Sets whether another part of the node needs every SYNC. Then none is plain.
    pub fn watch(&mut self, watched: bool) {
        self.watched = watched;
        self.note_plain();
    }

    fn note_plain(&mut self) {
        self.plain = !(self.wrong || self.counted || self.watched || self.window > Duration::ZERO);
    }

    /// Takes the new value of an object that was written. Returns whether the consumer depends on it.
    pub fn follow(&mut self, at: Address, objects: &SyncObjects) -> bool {
        let is_own = matches!(at.index, COB_ID | WINDOW | OVERFLOW);
        if is_own {
            self.configure(objects.overflow, objects.window);
        }
        is_own
    }

    /// Opens the window until the next SYNC.
    pub fn open(&mut self) {
        self.window_end = Instant::NEVER;
    }

    /// Returns whether the SYNC needs no processing: no counter, no window, and no other part needs it. Its
    /// counter is zero.
    #[inline]
    pub(crate) fn is_plain(&self, frame: &Frame) -> bool {
        self.plain && frame.dlc() == 0
    }

    /// Returns whether the last SYNC had an unexpected length.
    pub(crate) fn is_wrong(&self) -> bool {
        self.wrong
    }

    /// Handles a SYNC that ended at `at`. Returns its counter, zero if SYNCs have none.
    ///
    /// # Errors
    /// [`UnexpectedLength`]: with a counter (1019h) a SYNC has one byte, otherwise none.
    pub fn on_sync(&mut self, frame: &Frame, at: Instant) -> Result<u8, UnexpectedLength> {
        let counter = match (frame.data(), self.counted) {
            (&[], false) => Ok(0),
            (&[counter], true) => Ok(counter),
            _ => Err(UnexpectedLength),
        };
        self.wrong = counter.is_err();
        self.note_plain();
        if !self.wrong {
            let has_window = self.window > Duration::ZERO;
            self.window_end = if has_window { at + self.window } else { Instant::NEVER };
        }
        counter
    }

    /// Returns the end of the window of the last SYNC, until which synchronous PDOs may be sent.
    /// [`Instant::NEVER`] without a window.
    pub const fn window_end(&self) -> Instant {
        self.window_end
    }
}
