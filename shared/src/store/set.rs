//! The format of a set: a header, then index, sub-index, length and value of each parameter.
//!
//! ```text
//! 'E' 'P' version node-ID | index (u16) sub length value... | index ...
//! ```
//! Numbers are little-endian. Integrity is the store's.

use super::{Group, ParameterStore, StoreError};
use crate::nmt::NodeId;
use crate::od::{AbortCode, Address};

/// The longest value that is stored, bytes.
pub const MAX_VALUE: usize = 64;

const MAGIC: [u8; 2] = *b"EP";
const VERSION: u8 = 1;
/// Of the set, and of each parameter.
const HEADER: usize = 4;

/// Shows every parameter that may be stored, with its present value; called twice for each set, with the same values.
pub type Values<'a> = dyn FnMut(&mut dyn FnMut(Address, &[u8])) + 'a;

/// Puts a stored parameter into the dictionary, with all its checks.
pub type Apply<'a> = dyn FnMut(Address, &[u8]) -> Result<(), AbortCode> + 'a;

/// What was found at start-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Loaded {
    /// Nothing is stored: defaults hold.
    Nothing,
    /// The set of another node, or of another format, with its version and Node-ID: defaults hold. COB-IDs follow the
    /// Node-ID, so that a board at another place would disturb its old one. The set stays until the next one is saved.
    Foreign {
        /// Version of the format.
        version: u8,
        /// Node-ID that it was saved under.
        node: u8,
    },
    /// A set of this node.
    Set {
        /// Parameters that hold what was stored.
        applied: u32,
        /// Parameters that the dictionary does not know or does not take, as after a change of firmware: defaults hold.
        skipped: u32,
    },
}

/// One stored parameter.
struct Parameter {
    at: Address,
    value: [u8; MAX_VALUE],
    len: usize,
    /// Where the next one begins.
    next: usize,
}

/// What a header says of its set.
enum Header {
    Missing,
    Foreign { version: u8, node: u8 },
    Own,
}

fn header(store: &mut dyn ParameterStore, own: NodeId) -> Result<Header, StoreError> {
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

/// The parameter at `offset`; `None` at the end, and where no parameter can be.
fn parameter(store: &mut dyn ParameterStore, offset: usize) -> Result<Option<Parameter>, StoreError> {
    let mut bytes = [0; HEADER];
    let start = offset.saturating_add(HEADER);
    if start > store.stored_len() {
        return Ok(None);
    }
    store.read(offset, &mut bytes)?;
    let [low, high, sub, len] = bytes;
    let len = usize::from(len);
    let mut value = [0; MAX_VALUE];
    let next = start.saturating_add(len);
    let Some(into) = value.get_mut(..len).filter(|_| next <= store.stored_len()) else { return Ok(None) };
    store.read(start, into)?;
    Ok(Some(Parameter { at: Address::new(u16::from_le_bytes([low, high]), sub), value, len, next }))
}

/// Applies the stored parameters, before communication starts.
///
/// # Errors
/// [`StoreError::Hardware`]; what was applied before stays.
pub fn load(store: &mut dyn ParameterStore, node: NodeId, apply: &mut Apply) -> Result<Loaded, StoreError> {
    match header(store, node)? {
        Header::Missing => return Ok(Loaded::Nothing),
        Header::Foreign { version, node } => return Ok(Loaded::Foreign { version, node }),
        Header::Own => {}
    }
    let (mut applied, mut skipped) = (0_u32, 0_u32);
    let mut offset = HEADER;
    while let Some(found) = parameter(store, offset)? {
        let value = found.value.get(..found.len).unwrap_or(&[]);
        let count = if apply(found.at, value).is_ok() { &mut applied } else { &mut skipped };
        *count = count.saturating_add(1);
        offset = found.next;
    }
    if offset != store.stored_len() {
        skipped = skipped.saturating_add(1);
    }
    Ok(Loaded::Set { applied, skipped })
}

/// Saves the present values of a group; the others stay as they are stored.
///
/// # Errors
/// [`StoreError`]; what was stored before holds.
pub fn save(
    store: &mut dyn ParameterStore,
    node: NodeId,
    group: Group,
    values: &mut Values,
) -> Result<(), StoreError> {
    let mut len = HEADER;
    let mut fits = true;
    kept(store, node, group, &mut |_, found| {
        len = len.saturating_add(HEADER).saturating_add(found.len);
        Ok(())
    })?;
    values(&mut |at, value| {
        if group.contains(at.index) {
            len = len.saturating_add(HEADER).saturating_add(value.len());
            fits &= value.len() <= MAX_VALUE;
        }
    });
    if !fits {
        return Err(StoreError::Size);
    }
    store.begin(len)?;
    let [e, p] = MAGIC;
    store.append(&[e, p, VERSION, node.get()])?;
    kept(store, node, group, &mut |store, found| {
        append(store, found.at, found.value.get(..found.len).unwrap_or(&[]))
    })?;
    let mut result = Ok(());
    values(&mut |at, value| {
        if group.contains(at.index) && result.is_ok() {
            result = append(store, at, value);
        }
    });
    result?;
    store.commit()
}

/// After the next reset the defaults of a group hold; the other groups stay as they are stored.
///
/// # Errors
/// [`StoreError`]; what was stored before holds.
pub fn restore_defaults(
    store: &mut dyn ParameterStore,
    node: NodeId,
    group: Group,
) -> Result<(), StoreError> {
    save(store, node, group, &mut |_| {})
}

fn append(store: &mut dyn ParameterStore, at: Address, value: &[u8]) -> Result<(), StoreError> {
    let [low, high] = at.index.to_le_bytes();
    let len = u8::try_from(value.len()).map_err(|_| StoreError::Size)?;
    store.append(&[low, high, at.sub, len])?;
    store.append(value)
}

/// What a new set takes over from the stored one: the parameters of the other groups, if the set is this node's.
fn kept(
    store: &mut dyn ParameterStore,
    node: NodeId,
    group: Group,
    keep: &mut dyn FnMut(&mut dyn ParameterStore, &Parameter) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    if !matches!(header(store, node)?, Header::Own) {
        return Ok(());
    }
    let mut offset = HEADER;
    while let Some(found) = parameter(store, offset)? {
        if !group.contains(found.at.index) {
            keep(store, &found)?;
        }
        offset = found.next;
    }
    Ok(())
}
