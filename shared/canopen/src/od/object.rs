//! Declaration of an object and its entries: the values that every access is checked against.

use super::{DataType, Limits, NamedValue, Typed};

/// Kind of an object (CiA 301 7.4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum ObjectCode {
    /// A block of bytes.
    Domain = 2,
    /// A single value.
    Var = 7,
    /// Values of one type at the sub-indices 1 and up.
    Array = 8,
    /// Values of several types.
    Record = 9,
}

/// Access right of a value (CiA 301 7.4.5, CiA 306).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Access {
    /// `ro`: read only; the value may change by itself.
    Ro,
    /// `wo`: write only.
    Wo,
    /// `rw`: read and write.
    Rw,
    /// `rwr`: read and write, for transmit PDOs.
    Rwr,
    /// `rww`: read and write, for receive PDOs.
    Rww,
    /// `const`: read only; the value never changes.
    Const,
}

impl Access {
    /// The word of a declaration.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Access::Ro => "ro",
            Access::Wo => "wo",
            Access::Rw => "rw",
            Access::Rwr => "rwr",
            Access::Rww => "rww",
            Access::Const => "constant",
        }
    }

    /// Returns whether an SDO may read the value.
    pub const fn is_readable(self) -> bool {
        !matches!(self, Access::Wo)
    }

    /// Returns whether an SDO may write the value.
    pub const fn is_writable(self) -> bool {
        !matches!(self, Access::Ro | Access::Const)
    }

    /// Returns whether a transmit PDO may carry the value if it is mappable.
    pub const fn is_for_tpdo(self) -> bool {
        matches!(self, Access::Ro | Access::Rw | Access::Rwr | Access::Const)
    }

    /// Returns whether a receive PDO may carry the value if it is mappable.
    pub const fn is_for_rpdo(self) -> bool {
        matches!(self, Access::Wo | Access::Rw | Access::Rww)
    }
}

/// Use of a value in PDOs (CiA 301 7.4.8.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum PdoUse {
    /// PDOs may not carry the value.
    No,
    /// PDOs may carry the value. A receive PDO whose frame ends before it is not processed.
    Required,
    /// PDOs may carry the value. A frame of a receive PDO may end before it. Then the value is zero.
    Optional,
}

/// Declaration of a sub-index, or of several consecutive ones of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Entry {
    /// First sub-index.
    pub sub: u8,
    /// Number of consecutive sub-indices.
    pub count: u8,
    /// Type of the value.
    pub data_type: DataType,
    /// Access right of the value.
    pub access: Access,
    /// Most bytes of a value, zero for a DOMAIN.
    pub size: u16,
    /// Limits of a number. `None`: the type alone limits it.
    pub limits: Option<&'static Limits>,
    marks: u8,
    /// With [`FIXED`].
    value: u8,
}

/// Marks of an entry, together in a byte: an image has a hundred entries.
const FETCHED: u8 = 1;
const STORED: u8 = 1 << 1;
const KEPT: u8 = 1 << 2;
const FIXED: u8 = 1 << 3;
const MAPPABLE: u8 = 1 << 4;
const OPTIONAL: u8 = 1 << 5;

/// A mark that is set if this holds.
const fn mark(mark: u8, holds: bool) -> u8 {
    if holds { mark } else { 0 }
}

impl Entry {
    /// Makes an entry for values of type `T`.
    pub const fn of<T: Typed>(sub: u8, count: u8, access: Access) -> Entry {
        let is_short = T::SIZE <= 4 && T::TYPE.bits().is_some();
        let is_stored = access.is_writable() && !matches!(T::TYPE, DataType::Boolean);
        let is_kept = matches!(access, Access::Rw | Access::Rwr) && !matches!(T::TYPE, DataType::Domain);
        Entry {
            sub,
            count,
            data_type: T::TYPE,
            access,
            size: T::SIZE as u16,
            limits: None,
            marks: mark(FETCHED, is_short && access.is_readable())
                | mark(STORED, is_short && is_stored)
                | mark(KEPT, is_kept),
            value: 0,
        }
    }

    /// Makes the entry of sub-index 0: the highest sub-index supported.
    pub const fn highest(sub: u8) -> Entry {
        Entry { value: sub, ..Entry::of::<u8>(0, 1, Access::Const) }.with(FIXED)
    }

    const fn with(self, marks: u8) -> Entry {
        Entry { marks: self.marks | marks, ..self }
    }

    const fn has(&self, mark: u8) -> bool {
        self.marks & mark != 0
    }

    /// Returns whether it is a number of at most four bytes that an SDO may read.
    pub(crate) const fn is_fetched(&self) -> bool {
        self.has(FETCHED)
    }

    /// Returns whether it is a number of at most four bytes that an SDO may write. A BOOLEAN is not: only some
    /// bytes are valid.
    pub(crate) const fn is_stored(&self) -> bool {
        self.has(STORED)
    }

    /// Returns whether "save" (1010h) stores it. It stores values that a client may write (`rw`, `rwr`) unless
    /// they are `volatile`, and a DOMAIN with `keep`. It does not store values that receive PDOs write (`rww`).
    pub const fn is_kept(&self) -> bool {
        self.has(KEPT)
    }

