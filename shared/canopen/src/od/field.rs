//! Constants of a declaration: address and declaration of each value.
//!
//! `derive(Objects)` makes one of each field that is an object, with the name of the field in capitals: a [`Field`]
//! for a single value, [`Fields`] for an ARRAY, a RECORD and consecutive objects. `derive(Record)` makes a
//! [`SubIndex`] of each field.

use core::marker::PhantomData;

use super::reason::Reason;
use super::{DataType, Entry, Object};
use crate::types::Address;

/// A value: its address and its declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Field {
    at: Address,
    entry: Entry,
}

impl Field {
    /// Makes the constant of an object with a single value.
    ///
    /// # Panics
    /// If the object has several values. In a constant this is a compile error.
    #[track_caller]
    pub const fn of(object: &Object) -> Field {
        Fields::<()>::of(object).sub(0)
    }

    /// Returns the index of the object.
    pub const fn index(self) -> u16 {
        self.at.index
    }

    /// Returns index and sub-index.
    pub const fn address(self) -> Address {
        self.at
    }

    /// Returns the declaration of the value.
    pub const fn entry(&self) -> &Entry {
        &self.entry
    }

    /// Returns the type of the value.
    pub const fn data_type(self) -> DataType {
        self.entry.data_type
    }
}

impl From<Field> for Address {
    fn from(field: Field) -> Address {
        field.at
    }
}

/// An object with several values, or several consecutive objects. `R` is its record, `()` if it has none.
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
    /// Makes the constant of an object.
    pub const fn of(object: &Object) -> Self {
        Fields { index: object.index, count: object.count, entries: object.entries, of: PhantomData }
    }

    /// Returns one of several consecutive objects, counted from zero.
    ///
    /// # Panics
    /// If there is no such object. In a constant this is a compile error.
    #[track_caller]
    pub const fn nth(self, nth: u16) -> Self {
        if nth >= self.count {
            let row = self.refuse(" is the first of ").number(self.count as u32);
            row.text(" in a row, counted from 0: there is no ").number(nth as u32).refuse();
        }
        Fields { index: self.index + nth, count: 1, ..self }
    }

    /// Returns the value of a sub-index.
    ///
    /// # Panics
    /// If there is no such sub-index, or for several consecutive objects. In a constant this is a compile error.
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

    /// Returns the value of a field of its record.
    ///
    /// # Panics
    /// For several consecutive objects or sub-indices. In a constant this is a compile error.
    #[track_caller]
    pub const fn field(self, field: SubIndex<R>) -> Field {
        if field.count != 1 {
            let first = self.refuse(", sub-index ").number(field.sub as u32);
            first.text(": there are several in a row, choose one with `nth`").refuse();
        }
        self.sub(field.sub)
    }

    /// Returns the index of the object.
    ///
    /// # Panics
    /// For several consecutive objects. In a constant this is a compile error.
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

/// A field of a record: one sub-index, or several consecutive ones. `R` is the record.
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
    /// Makes the constant of `count` consecutive sub-indices.
    pub const fn new(sub: u8, count: u8) -> Self {
        SubIndex { sub, count, of: PhantomData }
    }

    /// Returns one of several consecutive sub-indices, counted from zero.
    ///
    /// # Panics
    /// If there is no such sub-index. In a constant this is a compile error.
    #[track_caller]
    pub const fn nth(self, nth: u8) -> Self {
        if nth >= self.count {
            let first = Reason::new("sub-index ").number(self.sub as u32).text(" is the first of ");
            let row = first.number(self.count as u32).text(" in a row, counted from 0: there is no ");
            row.number(nth as u32).refuse();
        }
        SubIndex::new(self.sub + nth, 1)
    }

    /// Returns the sub-index; of several consecutive ones the first.
    pub const fn get(self) -> u8 {
        self.sub
    }
}
