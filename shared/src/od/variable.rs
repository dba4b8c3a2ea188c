//! A value under an index and sub-index, whatever its type.

use super::DataType;
use crate::types::AbortCode;

/// A value of the object dictionary: a number, which is its bits, or [`Bytes`].
pub trait Variable {
    /// The number, in the low bits; those above are zero. Zero for [`Bytes`].
    fn bits(&self) -> u64 {
        0
    }

    /// Takes a number, the low bits. Nothing happens to [`Bytes`].
    fn set_bits(&mut self, _bits: u64) {}

    /// The value, where it is no number.
    fn bytes(&mut self) -> Option<&mut dyn Bytes> {
        None
    }
}

/// A string or a block: a value whose size is its own business.
pub trait Bytes {
    /// Bytes that an upload gives now.
    fn len(&self) -> usize;

    /// Whether an upload gives nothing.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Copies bytes from `offset` on; returns how many.
    fn read(&self, offset: usize, into: &mut [u8]) -> usize;

    /// Takes a whole value.
    ///
    /// # Errors
    /// [`AbortCode::TooLong`], or what its type forbids; nothing was changed.
    fn write(&mut self, value: &[u8]) -> Result<(), AbortCode>;

    /// Most bytes that a DOMAIN takes; zero for strings.
    fn capacity(&self) -> usize {
        0
    }

    /// Takes a part, from `offset` on; the parts come in order.
    ///
    /// # Errors
    /// [`AbortCode::UnsupportedAccess`] where no parts are taken; beyond its capacity [`AbortCode::OutOfMemory`] from a
    /// DOMAIN, [`AbortCode::TooLong`] from a string.
    fn write_part(&mut self, _offset: usize, _part: &[u8]) -> Result<(), AbortCode> {
        Err(AbortCode::UnsupportedAccess)
    }

    /// All parts were written, `size` bytes.
    ///
    /// # Errors
    /// [`AbortCode::UnsupportedAccess`] where no parts are taken, or what is wrong with the value.
    fn finish(&mut self, _size: usize) -> Result<(), AbortCode> {
        Err(AbortCode::UnsupportedAccess)
    }

    /// The value will not be written to its end.
    fn cancel(&mut self) {}
}

/// What a declaration needs to know of a type.
pub trait Typed: Variable {
    /// Type in the dictionary.
    const TYPE: DataType;
    /// Bytes of a number, most bytes of a string, zero for a DOMAIN.
    const SIZE: usize;
}

/// Copies from the middle of a value; returns how many bytes.
pub(super) fn copy_from(bytes: &[u8], offset: usize, into: &mut [u8]) -> usize {
    let rest = bytes.get(offset..).unwrap_or(&[]);
    copy(rest, into);
    rest.len().min(into.len())
}

/// Copies as much as both have. `copy_from_slice` panics where lengths differ, and the compiler keeps the text of that.
pub(super) fn copy(from: &[u8], to: &mut [u8]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}

/// The number of these bytes, little-endian; above eight of them the first are lost.
#[inline(never)] // once for the numbers of every type
pub(crate) fn number(value: &[u8]) -> u64 {
    value.iter().rev().fold(0, |bits, byte| bits << 8 | u64::from(*byte))
}
