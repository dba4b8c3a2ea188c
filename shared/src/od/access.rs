//! Access by index and sub-index: what SDO servers and parameter stores see of a dictionary.

use crate::types::{AbortCode, Address};

/// Most bytes of a value that moves [whole](Transfer::Whole): one buffer of this size serves SDO server and store.
pub const WHOLE: usize = 256;

/// How a value is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Transfer {
    /// All bytes at once. Upload: the size; download: the most that is taken.
    Whole(usize),
    /// In parts (a DOMAIN; an upload of more than [`WHOLE`] bytes), so that nobody needs the value in memory twice. Upload:
    /// the size; download: the most that is taken.
    Stream(usize),
}

/// Access to the values of a dictionary, all checks included: existence, access right, length, limits, rules of the object.
///
/// A refused access changes nothing.
pub trait ObjectAccess {
    /// An upload begins: how many bytes, and how.
    ///
    /// # Errors
    /// The abort code to answer.
    fn upload(&mut self, at: Address) -> Result<Transfer, AbortCode>;

    /// A number of at most four bytes as nearly all uploads ask for: its bytes, and how many. `None` for all else, and
    /// for what may not be read: [`ObjectAccess::upload`] knows.
    ///
    /// # Errors
    /// The abort code to answer.
    fn fetch(&mut self, _at: Address) -> Result<Option<([u8; 4], u8)>, AbortCode> {
        Ok(None)
    }

    /// Writes a number of at most four bytes as nearly all downloads do; how many of them count when that was told.
    /// Returns whether it was one: for all else, and for what may not be written, [`ObjectAccess::download`] knows.
    ///
    /// # Errors
    /// The abort code to answer.
    fn store(&mut self, _at: Address, _bytes: [u8; 4], _count: Option<u8>) -> Result<bool, AbortCode> {
        Ok(false)
    }

    /// Copies bytes of the value from `offset` on; returns how many, fewer than `into` holds at the end of the value.
    ///
    /// # Errors
    /// The abort code to answer.
    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> Result<usize, AbortCode>;

    /// A download begins, of `size` bytes when that was told. [`Transfer::Whole`] is followed by one
    /// [`ObjectAccess::write`]; [`Transfer::Stream`] by [`ObjectAccess::write_part`]s in order and then
    /// [`ObjectAccess::finish`] or [`ObjectAccess::cancel`].
    ///
    /// # Errors
    /// The abort code to answer.
    fn download(&mut self, at: Address, size: Option<usize>) -> Result<Transfer, AbortCode>;

    /// Writes a whole value.
    ///
    /// # Errors
    /// The abort code to answer.
    fn write(&mut self, at: Address, value: &[u8]) -> Result<(), AbortCode>;

    /// Writes a part of a stream, the bytes from `offset` on.
    ///
    /// # Errors
    /// The abort code to answer; the stream is cancelled.
    fn write_part(&mut self, at: Address, offset: usize, part: &[u8]) -> Result<(), AbortCode>;

    /// A stream is complete, `size` bytes.
    ///
    /// # Errors
    /// The abort code to answer; the stream is cancelled.
    fn finish(&mut self, at: Address, size: usize) -> Result<(), AbortCode>;

    /// Whether the answer to the last write waits until the object has done its work. Then the dictionary keeps it, and
    /// sends it later.
    fn hold(&mut self, _answer: &[u8; 8]) -> bool {
        false
    }

    /// A stream ended before it was complete.
    fn cancel(&mut self, at: Address);
}
