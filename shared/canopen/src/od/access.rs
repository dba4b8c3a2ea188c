//! Access by index and sub-index: the interface between a dictionary and SDO servers or parameter stores.

use crate::types::{AbortCode, Address};

/// Most bytes of a value that moves [whole](Transfer::Whole). SDO server and store need one buffer of this size.
pub const WHOLE: usize = 256;

/// Way in which a value is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Transfer {
    /// All bytes at once. The number is the size of an upload, or the most bytes that a download may have.
    Whole(usize),
    /// Part by part, so that the value is in memory once: a DOMAIN, or an upload of more than [`WHOLE`] bytes.
    /// The number is as in [`Transfer::Whole`].
    Stream(usize),
}

/// Access to the values of a dictionary with all checks: existence, access right, length, limits, rules of the object.
///
/// A refused access changes nothing.
pub trait ObjectAccess {
    /// `false`: no value is written in parts, so that [`ObjectAccess::download`] never returns [`Transfer::Stream`]. The image
    /// of a server for such a dictionary has no code for it.
    const TAKES_PARTS: bool = true;

    /// Begins an upload. Returns the number of bytes and the way in which they move.
    ///
    /// # Errors
    /// The abort code to answer.
    fn upload(&mut self, at: Address) -> Result<Transfer, AbortCode>;

    /// Reads a number of at most four bytes: the short way of nearly all uploads. Returns the bytes and their
    /// number. `None` for other values and for values that may not be read; then call [`ObjectAccess::upload`].
    ///
    /// # Errors
    /// The abort code to answer.
    fn fetch(&mut self, _at: Address) -> Result<Option<([u8; 4], u8)>, AbortCode> {
        Ok(None)
    }

    /// Writes a number of at most four bytes: the short way of nearly all downloads. `count` is the number of
    /// bytes if the client sent it. Returns `false` for other values and for values that may not be written; then
    /// call [`ObjectAccess::download`].
    ///
    /// # Errors
    /// The abort code to answer.
    fn store(&mut self, _at: Address, _bytes: [u8; 4], _count: Option<u8>) -> Result<bool, AbortCode> {
        Ok(false)
    }

    /// Copies bytes of the value from `offset` on. Returns their number, which is less than the length of `into`
    /// at the end of the value.
    ///
    /// # Errors
    /// The abort code to answer.
    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> Result<usize, AbortCode>;

    /// Begins a download, of `size` bytes if the client sent the size. After [`Transfer::Whole`] one
    /// [`ObjectAccess::write`] follows. After [`Transfer::Stream`] calls of [`ObjectAccess::write_part`] follow
    /// in order, and then [`ObjectAccess::finish`] or [`ObjectAccess::cancel`].
    ///
    /// # Errors
    /// The abort code to answer.
    fn download(&mut self, at: Address, size: Option<usize>) -> Result<Transfer, AbortCode>;

    /// Writes a whole value.
    ///
    /// # Errors
    /// The abort code to answer.
    fn write(&mut self, at: Address, value: &[u8]) -> Result<(), AbortCode>;

    /// Writes a part of a stream: the bytes from `offset` on.
    ///
    /// # Errors
    /// The abort code to answer. Then the stream is cancelled.
    fn write_part(&mut self, at: Address, offset: usize, part: &[u8]) -> Result<(), AbortCode>;

    /// Ends a stream of `size` bytes that is complete.
    ///
    /// # Errors
    /// The abort code to answer. Then the stream is cancelled.
    fn finish(&mut self, at: Address, size: usize) -> Result<(), AbortCode>;

    /// Returns whether the answer to the last write has to wait until the object has done its work. Then the
    /// dictionary keeps the answer and sends it later.
    fn hold(&mut self, _answer: &[u8; 8]) -> bool {
        false
    }

    /// Ends a stream that is not complete.
    fn cancel(&mut self, at: Address);
}
