//! Value under an index and sub-index, of any type.

use super::{DataType, NamedValue};
use crate::types::AbortCode;

/// Value of the object dictionary: a number, which is a pattern of bits, or [`Bytes`].
pub trait Variable {
    /// Returns the number in the low bits. The bits above are zero. Zero for [`Bytes`].
    fn bits(&self) -> u64 {
        0
    }

    /// Takes a number in the low bits. Does nothing for [`Bytes`], nor for an enumeration that does not have the number.
    fn set_bits(&mut self, _bits: u64) {}

    /// Returns the value if it is a string or a block.
    fn bytes(&mut self) -> Option<&mut dyn Bytes> {
        None
    }
}

/// String or block: a value that has a length of its own.
pub trait Bytes {
    /// Returns the number of bytes that an upload gives now.
    fn len(&self) -> usize;

    /// Returns whether an upload gives no bytes.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Copies bytes from `offset` on. Returns their number.
    fn read(&self, offset: usize, into: &mut [u8]) -> usize;

    /// Takes a whole value.
    ///
    /// # Errors
    /// [`AbortCode::TooLong`], or an error of its type. Then nothing was changed.
    fn write(&mut self, value: &[u8]) -> Result<(), AbortCode>;

    /// Returns the most bytes that a DOMAIN takes; zero for strings.
    fn capacity(&self) -> usize {
        0
    }

    /// Takes the part from `offset` on. Parts come in order.
    ///
    /// # Errors
    /// [`AbortCode::UnsupportedAccess`] if the value does not move in parts. Beyond its capacity:
    /// [`AbortCode::OutOfMemory`] from a DOMAIN, [`AbortCode::TooLong`] from a string.
    fn write_part(&mut self, _offset: usize, _part: &[u8]) -> Result<(), AbortCode> {
        Err(AbortCode::UnsupportedAccess)
    }

    /// Ends a value of `size` bytes after its last part.
    ///
    /// # Errors
    /// [`AbortCode::UnsupportedAccess`] if the value does not move in parts, or the error of a value that is not
    /// accepted.
    fn finish(&mut self, _size: usize) -> Result<(), AbortCode> {
        Err(AbortCode::UnsupportedAccess)
    }

    /// Ends a value that is not complete.
    fn cancel(&mut self) {}
}

/// Properties of a type that a declaration needs.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a type of the object dictionary",
    note = "a struct that derives `Record` needs the word `record`, an array the word `array` or consecutive numbers (`0x6000..`)"
)]
pub trait Typed: Variable {
    /// Type in the dictionary.
    const TYPE: DataType;
    /// Number of bytes of a number, most bytes of a string, zero for a DOMAIN.
    const SIZE: usize;
    /// Values of an enumeration with their names. Empty for every other type.
    const VALUES: &'static [NamedValue] = &[];

    /// Returns whether the low bits, as many as the type has, are a value of the type. Only an enumeration has bits that are none.
    fn is_value(_bits: u64) -> bool {
        true
    }

    /// Returns the value as one of any type.
    #[inline(always)]
    fn as_variable(&mut self) -> &mut dyn Variable
    where
        Self: Sized,
    {
        self
    }
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

/// Returns the number that at most eight little-endian bytes encode.
#[inline(never)] // once for the numbers of every type
pub fn number(value: &[u8]) -> u64 {
    value.iter().rev().fold(0, |bits, byte| bits << 8 | u64::from(*byte))
}
