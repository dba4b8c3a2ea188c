//! Constants of a declaration: address and declaration of each value.
//!
//! `derive(Objects)` makes one of each field that is an object, with the name of the field in capitals: a [`Field`]
//! for a single value, [`Fields`] for an ARRAY, a RECORD and consecutive objects. `derive(Record)` makes a
//! [`SubIndex`] of each field. Each has the type of the value, and the access right of SDO clients.

use core::fmt;
use core::marker::PhantomData;

use super::reason::Reason;
use super::{Access, DataType, Domain, Entry, Object, PdoUse, Readable, Right, Typed, Untyped, Writable};
use crate::types::Address;

/// A value: its address and its declaration. `T` is its type, [`Untyped`] if the constant does not know it. `R` and `W` say
/// what SDO clients may do: [`Readable`] or [`NotReadable`](super::NotReadable), [`Writable`] or
/// [`NotWritable`](super::NotWritable).
pub struct Field<T = Untyped, R = Readable, W = Writable> {
    at: Address,
    entry: Entry,
    of: PhantomData<fn(T, R, W)>,
}

impl<T, R, W> Clone for Field<T, R, W> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T, R, W> Copy for Field<T, R, W> {}

impl<T, R, W> fmt::Debug for Field<T, R, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Field").field("at", &self.at).field("entry", &self.entry).finish()
    }
}

impl<T, R, W> PartialEq for Field<T, R, W> {
    fn eq(&self, other: &Self) -> bool {
        (self.at, self.entry) == (other.at, other.entry)
    }
}

impl<T, R, W> Eq for Field<T, R, W> {}

