//! Reads and writes with all that the declaration says: existence, access right, length, limits.

use super::{Entry, Objects, Place, Transfer, Variable, WHOLE};
use crate::types::{AbortCode, Address};

/// A value that was found.
pub struct Found<'a> {
    /// Where it is.
    pub place: Place,
    /// What is declared of it.
    pub entry: &'static Entry,
    /// The value; `None` where [`Entry::fixed`] is it.
    pub variable: Option<&'a mut dyn Variable>,
}

/// Writes a whole value with all checks, those of its owner included.
///
/// # Errors
/// As [`find`], [`Found::write`] and [`Objects::check`]; nothing was changed.
pub fn write<D: Objects>(objects: &mut D, at: Address, value: &[u8]) -> Result<(), AbortCode> {
    find(objects, at)?.accepts(value)?;
    objects.check(at, value)?;
    find(objects, at)?.write(value)
}

/// Finds a value.
///
/// # Errors
/// [`AbortCode::NoObject`], [`AbortCode::NoSubIndex`].
pub fn find<D: Objects>(objects: &mut D, at: Address) -> Result<Found<'_>, AbortCode> {
    let (place, entry) = D::find(at)?;
    Found::at(objects, place, entry)
}

impl<'a> Found<'a> {
    /// A value whose place is known.
    ///
    /// # Errors
    /// [`AbortCode::NoSubIndex`] when there is none.
    pub fn at<D: Objects>(
        objects: &'a mut D,
        place: Place,
        entry: &'static Entry,
    ) -> Result<Self, AbortCode> {
        let variable = objects.variable(place);
        if variable.is_none() && entry.fixed.is_none() {
            return Err(AbortCode::NoSubIndex);
        }
        Ok(Found { place, entry, variable })
    }

    /// Whether, and how, an SDO may read it.
    ///
    /// # Errors
    /// [`AbortCode::WriteOnly`].
    pub fn upload(&self) -> Result<Transfer, AbortCode> {
        if !self.entry.access.is_readable() {
            return Err(AbortCode::WriteOnly);
        }
        let len = self.len();
        Ok(if self.entry.size == 0 || len > WHOLE { Transfer::Stream(len) } else { Transfer::Whole(len) })
    }

    /// Bytes that an upload gives now.
    pub fn len(&self) -> usize {
        self.variable.as_ref().map_or(1, |variable| variable.len())
    }

    /// Whether an upload gives nothing.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Copies bytes from `offset` on; returns how many.
    pub fn read(&self, offset: usize, into: &mut [u8]) -> usize {
        match (&self.variable, self.entry.fixed) {
            (Some(variable), _) => variable.read(offset, into),
            (None, Some(value)) => value.read(offset, into),
            (None, None) => 0,
        }
    }

    /// Whether, and how, an SDO may write it.
    ///
    /// # Errors
    /// [`AbortCode::ReadOnly`], [`AbortCode::TooLong`], [`AbortCode::TooShort`], [`AbortCode::OutOfMemory`].
    pub fn download(&self, size: Option<usize>) -> Result<Transfer, AbortCode> {
        let Some(variable) = self.variable.as_ref().filter(|_| self.entry.access.is_writable()) else {
            return Err(AbortCode::ReadOnly);
        };
        if self.entry.size == 0 {
            let capacity = variable.capacity();
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
        self.variable.as_mut().ok_or(AbortCode::ReadOnly)?.write(value)
    }

    /// Whether a whole value has the right length and keeps its limits.
    ///
    /// # Errors
    /// As [`Found::write`].
    pub fn accepts(&self, value: &[u8]) -> Result<(), AbortCode> {
        self.download(Some(value.len()))?;
        if let Some(limits) = self.entry.limits {
            let bits = value.iter().rev().fold(0, |bits, byte| bits << 8 | u64::from(*byte));
            limits.check(self.entry.data_type, bits)?;
        }
        Ok(())
    }
}