    /// Returns the value itself if it follows from the declaration: sub-index 0 of arrays and records.
    pub const fn fixed(&self) -> Option<u8> {
        if self.has(FIXED) { Some(self.value) } else { None }
    }

    /// Returns the same entry with this use in PDOs. A string or a DOMAIN does not compile: a mapping names the number of
    /// bits, and theirs is not fixed.
    ///
    /// ```compile_fail
    /// # use async_canopen::od::{Access, Entry, PdoUse, VisibleString};
    /// const TEXT: Entry = Entry::of::<VisibleString<8>>(0, 1, Access::Rw).for_pdo(PdoUse::Required);
    /// ```
    #[must_use]
    #[track_caller]
    pub const fn for_pdo(self, pdo: PdoUse) -> Entry {
        assert!(
            matches!(pdo, PdoUse::No) || self.data_type.bits().is_some(),
            "`pdo` is for numbers, BOOLEANs and times: no PDO carries a string or a DOMAIN, whose size is not fixed"
        );
        match pdo {
            PdoUse::No => self,
            PdoUse::Required => self.with(MAPPABLE),
            PdoUse::Optional => self.with(MAPPABLE | OPTIONAL),
        }
    }

    /// Returns whether PDOs may carry the value.
    pub const fn is_mappable(&self) -> bool {
        self.has(MAPPABLE)
    }

    /// Returns whether a frame of a receive PDO may end before the value: [`PdoUse::Optional`].
    pub(crate) const fn is_optional(&self) -> bool {
        self.has(OPTIONAL)
    }

    /// Returns the same entry for a DOMAIN that "save" stores. An entry that is no DOMAIN, or that a client may
    /// not read and write, does not compile:
    ///
    /// ```compile_fail
    /// # use async_canopen::od::{Access, Entry};
    /// const NO_DOMAIN: Entry = Entry::of::<u8>(0, 1, Access::Rw).keep();
    /// ```
    #[must_use]
    #[track_caller]
    pub const fn keep(self) -> Entry {
        let is_for_clients = matches!(self.access, Access::Rw | Access::Rwr);
        assert!(
            matches!(self.data_type, DataType::Domain) && is_for_clients,
            "`keep` is for a DOMAIN with `rw`: every other value with `rw` or `rwr` is kept without it"
        );
        self.with(KEPT)
    }

    /// Returns the same entry for a value that "save" does not store although a client may write it: a command, a
    /// counter. An entry that "save" does not store anyway does not compile:
    ///
    /// ```compile_fail
    /// # use async_canopen::od::{Access, Entry};
    /// const NOT_KEPT_ANYWAY: Entry = Entry::of::<u8>(0, 1, Access::Ro).volatile();
    /// ```
    #[must_use]
    #[track_caller]
    pub const fn volatile(self) -> Entry {
        assert!(
            self.is_kept(),
            "`volatile` is for `rw` and `rwr`: other values, and a DOMAIN, are not kept without it"
        );
        Entry { marks: self.marks & !KEPT, ..self }
    }

    /// Returns the same entry with limits. It does not compile if the type is no integer, if a limit is no value
    /// of the type, or if `low` is above `high`.
    #[must_use]
    #[track_caller]
    pub const fn within(self, limits: Option<&'static Limits>) -> Entry {
        if let Some(limits) = limits {
            assert!(self.data_type.is_integer(), "only integers have limits");
            limits.assert_fit(self.data_type);
        }
        Entry { limits, ..self }
    }

    /// Returns the same entry for a value whose `default` has these least and greatest numbers. A `default` outside
    /// the limits does not compile. `None`: the numbers are not known.
    #[must_use]
    #[track_caller]
    pub const fn initially(self, numbers: Option<(i128, i128)>) -> Entry {
        if let (Some(limits), Some((least, greatest))) = (self.limits, numbers) {
            limits.assert_default(least);
            limits.assert_default(greatest);
        }
        self
    }
}

/// Returns `count` as a number of sub-indices. More than 254 do not compile.
#[track_caller]
pub const fn sub_indices(count: usize) -> u8 {
    assert!(count <= 254, "an object has at most 254 sub-indices");
    count as u8
}

/// Declaration of an object, or of several alike with consecutive indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Object {
    /// First index of the object.
    pub index: u16,
    /// Number of consecutive indices.
    pub count: u16,
    /// Entries in rising order of their sub-indices.
    pub entries: &'static [Entry],
}

/// Kind of an object and the names of its entries, for EDS and DCF. Images do not have them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Names {
    /// Kind of the object.
    pub code: ObjectCode,
    /// Name of the object. For consecutive objects `{}` stands for the number.
    pub object: &'static str,
    /// Names of the entries, in the order of [`Object::entries`].
    pub entries: &'static [&'static str],
    /// Values with a name of each entry, in the order of [`Object::entries`]: those of an enumeration. Entries behind the last
    /// have none.
    pub values: &'static [&'static [NamedValue]],
    /// Index of the structure (DEFSTRUCT), zero for none.
    pub structure: u16,
}
