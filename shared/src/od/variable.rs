//! A value under an index and sub-index, whatever its type.

use super::DataType;
use crate::types::AbortCode;

/// A value of the object dictionary, little-endian at its surface.
pub trait Variable {
    /// Bytes that an upload gives now.
    fn len(&self) -> usize;

    /// Whether an upload gives nothing.
    fn is_empty(&self) -> bool
    where
        Self: Sized,
    {
        self.len() == 0
    }

    /// Copies bytes from `offset` on; returns how many.
    fn read(&self, offset: usize, into: &mut [u8]) -> usize;

    /// Takes a whole value.
    ///
    /// # Errors
    /// [`AbortCode::TooLong`], [`AbortCode::TooShort`], or what its type forbids; nothing was changed.
    fn write(&mut self, value: &[u8]) -> Result<(), AbortCode>;

    /// The value in a PDO, in the low bits; those above are zero. Zero for types without fixed size.
    fn bits(&self) -> u64 {
        0
    }

    /// Takes the value of a PDO, the low bits. Nothing happens to types without fixed size.
    fn set_bits(&mut self, _bits: u64) {}

    /// Most bytes that a DOMAIN takes; zero for all other types.
    fn capacity(&self) -> usize {
        0
    }

    /// Takes a part of a DOMAIN or of a string, from `offset` on; the parts come in order.
    ///
    /// # Errors
    /// [`AbortCode::UnsupportedAccess`] for all other types; beyond its capacity [`AbortCode::OutOfMemory`] from a DOMAIN,
    /// [`AbortCode::TooLong`] from a string.
    fn write_part(&mut self, _offset: usize, _part: &[u8]) -> Result<(), AbortCode> {
        Err(AbortCode::UnsupportedAccess)
    }

    /// All parts were written, `size` bytes.
    ///
    /// # Errors
    /// [`AbortCode::UnsupportedAccess`] for types that take no parts, or what is wrong with the value.
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
    /// Most bytes of a value.
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

/// Copies from the middle of the low `size` bytes of a number; returns how many bytes.
#[inline(never)] // once for the numbers of every type
pub(super) fn copy_bits(bits: u64, size: usize, offset: usize, into: &mut [u8]) -> usize {
    let count = size.saturating_sub(offset).min(into.len());
    let bytes = bits.to_le_bytes();
    for (to, from) in into.iter_mut().zip(bytes.iter().skip(offset)).take(count) {
        *to = *from;
    }
    count
}

/// The low `N` bytes of a number from exactly `N` bytes.
///
/// # Errors
/// [`AbortCode::TooLong`], [`AbortCode::TooShort`].
#[inline(never)] // once for the numbers of every type
pub(super) fn exactly(value: &[u8], size: usize) -> Result<u64, AbortCode> {
    match value.len().cmp(&size) {
        core::cmp::Ordering::Less => Err(AbortCode::TooShort),
        core::cmp::Ordering::Greater => Err(AbortCode::TooLong),
        core::cmp::Ordering::Equal => {
            Ok(value.iter().rev().fold(0, |bits, byte| bits << 8 | u64::from(*byte)))
        }
    }
}
