//! Saves a set in steps of a few words, so that a node goes on with its work between them.
//!
//! ```
//! # use ecss_can::store::{Group, Parameters, ParameterStore, Save, StoreError, StoreRequest};
//! # use ecss_can::types::NodeId;
//! # fn save(
//! #     store: &mut dyn ParameterStore, values: &mut dyn Parameters, node: NodeId,
//! # ) -> Result<(), StoreError> {
//! let mut save = Save::begin(store, node, Group::All, StoreRequest::Save)?;
//! while !save.advance(store, values)? {
//!     // The node does its other work.
//! }
//! # Ok(())
//! # }
//! ```
//! Each value is stored as it is when its turn comes. A value of more than eight bytes takes several steps: one that
//! changes between them may be stored with bytes of both. One that gets shorter fails the save.

use super::note::{BDEFAULT, noted_bdefault};
use super::set::{HEADER, Header, LONG, MAGIC, MAX_VALUE, ROW, VERSION, header, row};
use super::{Group, ParameterStore, StoreError, StoreRequest};
use crate::types::{Address, Bus, NodeId};

/// Most bytes of values that are written in one step.
const STEP: usize = 8;
/// Most rows that are counted in one step.
const ROWS: usize = 4;

/// Parameters of sub-indices in a row with values of one length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Address of the first one.
    pub at: Address,
    /// Number of parameters.
    pub count: u8,
    /// Bytes of each value.
    pub len: usize,
}

impl Row {
    const NONE: Row = Row { at: Address::new(0, 0), count: 0, len: 0 };

    /// Bytes of all values.
    const fn bytes(self) -> usize {
        self.len.saturating_mul(self.count as usize)
    }

    /// Bytes in a set.
    const fn stored_len(self) -> usize {
        let header = if self.len < LONG as usize { ROW } else { ROW + 2 };
        self.bytes().saturating_add(header)
    }

    /// Address behind it.
    const fn next(self) -> Address {
        Address::new(self.at.index, self.at.sub.saturating_add(self.count))
    }
}

/// The parameters that may be stored, in rising order of their addresses.
pub trait Parameters {
    /// The first row at or behind an address.
    fn find(&mut self, from: Address) -> Option<Row>;

    /// Copies bytes of a value from `offset` on; returns how many.
    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> usize;
}

/// A save that runs. The set before is stored until it ends; dropped before, it is a save that was interrupted.
#[derive(Clone, Debug)]
pub struct Save {
    node: NodeId,
    group: Group,
    /// Bytes of the new set as far as they are counted; `None` once it is being written.
    len: Option<usize>,
    /// The noted Bdefault, which becomes part of the set where it is not of the group.
    noted: Option<Bus>,
    /// Offset in the stored set, and the end of the bytes that are copied from there.
    offset: usize,
    end: usize,
    /// Address of the first and of the next row of present values.
    first: Address,
    next: Address,
    /// The values in progress, and how many bytes of the first one are written.
    row: Row,
    written: usize,
}

impl Save {
    /// Begins a set with the present values of a group, or without values of it: then its defaults hold after the next
    /// reset. Those of the other groups are taken from the stored set. A note that is not of this group becomes part of
    /// the set.
    ///
    /// # Errors
    /// [`StoreError`]; what was stored before holds.
    pub fn begin(
        store: &mut dyn ParameterStore,
        node: NodeId,
        group: Group,
        request: StoreRequest,
    ) -> Result<Save, StoreError> {
        // The other groups are copied: with what can be corrected of them.
        if group != Group::All {
            _ = store.check();
        }
        let noted = noted_bdefault(store, node).filter(|_| !group.contains(BDEFAULT.index));
        let len = HEADER.saturating_add(noted.map_or(0, |_| NOTED.stored_len()));
        let first = match request {
            StoreRequest::Save => Address::new(0, 0),
            StoreRequest::Restore => END,
        };
        let mut save = Save {
            node,
            group,
            len: Some(len),
            noted,
            offset: 0,
            end: 0,
            first,
            next: first,
            row: Row::NONE,
            written: 0,
        };
        save.rewind(store)?;
        Ok(save)
    }

    /// Goes back to the first row.
    fn rewind(&mut self, store: &mut dyn ParameterStore) -> Result<(), StoreError> {
        let is_kept = self.group != Group::All && matches!(header(store, self.node)?, Header::Own);
        (self.offset, self.end) = (if is_kept { HEADER } else { usize::MAX }, 0);
        (self.next, self.row) = (self.first, Row::NONE);
        Ok(())
    }

