//! The format of a set: a header, then index, sub-index, length and value of each parameter.
//!
//! ```text
//! 'E' 'P' version node-ID | index (u16) sub length value... | index ...
//! ```
//! Numbers are little-endian. A length of FFh is followed by the length itself, a u16. Values pass through a small
//! buffer, so that a long one needs no memory. Integrity is the store's.

use super::note::{BDEFAULT, noted_bdefault};
use super::{Group, ParameterStore, StoreError};
use crate::od::WHOLE;
use crate::od::checked::Found;
use crate::types::{AbortCode, Address, NodeId};

/// The longest value that is stored, bytes.
pub const MAX_VALUE: usize = u16::MAX as usize;

const MAGIC: [u8; 2] = *b"EP";
const VERSION: u8 = 1;
/// Bytes of the header of the set, and of that of a parameter of up to 254 bytes.
const HEADER: usize = 4;
/// A length of 255 bytes and more follows in two bytes.
const LONG: u8 = u8::MAX;
/// Bytes of a value that are copied at once into a new set.
const PART: usize = 64;

/// A parameter's present value.
pub trait Value {
    /// Its length in bytes.
    fn len(&mut self) -> usize;

    /// Whether it has no bytes.
    fn is_empty(&mut self) -> bool {
        self.len() == 0
    }

    /// Copies bytes from `offset` on; returns how many, fewer than `into` holds at the end of the value.
    fn read(&mut self, offset: usize, into: &mut [u8]) -> usize;
}

impl Value for &[u8] {
    fn len(&mut self) -> usize {
        <[u8]>::len(self)
    }

    fn read(&mut self, offset: usize, into: &mut [u8]) -> usize {
        let rest = self.get(offset..).unwrap_or_default();
        into.iter_mut().zip(rest).map(|(to, from)| *to = *from).count()
    }
}

impl Value for Found<'_> {
    fn len(&mut self) -> usize {
        Found::len(self)
    }

    fn read(&mut self, offset: usize, into: &mut [u8]) -> usize {
        Found::read(self, offset, into)
    }
}

/// Shows every parameter that may be stored, with its present value; called twice for each set, with the same values.
pub type Values<'a> = dyn FnMut(&mut dyn FnMut(Address, &mut dyn Value)) + 'a;

/// Puts a stored parameter into the dictionary, with all its checks. After an error the rest of a long value is not given.
pub type Apply<'a> = dyn FnMut(Address, Content<'_>) -> Result<(), AbortCode> + 'a;

/// What is stored of a parameter: up to [`WHOLE`] bytes whole, more in parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content<'a> {
    /// The whole value.
    Whole(&'a [u8]),
    /// A value of this many bytes begins; parts follow, then the end.
    Begin(usize),
    /// The next bytes, and where in the value they begin.
    Part(usize, &'a [u8]),
    /// The value is complete; its length in bytes.
    End(usize),
}

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
    /// Where its value begins.
    start: usize,
    len: usize,
}

impl Parameter {
    /// Where the next one begins.
    const fn next(&self) -> usize {
        self.start.saturating_add(self.len)
    }

    /// Copies the part of the value that begins at `offset`, as much as a buffer takes.
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
    let (mut bytes, mut long) = ([0; HEADER], [0; 2]);
    let mut start = offset.saturating_add(HEADER);
    if start > store.stored_len() {
        return Ok(None);
    }
    store.read(offset, &mut bytes)?;
    let [low, high, sub, len] = bytes;
    let mut len = usize::from(len);
    if len == usize::from(LONG) {
        let at = start;
        start = start.saturating_add(long.len());
        if start > store.stored_len() {
            return Ok(None);
        }
        store.read(at, &mut long)?;
        len = usize::from(u16::from_le_bytes(long));
    }
    let found = Parameter { at: Address::new(u16::from_le_bytes([low, high]), sub), start, len };
    Ok(Some(found).filter(|found| found.next() <= store.stored_len()))
}

