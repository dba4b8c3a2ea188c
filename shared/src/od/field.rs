//! Constants of a declaration: the address of each value, and what is declared of it.
//!
//! `derive(Objects)` makes one of each field that is an object, named as the field in capitals: a [`Field`] of a single value,
//! [`Fields`] of an ARRAY, a RECORD and of objects in a row. `derive(Record)` makes a [`SubIndex`] of each field.

use core::marker::PhantomData;

use super::reason::Reason;
use super::{DataType, Entry, Object};
use crate::types::Address;

/// A value: its address, and what is declared of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Field {
    at: Address,
    entry: Entry,
}

impl Field {
    /// The value of an object that has no other.
    ///
    /// # Panics
    /// When the object has several; a constant does not compile then.
    #[track_caller]
    pub const fn of(object: &Object) -> Field {
        Fields::<()>::of(object).sub(0)
    }

    /// The index.
    pub const fn index(self) -> u16 {
        self.at.index
    }

    /// Index and sub-index.
    pub const fn address(self) -> Address {
        self.at
    }

    /// What is declared of it.
    pub const fn entry(&self) -> &Entry {
        &self.entry
    }

    /// Type of the value.
    pub const fn data_type(self) -> DataType {
        self.entry.data_type
    }
}

impl From<Field> for Address {
    fn from(field: Field) -> Address {
        field.at
    }
}

/// An object with several values, or several objects in a row. `R` is its record, `()` where there is none.
#[derive(Debug)]
pub struct Fields<R: ?Sized> {
    index: u16,
    count: u16,
    entries: &'static [Entry],
    of: PhantomData<fn(&R)>,
}

impl<R: ?Sized> Clone for Fields<R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: ?Sized> Copy for Fields<R> {}

impl<R: ?Sized> Fields<R> {
    /// The values of an object.
    pub const fn of(object: &Object) -> Self {
        Fields { index: object.index, count: object.count, entries: object.entries, of: PhantomData }
    }

    /// One of several in a row, counted from zero.
    ///
    /// # Panics
    /// When there is none; a constant does not compile then.
    #[track_caller]
    pub const fn nth(self, nth: u16) -> Self {
        if nth >= self.count {
            let row = self.refuse(" is the first of ").number(self.count as u32);
            row.text(" in a row, counted from 0: there is no ").number(nth as u32).refuse();
        }
        Fields { index: self.index + nth, count: 1, ..self }
    }

    /// The value of a sub-index.
    ///
    /// # Panics
    /// When there is none, or for several objects in a row; a constant does not compile then.
    #[track_caller]
    pub const fn sub(self, sub: u8) -> Field {
        self.assert_one();
        let (mut nth, mut last) = (0, 0);
        while nth < self.entries.len() {
            let entry = self.entries[nth];
            if sub >= entry.sub && sub - entry.sub < entry.count {
                return Field { at: Address::new(self.index, sub), entry };
            }
            (nth, last) = (nth + 1, entry.sub as u32 + entry.count as u32 - 1);
        }
        let none = self.refuse(" has no sub-index ").number(sub as u32);
        none.text(": its last one is ").number(last).refuse()
    }

    /// The value of a field of its record.
    ///
    /// # Panics
    /// For several in a row; a constant does not compile then.
    #[track_caller]
    pub const fn field(self, field: SubIndex<R>) -> Field {
        if field.count != 1 {
            let first = self.refuse(", sub-index ").number(field.sub as u32);
            first.text(": there are several in a row, choose one with `nth`").refuse();
        }
        self.sub(field.sub)
    }

    /// The index.
    ///
    /// # Panics
    /// For several objects in a row; a constant does not compile then.
    #[track_caller]
    pub const fn index(self) -> u16 {
        self.assert_one();
        self.index
    }

    #[track_caller]
    const fn assert_one(&self) {
        if self.count != 1 {
            self.refuse(": there are several objects in a row, choose one with `nth`").refuse();
        }
    }

    const fn refuse(&self, reason: &str) -> Reason {
        Reason::new("object ").hex(self.index, 4).text(reason)
    }
}

/// A field of a record, or several in a row. `R` is the record.
#[derive(Debug)]
pub struct SubIndex<R: ?Sized> {
    sub: u8,
    count: u8,
    of: PhantomData<fn(&R)>,
}

impl<R: ?Sized> Clone for SubIndex<R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: ?Sized> Copy for SubIndex<R> {}

impl<R: ?Sized> SubIndex<R> {
    /// `count` sub-indices in a row.
    pub const fn new(sub: u8, count: u8) -> Self {
        SubIndex { sub, count, of: PhantomData }
    }

    /// One of several in a row, counted from zero.
    ///
    /// # Panics
    /// When there is none; a constant does not compile then.
    #[track_caller]
    pub const fn nth(self, nth: u8) -> Self {
        if nth >= self.count {
            let first = Reason::new("sub-index ").number(self.sub as u32).text(" is the first of ");
            let row = first.number(self.count as u32).text(" in a row, counted from 0: there is no ");
            row.number(nth as u32).refuse();
        }
        SubIndex::new(self.sub + nth, 1)
    }

    /// The sub-index, of several in a row the first.
    pub const fn get(self) -> u8 {
        self.sub
    }
}
