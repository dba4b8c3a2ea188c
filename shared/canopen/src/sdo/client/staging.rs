//! Buffer between the application and the bus: the bytes of one sub-block.

use crate::sdo::block::{MOST, SEGMENT};

/// Number of bytes of the largest sub-block.
pub const STAGING: usize = MOST as usize * SEGMENT as usize;

/// A ring of bytes. What is in it can be read at any place, because a sub-block may have to be sent again.
#[derive(Debug)]
pub(super) struct Staging {
    bytes: [u8; STAGING],
    /// Offset of the first byte.
    head: usize,
    len: usize,
}

impl Staging {
    pub const fn new() -> Staging {
        Staging { bytes: [0; STAGING], head: 0, len: 0 }
    }

    pub fn clear(&mut self) {
        (self.head, self.len) = (0, 0);
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn room(&self) -> usize {
        STAGING.saturating_sub(self.len)
    }

    /// Takes as many bytes as there is room for. Returns their number.
    pub fn push(&mut self, from: &[u8]) -> usize {
        let (before, after) = self.bytes.split_at_mut_checked(self.head).unwrap_or_default();
        // Free are the bytes behind the last one, then those before the first.
        let behind = after.get_mut(self.len..);
        let wrapped = self.len.saturating_sub(STAGING.saturating_sub(self.head));
        let taken = behind.map_or(0, |behind| copy(behind, from));
        let rest = from.get(taken..).unwrap_or_default();
        let taken = taken + before.get_mut(wrapped..).map_or(0, |before| copy(before, rest));
        self.len += taken;
        taken
    }

    /// Copies the bytes from the `at`th on. Returns their number.
    pub fn peek(&self, at: usize, into: &mut [u8]) -> usize {
        let most = into.len().min(self.len.saturating_sub(at));
        let into = into.get_mut(..most).unwrap_or_default();
        let (before, after) = self.bytes.split_at_checked(self.head).unwrap_or_default();
        let copied = after.get(at..).map_or(0, |after| copy(into, after));
        let rest = into.get_mut(copied..).unwrap_or_default();
        let wrapped = (at + copied).saturating_sub(after.len());
        copied + before.get(wrapped..).map_or(0, |before| copy(rest, before))
    }

    /// Returns whether these are the bytes that were pushed last.
    pub fn ends_with(&self, bytes: &[u8; SEGMENT as usize]) -> bool {
        let mut last = [0; SEGMENT as usize];
        self.peek(self.len.saturating_sub(last.len()), &mut last);
        last == *bytes
    }

    /// Removes the first bytes.
    pub fn consume(&mut self, count: usize) {
        let count = count.min(self.len);
        self.head += count;
        if self.head >= STAGING {
            self.head -= STAGING;
        }
        self.len -= count;
    }

    /// Removes the last bytes.
    pub fn truncate(&mut self, count: usize) {
        self.len = self.len.saturating_sub(count);
    }
}

/// Copies what is there and has room; how many bytes.
fn copy(into: &mut [u8], from: &[u8]) -> usize {
    let len = into.len().min(from.len());
    if let (Some(into), Some(from)) = (into.get_mut(..len), from.get(..len)) {
        into.copy_from_slice(from);
    }
    len
}