impl<T, R, W> Field<T, R, W> {
    /// Makes the constant of an object with a single value. The derive macro names its type.
    ///
    /// # Panics
    /// If the object has several values. In a constant this is a compile error.
    #[track_caller]
    pub const fn of(object: &Object) -> Self {
        let Field { at, entry, .. } = Fields::<()>::of(object).sub(0);
        Field { at, entry, of: PhantomData }
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

impl<T: Typed, R: Right, W: Right> Field<T, R, W> {
    /// Makes the constant of a value of a node whose declaration is not here: the data sheet of its maker has type and access
    /// right. [`eds!`](super::eds) makes such constants of an EDS. No PDO carries the value, see [`Field::mappable`].
    ///
    /// ```
    /// use async_canopen::od::{Field, NotWritable, Readable};
    /// use async_canopen::types::Address;
    ///
    /// const TEMPERATURE: Field<i16, Readable, NotWritable> = Field::at(Address::new(0x6000, 0)).mappable();
    /// ```
    ///
    /// # Panics
    /// If clients may neither read nor write the value. In a constant this is a compile error.
    #[track_caller]
    pub const fn at(at: Address) -> Self {
        let access = match (R::GRANTED, W::GRANTED) {
            (true, true) => Access::Rw,
            (true, false) => Access::Ro,
            (false, true) => Access::Wo,
            (false, false) => panic!("clients may read a value, write it, or both"),
        };
        Field { at, entry: Entry::of::<T>(at.sub, 1, access), of: PhantomData }
    }

    /// Returns the constant of a value that PDOs may carry: `PDOMapping=1` in its data sheet.
    ///
    /// # Panics
    /// For a string or a DOMAIN. In a constant this is a compile error.
    #[must_use]
    #[track_caller]
    pub const fn mappable(self) -> Self {
        Field { entry: self.entry.for_pdo(PdoUse::Required), ..self }
    }
}

impl Field {
    /// Makes the constant of a value whose declaration is not here: it moves as bytes, and no PDO carries it.
    pub const fn raw(at: Address) -> Field {
        // A DOMAIN has any length.
        let entry = Entry::of::<Domain<[u8; 0]>>(at.sub, 1, Access::Rw);
        Field { at, entry, of: PhantomData }
    }
}

impl<T, R, W> From<Field<T, R, W>> for Address {
    fn from(field: Field<T, R, W>) -> Address {
        field.at
    }
}

/// An object with several values, or several consecutive objects. `G` is its record, `()` if it has none. `T` is the type
/// of each value outside a record, `R` and `W` as in [`Field`].
#[derive(Debug)]
pub struct Fields<G: ?Sized, T = Untyped, R = Readable, W = Writable> {
    index: u16,
    count: u16,
    entries: &'static [Entry],
    record: PhantomData<fn(&G)>,
    of: PhantomData<fn(T, R, W)>,
}

impl<G: ?Sized, T, R, W> Clone for Fields<G, T, R, W> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<G: ?Sized, T, R, W> Copy for Fields<G, T, R, W> {}

impl<G: ?Sized> Fields<G> {
    /// Returns the value of a sub-index, without its type.
    ///
    /// # Panics
    /// If there is no such sub-index, or for several consecutive objects. In a constant this is a compile error.
    #[track_caller]
    pub const fn sub(self, sub: u8) -> Field {
        self.value(sub)
    }

    /// Returns the value of a field of its record.
    ///
    /// # Panics
    /// For several consecutive objects or sub-indices. In a constant this is a compile error.
    #[track_caller]
    pub const fn field<T, R, W>(self, field: SubIndex<G, T, R, W>) -> Field<T, R, W> {
        if field.count != 1 {
            let first = self.refuse(", sub-index ").number(field.sub as u32);
            first.text(": there are several in a row, choose one with `nth`").refuse();
        }
        let Field { at, entry, .. } = self.value(field.sub);
        Field { at, entry, of: PhantomData }
    }
}

impl<T: Typed, R, W> Fields<(), T, R, W> {
    /// Returns the value of a sub-index: of an ARRAY from 1 on, 0 of one of several consecutive objects.
    ///
    /// # Panics
    /// If there is no such sub-index, or for several consecutive objects. In a constant this is a compile error.
    #[track_caller]
    pub const fn sub(self, sub: u8) -> Field<T, R, W> {
        if sub == 0 && self.entries.len() > 1 {
            self.refuse(" has the number of its elements at sub-index 0: the first one is 1").refuse();
        }
        self.value(sub)
    }
}

impl<G: ?Sized, T, R, W> Fields<G, T, R, W> {
    /// Makes the constant of an object.
    pub const fn of(object: &Object) -> Self {
        Fields {
            index: object.index,
            count: object.count,
            entries: object.entries,
            record: PhantomData,
            of: PhantomData,
        }
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

    #[track_caller]
    const fn value(self, sub: u8) -> Field<T, R, W> {
        self.assert_one();
        let (mut nth, mut last) = (0, 0);
        while nth < self.entries.len() {
            let entry = self.entries[nth];
            if sub >= entry.sub && sub - entry.sub < entry.count {
                return Field { at: Address::new(self.index, sub), entry, of: PhantomData };
            }
            (nth, last) = (nth + 1, entry.sub as u32 + entry.count as u32 - 1);
        }
        let none = self.refuse(" has no sub-index ").number(sub as u32);
        none.text(": its last one is ").number(last).refuse()
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

/// A field of a record: one sub-index, or several consecutive ones. `G` is the record, `T` the type of each value, `R` and `W` as
/// in [`Field`].
#[derive(Debug)]
pub struct SubIndex<G: ?Sized, T = Untyped, R = Readable, W = Writable> {
    sub: u8,
    count: u8,
    record: PhantomData<fn(&G)>,
    of: PhantomData<fn(T, R, W)>,
}

impl<G: ?Sized, T, R, W> Clone for SubIndex<G, T, R, W> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<G: ?Sized, T, R, W> Copy for SubIndex<G, T, R, W> {}

impl<G: ?Sized, T, R, W> SubIndex<G, T, R, W> {
    /// Makes the constant of `count` consecutive sub-indices.
    pub const fn new(sub: u8, count: u8) -> Self {
        SubIndex { sub, count, record: PhantomData, of: PhantomData }
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
