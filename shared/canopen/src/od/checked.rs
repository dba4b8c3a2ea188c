//! Reads and writes with all checks of the declaration: existence, access right, length, limits.

use super::variable::{copy_from, number};
use super::{Bytes, DataType, Entry, Objects, Place, Transfer, Typed, Variable, WHOLE};
use crate::types::{AbortCode, Address};

/// Value that was found by its address.
pub struct Found<'a> {
    /// Place of the value in the dictionary.
    pub place: Place,
    /// Declaration of the value.
    pub entry: &'static Entry,
    /// The value itself. `None` if [`Entry::fixed`] is the value.
    pub variable: Option<&'a mut dyn Variable>,
}

/// Writes a whole value with all checks, including those of its owner.
///
/// # Errors
/// As [`find`], [`Found::write`] and [`Objects::check`]. Then nothing was changed.
pub fn write<D: Objects>(objects: &mut D, at: Address, value: &[u8]) -> Result<(), AbortCode> {
    find(objects, at)?.accepts(value)?;
    objects.check(at, value)?;
    find(objects, at)?.take(value)
}

/// Checks that a whole number is a value of type `T`. If it is meant for another object or sub-index, so that `is_meant` is
/// `false`, it is not checked. The derive macros call this.
///
/// # Errors
/// [`AbortCode::ValueRange`] for a number that is no value of an enumeration.
#[inline] // row `instructions.sdo_download`: nothing is left of it for other types
pub fn value_of<T: Typed>(is_meant: bool, value: &[u8]) -> Result<(), AbortCode> {
    if T::VALUES.is_empty() || !is_meant || T::is_value(number(value)) {
        Ok(())
    } else {
        Err(AbortCode::ValueRange)
    }
}

/// Finds a value by its address.
///
/// # Errors
/// [`AbortCode::NoObject`], [`AbortCode::NoSubIndex`].
pub fn find<D: Objects>(objects: &mut D, at: Address) -> Result<Found<'_>, AbortCode> {
    let (place, entry) = D::find(at)?;
    Found::at(objects, place, entry)
}

impl<'a> Found<'a> {
    /// Returns the value at a known place.
    ///
    /// # Errors
    /// [`AbortCode::NoSubIndex`] if there is no such value.
    pub fn at<D: Objects>(
        objects: &'a mut D,
        place: Place,
        entry: &'static Entry,
    ) -> Result<Self, AbortCode> {
        let variable = objects.variable(place);
        if variable.is_none() && entry.fixed().is_none() {
            return Err(AbortCode::NoSubIndex);
        }
        Ok(Found { place, entry, variable })
    }

    /// Returns the value if it is a string or a block.
    pub fn bytes(&mut self) -> Option<&mut dyn Bytes> {
        self.variable.as_mut()?.bytes()
    }

    /// Begins an SDO upload: checks the access right, and returns the way in which the value moves.
    ///
    /// # Errors
    /// [`AbortCode::WriteOnly`].
    pub fn upload(&mut self) -> Result<Transfer, AbortCode> {
        if !self.entry.access.is_readable() {
            return Err(AbortCode::WriteOnly);
        }
        let len = self.upload_len();
        Ok(if self.entry.size == 0 || len > WHOLE { Transfer::Stream(len) } else { Transfer::Whole(len) })
    }

    /// Returns the number of bytes that an upload gives now.
    pub fn upload_len(&mut self) -> usize {
        let size = self.entry.size.into();
        self.bytes().map_or(size, |bytes| bytes.len())
    }

    /// Copies bytes from `offset` on. Returns their number.
    pub fn read(&mut self, offset: usize, into: &mut [u8]) -> usize {
        if let Some(bytes) = self.bytes() {
            return bytes.read(offset, into);
        }
        let fixed = u64::from(self.entry.fixed().unwrap_or(0));
        let bits = self.variable.as_ref().map_or(fixed, |variable| variable.bits()).to_le_bytes();
        copy_from(bits.get(..self.entry.size.into()).unwrap_or(&bits), offset, into)
    }

    /// Begins an SDO download: checks access right and size, and returns the way in which the value moves.
    ///
    /// # Errors
    /// [`AbortCode::ReadOnly`], [`AbortCode::TooLong`], [`AbortCode::TooShort`], [`AbortCode::OutOfMemory`].
    pub fn download(&mut self, size: Option<usize>) -> Result<Transfer, AbortCode> {
        if self.variable.is_none() || !self.entry.access.is_writable() {
            return Err(AbortCode::ReadOnly);
        }
        if self.entry.size == 0 {
            let capacity = self.bytes().map_or(0, |bytes| bytes.capacity());
            let fits = size.is_none_or(|size| size <= capacity);
            return if fits { Ok(Transfer::Stream(capacity)) } else { Err(AbortCode::OutOfMemory) };
        }
        let most = usize::from(self.entry.size);
        match size {
            Some(size) if size > most => Err(AbortCode::TooLong),
            Some(size) if self.entry.data_type.size().is_some_and(|least| size < least) => {
                Err(AbortCode::TooShort)
            }
            _ => Ok(Transfer::Whole(most)),
        }
    }

    /// Writes a whole value.
    ///
    /// # Errors
    /// As [`Found::download`], and [`AbortCode::ValueTooLow`], [`AbortCode::ValueTooHigh`], [`AbortCode::ValueRange`].
    pub fn write(&mut self, value: &[u8]) -> Result<(), AbortCode> {
        self.accepts(value)?;
        self.take(value)
    }

    /// Writes a whole value that was accepted.
    ///
    /// # Errors
    /// [`AbortCode::ReadOnly`] for an entry without a variable, or the error of a string that does not accept the
    /// bytes.
    pub fn take(&mut self, value: &[u8]) -> Result<(), AbortCode> {
        let variable = self.variable.as_mut().ok_or(AbortCode::ReadOnly)?;
        if let Some(bytes) = variable.bytes() {
            return bytes.write(value);
        }
        variable.set_bits(number(value));
        Ok(())
    }

    /// Checks the length and the limits of a whole value.
    ///
    /// # Errors
    /// As [`Found::write`].
    pub(crate) fn accepts(&mut self, value: &[u8]) -> Result<(), AbortCode> {
        self.download(Some(value.len()))?;
        let bits = number(value);
        // One byte over SDO, of which CiA 301 7.1.4.4 knows two values.
        if self.entry.data_type == DataType::Boolean && bits > 1 {
            return Err(AbortCode::ValueRange);
        }
        self.entry.limits.map_or(Ok(()), |limits| limits.check(self.entry.data_type, bits))
    }
}
