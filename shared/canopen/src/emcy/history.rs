//! Pre-defined error field, object 1003h (CiA 301 7.5.2.4): the latest errors, the newest first.

use super::ErrorCode;
use crate::types::{AbortCode, Canonical};

/// The latest errors, at most `N`, each once. A new error removes the oldest.
#[doc(alias("1003h", "pre-defined error field"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct History<const N: usize> {
    entries: [u32; N],
    len: u8,
}

impl<const N: usize> History<N> {
    /// Empty.
    pub(super) const fn new() -> Self {
        const { assert!(N >= 1 && N <= 254, "sub-indices of errors are 1..=254") };
        History { entries: [0; N], len: 0 }
    }

    /// Puts an error in front. One that was there before moves: however often an error comes and goes, it displaces no other
    /// one.
    #[inline(never)] // rows `rx.interrupt_to_application`: frequent code then lies closer together
    pub(super) fn push(&mut self, code: ErrorCode, info: u16) {
        let mut moved = u32::from(info) << 16 | u32::from(code.get());
        let known = self.entries.iter().take(self.len.into()).position(|entry| is_same(*entry, moved));
        if known.is_none() && usize::from(self.len) < N {
            self.len += 1;
        }
        for entry in self.entries.iter_mut().take(known.map_or(N, |known| known + 1)) {
            core::mem::swap(entry, &mut moved);
        }
    }

    /// Keeps the errors that are still active.
    pub(super) fn keep(&mut self, is_active: impl Fn(ErrorCode, u8) -> bool) {
        let mut kept = 0;
        for nth in 0..usize::from(self.len) {
            let entry = self.entries.get(nth).copied().unwrap_or(0);
            if is_active(ErrorCode::new(entry as u16), (entry >> 16) as u8)
                && let Some(place) = self.entries.get_mut(kept)
            {
                *place = entry;
                kept += 1;
            }
        }
        self.len = kept as u8;
    }

    /// Returns the number of errors (sub-index 0).
    pub const fn len(&self) -> u8 {
        self.len
    }

    /// Returns whether there is no error.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns an error (sub-index 1 and up). The low half is the error code, the high half the first two
    /// manufacturer-specific bytes.
    ///
    /// # Errors
    /// [`AbortCode::NoData`] above the last error, [`AbortCode::NoSubIndex`] above the last place.
    pub fn read(&self, sub: u8) -> Result<u32, AbortCode> {
        let place = usize::from(sub).checked_sub(1).and_then(|place| self.entries.get(place));
        match place {
            None => Err(AbortCode::NoSubIndex),
            Some(_) if sub > self.len => Err(AbortCode::NoData),
            Some(entry) => Ok(*entry),
        }
    }

    /// Takes a write to sub-index 0: zero removes all errors.
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`] for any value except zero.
    pub fn write_len(&mut self, value: u8) -> Result<(), AbortCode> {
        if value != 0 {
            return Err(AbortCode::ValueRange);
        }
        self.len = 0;
        Ok(())
    }
}

/// Returns whether two entries are of one error: code and source, without the second byte of the manufacturer.
const fn is_same(one: u32, other: u32) -> bool {
    (one ^ other) & 0x00FF_FFFF == 0
}