/// Applies the stored parameters, before communication starts; the noted Bdefault last.
///
/// # Errors
/// [`StoreError::Hardware`]; what was applied before stays.
pub fn load(store: &mut dyn ParameterStore, node: NodeId, apply: &mut Apply) -> Result<Loaded, StoreError> {
    let (mut applied, mut skipped) = (0_u32, 0_u32);
    let mut count = |is_applied: bool| {
        let count = if is_applied { &mut applied } else { &mut skipped };
        *count = count.saturating_add(1);
    };
    let found = header(store, node)?;
    if let Header::Own = found {
        let mut offset = HEADER;
        while let Some(found) = parameter(store, offset)? {
            count(is_applied(store, &found, apply)?);
            offset = found.next();
        }
        if offset != store.stored_len() {
            count(false);
        }
    }
    let noted = noted_bdefault(store, node);
    if let Some(bus) = noted {
        count(apply(BDEFAULT, Content::Whole(&[bus.bdefault()])).is_ok());
    }
    Ok(match found {
        Header::Foreign { version, node } => Loaded::Foreign { version, node },
        Header::Missing if noted.is_none() => Loaded::Nothing,
        _ => Loaded::Set { applied, skipped },
    })
}

fn is_applied(
    store: &mut dyn ParameterStore,
    found: &Parameter,
    apply: &mut Apply,
) -> Result<bool, StoreError> {
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

/// Saves the present values of a group; the others stay as they are stored. A note that is not of this group becomes part
/// of the set.
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
    let noted = noted_bdefault(store, node).filter(|_| !group.contains(BDEFAULT.index));
    let is_kept = |at: Address| !group.contains(at.index) && (noted.is_none() || at != BDEFAULT);
    if noted.is_some() {
        len = len.saturating_add(stored_len(1));
    }
    kept(store, node, &is_kept, &mut |_, found| {
        len = len.saturating_add(stored_len(found.len));
        Ok(())
    })?;
    values(&mut |at, value| {
        if group.contains(at.index) {
            len = len.saturating_add(stored_len(value.len()));
            fits &= value.len() <= MAX_VALUE;
        }
    });
    if !fits {
        return Err(StoreError::Size);
    }
    store.begin(len)?;
    let [e, p] = MAGIC;
    store.append(&[e, p, VERSION, node.get()])?;
    kept(store, node, &is_kept, &mut |store, found| {
        append_header(store, found.at, found.len)?;
        let (mut buffer, mut offset) = ([0; PART], 0);
        while offset < found.len {
            let part = found.part(store, offset, &mut buffer)?;
            store.append(part)?;
            offset = offset.saturating_add(part.len());
        }
        Ok(())
    })?;
    if let Some(bus) = noted {
        append(store, BDEFAULT, &mut &[bus.bdefault()][..])?;
    }
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

/// Bytes that a parameter with a value of `len` bytes takes.
const fn stored_len(len: usize) -> usize {
    let header = if len < LONG as usize { HEADER } else { HEADER + 2 };
    len.saturating_add(header)
}

fn append_header(store: &mut dyn ParameterStore, at: Address, len: usize) -> Result<(), StoreError> {
    let ([low, high], [len_low, len_high]) = (at.index.to_le_bytes(), (len as u16).to_le_bytes());
    if len < usize::from(LONG) {
        store.append(&[low, high, at.sub, len_low])
    } else {
        store.append(&[low, high, at.sub, LONG, len_low, len_high])
    }
}

fn append(store: &mut dyn ParameterStore, at: Address, value: &mut dyn Value) -> Result<(), StoreError> {
    append_header(store, at, value.len())?;
    let (mut buffer, mut offset) = ([0; PART], 0_usize);
    while offset < value.len() {
        let read = value.read(offset, &mut buffer);
        let part = buffer.get(..read).filter(|part| !part.is_empty()).ok_or(StoreError::Size)?;
        store.append(part)?;
        offset = offset.saturating_add(read);
    }
    Ok(())
}

/// What a new set takes over from the stored one, if that is this node's: the parameters for which `is_kept` holds.
fn kept(
    store: &mut dyn ParameterStore,
    node: NodeId,
    is_kept: &dyn Fn(Address) -> bool,
    keep: &mut dyn FnMut(&mut dyn ParameterStore, &Parameter) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    if !matches!(header(store, node)?, Header::Own) {
        return Ok(());
    }
    let mut offset = HEADER;
    while let Some(found) = parameter(store, offset)? {
        if is_kept(found.at) {
            keep(store, &found)?;
        }
        offset = found.next();
    }
    Ok(())
}
