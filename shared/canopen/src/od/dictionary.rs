//! Dictionary: objects are found by index, values are reached by place.

use super::{Declared, Entry, NamedValue, Names, Object, Run, Variable};
use crate::types::{AbortCode, Address};

/// Place of a value: found once by its address, then reached without a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Place {
    /// Number of the object in its dictionary.
    pub object: u16,
    /// Number of the instance, for consecutive objects; otherwise 0.
    pub instance: u16,
    /// Sub-index of the value.
    pub sub: u8,
}

/// Record: several values under one index. Implemented by `#[derive(Record)]`.
pub trait Record {
    /// Entries in rising order of their sub-indices.
    const ENTRIES: &'static [Entry];
    /// Names of the entries, for EDS and DCF.
    const NAMES: &'static [&'static str];
    /// Values with a name of each entry, for EDS and DCF. Entries behind the last have none.
    const VALUES: &'static [&'static [NamedValue]] = &[];
    /// Index of the structure (DEFSTRUCT), zero for none.
    const STRUCTURE: u16 = 0;

    /// Returns the value of a sub-index. `None` if there is none, or if [`Entry::fixed`] is the value.
    fn variable(&mut self, sub: u8) -> Option<&mut dyn Variable>;

    /// Returns the values of the sub-indices from `sub` on in a transmit PDO, if it may carry them.
    fn bits(&self, _sub: u8, _run: Run) -> Option<u64> {
        None
    }

    /// Checks that a whole number, which a client writes, is a value of its type.
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`] for a number that is no value of an enumeration.
    fn check(_sub: u8, _value: &[u8]) -> Result<(), AbortCode> {
        Ok(())
    }

    /// Takes the values of the sub-indices from `sub` on from a receive PDO, if it may carry them and they are
    /// within limits.
    fn set_bits(&mut self, _sub: u8, _run: Run, _bits: u64) -> Option<()> {
        None
    }
}

/// Objects of a node. Implemented by `#[derive(Objects)]`. Groups of objects may contain groups.
pub trait Objects {
    /// Number of objects, including groups. Consecutive objects of one field count as one.
    const COUNT: u16;
    /// Tree of all objects, for constants that check a declaration.
    const DECLARED: &'static Declared;

    /// Returns the object with this index, its number, and the number of the instance for consecutive objects.
    fn object(index: u16) -> Option<(&'static Object, u16, u16)> {
        Self::DECLARED.object(index, &mut 0)
    }

    /// Returns the object that covers an index, otherwise the first one above it.
    fn object_from(index: u16) -> Option<&'static Object> {
        let mut found = None;
        Self::DECLARED.object_from(index, &mut found);
        found
    }

    /// Calls `visit` with every object, in no particular order.
    fn each_object(visit: &mut dyn FnMut(&'static Object)) {
        Self::DECLARED.each_object(visit);
    }

    /// Calls `visit` with every object and its names, in no particular order.
    fn describe(visit: &mut dyn FnMut(&'static Object, &'static Names));

    /// Returns the value at a place. `None` if there is none, or if [`Entry::fixed`] is the value.
    fn variable(&mut self, place: Place) -> Option<&mut dyn Variable>;

    /// Returns the values from a place on in a transmit PDO, in the low bits, if it may carry them.
    fn bits(&self, place: Place, run: Run) -> Option<u64>;

    /// Takes the values from a place on from a receive PDO, in the low bits. `None` if it may not carry them, or
    /// if some are outside their limits or no value of their enumeration; those are not written.
    fn set_bits(&mut self, place: Place, run: Run, bits: u64) -> Option<()>;

    /// Checks a value beyond length and limits. It comes by SDO or from the parameter store, and is whole. A number that is no
    /// value of an enumeration is refused with [`AbortCode::ValueRange`]. Then the function of `#[objects(check = function)]` is
    /// asked.
    ///
    /// Values that move in parts are not checked here: a DOMAIN, and a stored string of more than 256 bytes. Only
    /// the application itself makes such a string.
    ///
    /// # Errors
    /// The abort code to answer. Then the value stays as it is.
    #[inline]
    fn check(&self, _at: Address, _value: &[u8]) -> Result<(), AbortCode> {
        Ok(())
    }

    /// Finds a value by its address.
    ///
    /// # Errors
    /// [`AbortCode::NoObject`], [`AbortCode::NoSubIndex`].
    fn find(at: Address) -> Result<(Place, &'static Entry), AbortCode> {
        let (object, number, instance) = Self::object(at.index).ok_or(AbortCode::NoObject)?;
        let covers = |entry: &&Entry| at.sub.checked_sub(entry.sub).is_some_and(|nth| nth < entry.count);
        let entry = object.entries.iter().find(covers).ok_or(AbortCode::NoSubIndex)?;
        Ok((Place { object: number, instance, sub: at.sub }, entry))
    }
}
