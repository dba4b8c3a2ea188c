//! DOMAIN: a block of bytes that moves in parts.

use super::variable::{copy, copy_from};
use super::{Bytes, DataType, Typed, Variable};
use crate::types::AbortCode;

/// Block in borrowed or owned memory, such as `[u8; 512]` or `&'static mut [u8]`.
///
/// It is empty from the first part of a download until the last one, so that no reader sees a mixture of two values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Domain<S> {
    storage: S,
    len: usize,
}

impl<const N: usize> Domain<[u8; N]> {
    /// Makes an empty block of `N` bytes. A declaration without `default` uses it: arrays of more than 32 bytes do
    /// not implement [`Default`].
    pub const fn unwritten() -> Self {
        Domain::new([0; N])
    }
}

impl<S: AsRef<[u8]> + AsMut<[u8]>> Domain<S> {
    /// Makes an empty block.
    pub const fn new(storage: S) -> Self {
        Domain { storage, len: 0 }
    }

    /// Returns the bytes that were written last.
    pub fn as_bytes(&self) -> &[u8] {
        self.storage.as_ref().get(..self.len).unwrap_or(&[])
    }
}

impl<S: AsRef<[u8]> + AsMut<[u8]>> Variable for Domain<S> {
    fn bytes(&mut self) -> Option<&mut dyn Bytes> {
        Some(self)
    }
}

impl<S: AsRef<[u8]> + AsMut<[u8]>> Bytes for Domain<S> {
    fn len(&self) -> usize {
        self.len
    }

    fn read(&self, offset: usize, into: &mut [u8]) -> usize {
        copy_from(self.as_bytes(), offset, into)
    }

    fn write(&mut self, value: &[u8]) -> Result<(), AbortCode> {
        self.write_part(0, value)?;
        self.finish(value.len())
    }

    fn capacity(&self) -> usize {
        self.storage.as_ref().len()
    }

    fn write_part(&mut self, offset: usize, part: &[u8]) -> Result<(), AbortCode> {
        self.len = 0;
        let rest = self.storage.as_mut().get_mut(offset..).ok_or(AbortCode::OutOfMemory)?;
        let place = rest.get_mut(..part.len()).ok_or(AbortCode::OutOfMemory)?;
        copy(part, place);
        Ok(())
    }

    fn finish(&mut self, size: usize) -> Result<(), AbortCode> {
        self.len = size.min(self.storage.as_ref().len());
        Ok(())
    }
}

impl<S: AsRef<[u8]> + AsMut<[u8]>> Typed for Domain<S> {
    const TYPE: DataType = DataType::Domain;
    /// The storage decides its size.
    const SIZE: usize = 0;
}
