//! A dictionary: objects found by index, values by place.

use super::{Declared, Entry, Names, Object, Run, Variable};
use crate::types::{AbortCode, Address};

/// Where a value is: found once by its address, then reached without searching.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Place {
    /// Number of the object in its dictionary.
    pub object: u16,
    /// Which of several objects in a row.
    pub instance: u16,
    /// Sub-index.
    pub sub: u8,
}

/// A structure of values under one index; implemented by `#[derive(Record)]`.
pub trait Record {
    /// Sub-indices, in rising order.
    const ENTRIES: &'static [Entry];
    /// What they are called.
    const NAMES: &'static [&'static str];
    /// Index of the structure (DEFSTRUCT), zero for none.
    const STRUCTURE: u16 = 0;

    /// The value of a sub-index; `None` where there is none, or where [`Entry::fixed`] is the value.
    fn variable(&mut self, sub: u8) -> Option<&mut dyn Variable>;

    /// The values of sub-indices from `sub` on in a transmit PDO, if that may carry them.
    fn bits(&self, _sub: u8, _run: Run) -> Option<u64> {
        None
    }

    /// Takes the values of sub-indices from `sub` on from a receive PDO, if that may carry them and limits are kept.
    fn set_bits(&mut self, _sub: u8, _run: Run, _bits: u64) -> Option<()> {
        None
    }
}

/// Objects of a node; implemented by `#[derive(Objects)]`. Groups of objects nest.
pub trait Objects {
    /// How many there are, groups included; several in a row count as one.
    const COUNT: u16;
    /// All of them, for constants that check a declaration.
    const DECLARED: &'static Declared;

    /// The object with this index, its number, and which it is of several in a row.
    fn object(index: u16) -> Option<(&'static Object, u16, u16)> {
        Self::DECLARED.object(index, &mut 0)
    }

    /// The object that covers an index, else the first one behind it.
    fn object_from(index: u16) -> Option<&'static Object> {
        let mut found = None;
        Self::DECLARED.object_from(index, &mut found);
        found
    }

    /// Every object, in no particular order.
    fn each_object(visit: &mut dyn FnMut(&'static Object)) {
        Self::DECLARED.each_object(visit);
    }

    /// Every object with its names, in no particular order.
    fn describe(visit: &mut dyn FnMut(&'static Object, &'static Names));

    /// The value at a place; `None` where there is none, or where [`Entry::fixed`] is the value.
    fn variable(&mut self, place: Place) -> Option<&mut dyn Variable>;

    /// The values from a place on in a transmit PDO, in the low bits, if that may carry them.
    fn bits(&self, place: Place, run: Run) -> Option<u64>;

    /// Takes the values from a place on from a receive PDO, the low bits, if that may carry them. `None` if not, and when
    /// some do not keep their limits, which are not written.
    fn set_bits(&mut self, place: Place, run: Run, bits: u64) -> Option<()>;

    /// Whether a value may be written by SDO, or come from the parameter store, beyond what its declaration says: asked
    /// with a whole value that keeps type and limits. `#[objects(check = function)]` on a declaration gives one. What moves in
    /// parts is not asked about: a DOMAIN, and a stored string of more than 256 bytes, which only the application itself makes.
    ///
    /// # Errors
    /// The abort code to answer; the value stays as it is.
    #[inline]
    fn check(&self, _at: Address, _value: &[u8]) -> Result<(), AbortCode> {
        Ok(())
    }

    /// Finds a value.
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
