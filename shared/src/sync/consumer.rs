//! Consumer of SYNC (objects 1007h, 1019h).

use super::objects::{COB_ID, OVERFLOW, SyncObjects, WINDOW};
use crate::types::{Address, Duration, Frame, Instant};

/// A SYNC whose data length is not what 1019h says: it is ignored, and EMCY 8240h tells of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct UnexpectedLength;

/// The consumer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Consumer {
    counted: bool,
    /// Neither counter nor window, the last SYNC was as expected, and nobody wants to know of each.
    plain: bool,
    /// Somebody wants to know of each.
    watched: bool,
    /// The last SYNC was of unexpected length.
    wrong: bool,
    window: Duration,
    window_end: Instant,
}

impl Consumer {
    /// `overflow` is 1019h, `window` 1007h in microseconds, zero for none. Open until the first SYNC.
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

    /// New values of 1019h and 1007h, for the SYNCs to come. Without a window all is open at once.
    pub fn configure(&mut self, overflow: u8, window: u32) {
        let window_end = if window == 0 { Instant::NEVER } else { self.window_end };
        *self =
            Consumer { window_end, wrong: self.wrong, watched: self.watched, ..Self::new(overflow, window) };
        self.note_plain();
    }

    /// Whether somebody wants to know of each SYNC: none is plain then.
    pub fn watch(&mut self, watched: bool) {
        self.watched = watched;
        self.note_plain();
    }

    fn note_plain(&mut self) {
        self.plain = !(self.wrong || self.counted || self.watched || self.window > Duration::ZERO);
    }

    /// Follows its objects when one that it depends on was written. Returns whether it was.
    pub fn follow(&mut self, at: Address, objects: &SyncObjects) -> bool {
        let is_own = matches!(at.index, COB_ID | WINDOW | OVERFLOW);
        if is_own {
            self.configure(objects.overflow, objects.window);
        }
        is_own
    }

    /// Open until the next SYNC.
    pub fn open(&mut self) {
        self.window_end = Instant::NEVER;
    }

    /// Whether it is a SYNC as most are, without counter and window, and of interest for nobody: there is nothing to do, its
    /// counter is zero.
    #[inline]
    pub fn is_plain(&self, frame: &Frame) -> bool {
        self.plain && frame.dlc() == 0
    }

    /// Whether the last SYNC was of unexpected length.
    pub fn is_wrong(&self) -> bool {
        self.wrong
    }

    /// A SYNC ended at `at`. Its counter; zero when SYNCs have none.
    ///
    /// # Errors
    /// [`UnexpectedLength`] unless it has one byte with a counter, none without.
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

    /// Until when synchronous PDOs of the last SYNC may go out: how long they live. Never over without a window.
    pub const fn window_end(&self) -> Instant {
        self.window_end
    }
}
