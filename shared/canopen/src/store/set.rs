//! Format of a set: a header, then rows of parameters.
//!
//! ```text
//! 'E' 'P' version node-ID | index (u16) sub-index count length (u16), values... | index ...
//! ```
//! A *row* has `count` values of one length, at consecutive sub-indices from `sub-index` on. Numbers are
//! little-endian. Values pass through a small buffer, so that a long one needs no memory. The store guards the
//! integrity.

use super::{Notes, ParameterStore, StoreError};
use crate::od::WHOLE;
use crate::types::{AbortCode, Address, NodeId};

/// Most bytes of a value that is stored.
pub const MAX_VALUE: usize = u16::MAX as usize;

pub(super) const MAGIC: [u8; 2] = *b"EP";
pub(super) const VERSION: u8 = 2;
/// Bytes of the header of a set.
pub(super) const HEADER: usize = 4;
/// Bytes of the header of a row.
pub(super) const ROW: usize = 6;

/// Function that puts a stored parameter into the dictionary, with all its checks. After an error it does not get
/// the rest of a long value.
pub type Apply<'a> = dyn FnMut(Address, Content<'_>) -> Result<(), AbortCode> + 'a;

/// Stored value of a parameter: whole up to [`WHOLE`] bytes, otherwise in parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content<'a> {
    /// The whole value.
    Whole(&'a [u8]),
    /// Beginning of a value of this many bytes. Parts and the end follow.
    Begin(usize),
    /// Next bytes of the value, and their offset in it.
    Part(usize, &'a [u8]),
    /// End of the value, with its length in bytes.
    End(usize),
}

/// Result of loading a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Loaded {
    /// Nothing is stored. The defaults hold.
    Nothing,
    /// The set is of another node or has another format. The defaults hold: COB-IDs follow the Node-ID, so a
    /// board at another place would disturb the node at its old place. The set stays until the next one is saved.
    Foreign {
        /// Version of the format.
        version: u8,
        /// Node-ID under which the set was saved.
        node: u8,
    },
    /// The set is of this node.
    Set {
        /// Number of parameters that have their stored value.
        applied: u32,
        /// Number of parameters that the dictionary does not have or does not accept, for example after a change
        /// of firmware. Their defaults hold.
        skipped: u32,
    },
}

/// A stored row.
pub(super) struct Stored {
    /// Address of its first value.
    pub at: Address,
    /// Values that are left.
    count: u8,
    /// Offset of the first of them in the set.
    start: usize,
    /// Bytes of each.
    len: usize,
}

impl Stored {
    /// Returns the offset of the next row.
    pub const fn next(&self) -> usize {
        self.start.saturating_add(self.len.saturating_mul(self.count as usize))
    }

    /// Copies the part of the first value that begins at `offset`, as much as a buffer takes.
    fn part<'a>(
        &self,
        store: &mut dyn ParameterStore,
        offset: usize,
        buffer: &'a mut [u8],
    ) -> Result<&'a [u8], StoreError> {
        let rest = self.len.saturating_sub(offset).min(buffer.len());
        let into = buffer.get_mut(..rest).unwrap_or_default();
        store.read(self.start.saturating_add(offset), into)?;
        Ok(into)
    }
}

/// Owner of a set, by its header.
pub(super) enum Header {
    Missing,
    Foreign { version: u8, node: u8 },
    Own,
}

pub(super) fn header(store: &mut dyn ParameterStore, own: NodeId) -> Result<Header, StoreError> {
    let mut bytes = [0; HEADER];
    if store.stored_len() < HEADER {
        return Ok(Header::Missing);
    }
    store.read(0, &mut bytes)?;
    let [e, p, version, node] = bytes;
    Ok(if [e, p] != MAGIC {
        Header::Missing
    } else if version != VERSION || node != own.get() {
        Header::Foreign { version, node }
    } else {
        Header::Own
    })
}

/// The row at `offset`; `None` at the end, and where no row can be.
pub(super) fn row(store: &mut dyn ParameterStore, offset: usize) -> Result<Option<Stored>, StoreError> {
    let mut bytes = [0; ROW];
    let start = offset.saturating_add(ROW);
    if start > store.stored_len() {
        return Ok(None);
    }
    store.read(offset, &mut bytes)?;
    let [low, high, sub, count, len_low, len_high] = bytes;
    let len = u16::from_le_bytes([len_low, len_high]).into();
    let found = Stored { at: Address::new(u16::from_le_bytes([low, high]), sub), count, start, len };
    Ok(Some(found).filter(|found| found.next() <= store.stored_len()))
}

/// Applies the stored parameters before communication starts. The noted one comes last.
///
/// # Errors
/// [`StoreError::Hardware`]. Parameters that were applied before stay.
pub fn load<N: Notes>(
    store: &mut dyn ParameterStore,
    node: NodeId,
    apply: &mut Apply,
) -> Result<Loaded, StoreError> {
    let (mut applied, mut skipped) = (0_u32, 0_u32);
    let mut count = |is_applied: bool| {
        let count = if is_applied { &mut applied } else { &mut skipped };
        *count = count.saturating_add(1);
    };
    let found = header(store, node)?;
    if let Header::Own = found {
        let mut offset = HEADER;
        while let Some(mut found) = row(store, offset)? {
            offset = found.next();
            while found.count > 0 {
                count(is_applied(store, &found, apply)?);
                found.at.sub = found.at.sub.wrapping_add(1);
                found.start = found.start.saturating_add(found.len);
                found.count -= 1;
            }
        }
        if offset != store.stored_len() {
            count(false);
        }
    }
    let noted = N::noted(store, node);
    if let Some(value) = noted {
        count(apply(N::PARAMETER, Content::Whole(&[value])).is_ok());
    }
    Ok(match found {
        Header::Foreign { version, node } => Loaded::Foreign { version, node },
        Header::Missing if noted.is_none() => Loaded::Nothing,
        _ => Loaded::Set { applied, skipped },
    })
}

fn is_applied(store: &mut dyn ParameterStore, found: &Stored, apply: &mut Apply) -> Result<bool, StoreError> {
    let mut buffer = [0; WHOLE];
    let mut offset = 0;
    if found.len <= WHOLE {
        return Ok(apply(found.at, Content::Whole(found.part(store, 0, &mut buffer)?)).is_ok());
    }
    let mut is_taken = apply(found.at, Content::Begin(found.len)).is_ok();
    while is_taken && offset < found.len {
        let part = found.part(store, offset, &mut buffer)?;
        is_taken = apply(found.at, Content::Part(offset, part)).is_ok();
        offset = offset.saturating_add(part.len());
    }
    Ok(is_taken && apply(found.at, Content::End(found.len)).is_ok())
}
