//! Saves a set in steps of a few words, so that a node continues its work between them.

use core::marker::PhantomData;

use super::set::{HEADER, Header, MAGIC, MAX_VALUE, VERSION, header, row};
use super::{Group, Notes, ParameterStore, StoreError, StoreRequest};
use crate::types::{Address, NodeId};

/// Most bytes of values that are written in one step.
const STEP: usize = 8;

/// Parameters at consecutive sub-indices, with values of one length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Address of the first parameter.
    pub at: Address,
    /// Number of parameters.
    pub count: u8,
    /// Number of bytes of each value.
    pub len: usize,
}

impl Row {
    const NONE: Row = Row { at: Address::new(0, 0), count: 0, len: 0 };

    /// Bytes of all values.
    const fn bytes(self) -> usize {
        self.len.saturating_mul(self.count as usize)
    }

    /// Address behind it.
    const fn next(self) -> Address {
        Address::new(self.at.index, self.at.sub.saturating_add(self.count))
    }
}

/// Parameters that may be stored, in rising order of their addresses.
pub trait Parameters {
    /// Returns the first row at or above an address.
    fn find(&mut self, from: Address) -> Option<Row>;

    /// Copies bytes of a value from `offset` on. Returns their number.
    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> usize;
}

/// A save that is running. The set before it stays stored until it ends. A save that is dropped counts as
/// interrupted.
///
/// Each value is stored as it is when its turn comes. A value of more than eight bytes takes several steps. If it
/// changes between them, it may be stored with bytes of both values. If it becomes shorter, the save fails. The
/// page of the [module](crate::store) has an example.
#[derive(Clone, Debug)]
pub struct Save<N> {
    node: NodeId,
    group: Group,
    /// Bytes of the new set as far as they are counted; `None` once it is being written.
    counted: Option<usize>,
    /// The noted value, which becomes part of the set where it is not of the group.
    noted: Option<u8>,
    /// Offset in the stored set, and the end of the bytes that are copied from there.
    offset: usize,
    end: usize,
    /// Address of the first and of the next row of present values.
    first: Address,
    next: Address,
    /// The values in progress, and how many bytes of the first one are written.
    row: Row,
    written: usize,
    notes: PhantomData<N>,
}

impl<N: Notes> Save<N> {
    /// The row of the noted parameter.
    const NOTED: Row = Row { at: N::PARAMETER, count: 1, len: 1 };

    /// Begins a set with the present values of a group, or without values of it: then its defaults hold after the
    /// next reset. The values of other groups come from the stored set. A note that does not belong to this group
    /// becomes part of the set.
    ///
    /// # Errors
    /// [`StoreError`]. Then the set that was stored before stays.
    pub fn begin(
        store: &mut dyn ParameterStore,
        node: NodeId,
        group: Group,
        request: StoreRequest,
    ) -> Result<Self, StoreError> {
        // The other groups are copied: with what can be corrected of them.
        if group != Group::All {
            _ = store.check();
        }
        let mut save = Save {
            node,
            group,
            first: match request {
                StoreRequest::Save => Address::new(0, 0),
                StoreRequest::Restore => END,
            },
            counted: Some(HEADER),
            noted: None,
            offset: 0,
            end: 0,
            next: END,
            row: Row::NONE,
            written: 0,
            notes: PhantomData,
        };
        save.rewind(store)?;
        Ok(save)
    }

    /// Goes back to the first row.
    fn rewind(&mut self, store: &mut dyn ParameterStore) -> Result<(), StoreError> {
        self.noted = N::noted(store, self.node).filter(|_| !self.group.contains(N::PARAMETER.index));
        let is_kept = self.group != Group::All && matches!(header(store, self.node)?, Header::Own);
        (self.offset, self.end) = (if is_kept { HEADER } else { usize::MAX }, 0);
        self.next = self.first;
        Ok(())
    }

    /// Counts bytes of the set, or writes them.
    fn put(&mut self, store: &mut dyn ParameterStore, bytes: &[u8]) -> Result<(), StoreError> {
        if self.count(bytes.len()) { Ok(()) } else { store.append(bytes) }
    }

    /// Counts bytes while the length of the set is not known; returns whether it did.
    fn count(&mut self, bytes: usize) -> bool {
        let Some(counted) = &mut self.counted else { return false };
        *counted = counted.wrapping_add(bytes);
        true
    }

    fn put_header(&mut self, store: &mut dyn ParameterStore, row: &Row) -> Result<(), StoreError> {
        let &Row { at, count, len } = row;
        let ([low, high], [len_low, len_high]) = (at.index.to_le_bytes(), (len as u16).to_le_bytes());
        self.put(store, &[low, high, at.sub, count, len_low, len_high])
    }

    /// All rows are counted, which begins the set, or written, which ends it.
    fn turn(&mut self, store: &mut dyn ParameterStore) -> Result<bool, StoreError> {
        let Some(len) = self.counted.take() else { return store.commit().map(|()| true) };
        self.rewind(store)?;
        store.begin(len)?;
        let [e, p] = MAGIC;
        store.append(&[e, p, VERSION, self.node.get()])?;
        Ok(false)
    }

    /// Counts the bytes of a row, or writes its header or up to eight bytes of its values. Returns whether the set
    /// is stored.
    ///
    /// # Errors
    /// [`StoreError`]. Then the set that was stored before stays. [`StoreError::Size`] if a value became shorter.
    #[inline(never)] // row `size.pyboard-v11.slave.flash`: five of these save 40 bytes
    pub fn advance(
        &mut self,
        store: &mut dyn ParameterStore,
        values: &mut dyn Parameters,
    ) -> Result<bool, StoreError> {
        let mut buffer = [0; STEP];
        if self.offset < self.end {
            let rest = self.end.wrapping_sub(self.offset);
            if self.count(rest) {
                self.offset = self.end;
                return Ok(false);
            }
            let part = buffer.get_mut(..rest.min(STEP)).unwrap_or_default();
            store.read(self.offset, part)?;
            store.append(part)?;
            self.offset = self.offset.wrapping_add(part.len());
        } else if let Some(found) = row(store, self.offset)? {
            self.end = found.next();
            if self.group.contains(found.at.index) || self.noted.is_some() && found.at == N::PARAMETER {
                self.offset = self.end;
            }
        } else if let Some(value) = self.noted.take() {
            self.put_header(store, &Self::NOTED)?;
            self.put(store, &[value])?;
        } else if self.row.count > 0 {
            if self.count(self.row.bytes()) {
                self.row.count = 0;
                return Ok(false);
            }
            let rest = self.row.len.wrapping_sub(self.written).min(STEP);
            let part = buffer.get_mut(..rest).unwrap_or_default();
            if values.read(self.row.at, self.written, part) != rest {
                return Err(StoreError::Size);
            }
            store.append(part)?;
            self.written = self.written.wrapping_add(rest);
            if self.written >= self.row.len {
                self.written = 0;
                self.row.at.sub = self.row.at.sub.wrapping_add(1);
                self.row.count -= 1;
            }
        } else if let Some(row) = values.find(self.next) {
            self.next = row.next();
            if self.group.contains(row.at.index) {
                if row.len > MAX_VALUE {
                    return Err(StoreError::Size);
                }
                self.put_header(store, &row)?;
                self.row = row;
            }
        } else {
            return self.turn(store);
        }
        Ok(false)
    }
}

/// Address behind all parameters.
const END: Address = Address::new(u16::MAX, u8::MAX);