    /// Counts the bytes of some rows; begins the set when all are counted.
    fn count(
        &mut self,
        len: usize,
        store: &mut dyn ParameterStore,
        values: &mut dyn Parameters,
    ) -> Result<(), StoreError> {
        let mut len = len;
        for _ in 0..ROWS {
            if self.find_kept(store)? {
                len = len.saturating_add(self.end.saturating_sub(self.offset));
                self.offset = self.end;
            } else if self.find_row(values) {
                if self.row.len > MAX_VALUE {
                    return Err(StoreError::Size);
                }
                len = len.saturating_add(self.row.stored_len());
            } else {
                self.rewind(store)?;
                self.len = None;
                store.begin(len)?;
                let [e, p] = MAGIC;
                return store.append(&[e, p, VERSION, self.node.get()]);
            }
        }
        self.len = Some(len);
        Ok(())
    }

    /// Counts the bytes of a few rows, or writes up to eight bytes of values. Returns whether the set is stored.
    ///
    /// # Errors
    /// [`StoreError`]; what was stored before holds. [`StoreError::Size`] when a value got shorter.
    pub fn advance(
        &mut self,
        store: &mut dyn ParameterStore,
        values: &mut dyn Parameters,
    ) -> Result<bool, StoreError> {
        if let Some(len) = self.len {
            return self.count(len, store, values).map(|()| false);
        }
        let mut buffer = [0; STEP];
        if self.offset < self.end {
            let rest = self.end.saturating_sub(self.offset).min(STEP);
            let part = buffer.get_mut(..rest).unwrap_or_default();
            store.read(self.offset, part)?;
            store.append(part)?;
            self.offset = self.offset.saturating_add(rest);
        } else if self.find_kept(store)? {
            // Copied by the next steps.
        } else if let Some(bus) = self.noted.take() {
            append_header(store, NOTED)?;
            store.append(&[bus.bdefault()])?;
        } else if self.row.count > 0 {
            let rest = self.row.len.saturating_sub(self.written).min(STEP);
            let part = buffer.get_mut(..rest).unwrap_or_default();
            if values.read(self.row.at, self.written, part) != rest {
                return Err(StoreError::Size);
            }
            store.append(part)?;
            self.written = self.written.saturating_add(rest);
            if self.written >= self.row.len {
                self.written = 0;
                self.row.at.sub = self.row.at.sub.wrapping_add(1);
                self.row.count -= 1;
            }
        } else if self.find_row(values) {
            append_header(store, self.row)?;
        } else {
            return store.commit().map(|()| true);
        }
        Ok(false)
    }

    /// Finds the next row of the stored set that is copied; returns whether there is one.
    fn find_kept(&mut self, store: &mut dyn ParameterStore) -> Result<bool, StoreError> {
        while let Some(found) = row(store, self.offset)? {
            let at = found.at;
            if !self.group.contains(at.index) && (self.noted.is_none() || at != BDEFAULT) {
                self.end = found.next();
                return Ok(true);
            }
            self.offset = found.next();
        }
        (self.offset, self.end) = (usize::MAX, 0);
        Ok(false)
    }

    /// Finds the next row of present values; returns whether there is one.
    fn find_row(&mut self, values: &mut dyn Parameters) -> bool {
        while let Some(row) = values.find(self.next) {
            self.next = row.next();
            if self.group.contains(row.at.index) {
                (self.row, self.written) = (row, 0);
                return true;
            }
        }
        false
    }
}

/// Address behind all parameters.
const END: Address = Address::new(u16::MAX, u8::MAX);

/// The row of a noted Bdefault.
const NOTED: Row = Row { at: BDEFAULT, count: 1, len: 1 };

fn append_header(store: &mut dyn ParameterStore, row: Row) -> Result<(), StoreError> {
    let ([low, high], [len_low, len_high]) = (row.at.index.to_le_bytes(), (row.len as u16).to_le_bytes());
    let is_long = row.len >= usize::from(LONG);
    let len = if is_long { LONG } else { len_low };
    store.append(&[low, high, row.at.sub, row.count, len])?;
    if is_long { store.append(&[len_low, len_high]) } else { Ok(()) }
}
