//! What is declared of an object and its entries: all that an access is checked against.

use super::{DataType, Typed};
use crate::types::AbortCode;

/// Kind of an object (CiA 301 7.4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum ObjectCode {
    /// A block of bytes.
    Domain = 2,
    /// A single value.
    Var = 7,
    /// Values of one type, sub-indices 1 and up.
    Array = 8,
    /// Values of several types.
    Record = 9,
}

/// Who may do what with a value (CiA 301 7.4.5, CiA 306).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Access {
    /// Read only; changes by itself.
    Ro,
    /// Write only.
    Wo,
    /// Read and write.
    Rw,
    /// Read and write, for transmit PDOs.
    Rwr,
    /// Read and write, for receive PDOs.
    Rww,
    /// Never changes.
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

    /// Whether an SDO reads it.
    pub const fn is_readable(self) -> bool {
        !matches!(self, Access::Wo)
    }

    /// Whether an SDO writes it.
    pub const fn is_writable(self) -> bool {
        !matches!(self, Access::Ro | Access::Const)
    }

    /// Whether a transmit PDO may carry it, once it is mappable.
    pub const fn is_for_tpdo(self) -> bool {
        matches!(self, Access::Ro | Access::Rw | Access::Rwr | Access::Const)
    }

    /// Whether a receive PDO may carry it, once it is mappable.
    pub const fn is_for_rpdo(self) -> bool {
        matches!(self, Access::Wo | Access::Rw | Access::Rww)
    }
}

/// Least and greatest value of a number, both allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// Least value.
    pub low: Option<i64>,
    /// Greatest value.
    pub high: Option<i64>,
}

impl Limits {
    /// Whether the low bits of `bits`, as many as the type has, are a number that keeps them.
    ///
    /// # Errors
    /// [`AbortCode::ValueTooHigh`], [`AbortCode::ValueTooLow`].
    pub fn check(&self, data_type: DataType, bits: u64) -> Result<(), AbortCode> {
        let unused = u64::BITS.saturating_sub(u32::from(data_type.bits().unwrap_or(64)));
        let above = bits.wrapping_shl(unused);
        let number = if data_type.is_signed() {
            above.cast_signed().wrapping_shr(unused)
        } else {
            i64::try_from(above.wrapping_shr(unused)).unwrap_or(i64::MAX)
        };
        if self.high.is_some_and(|high| number > high) {
            return Err(AbortCode::ValueTooHigh);
        }
        if self.low.is_some_and(|low| number < low) {
            return Err(AbortCode::ValueTooLow);
        }
        Ok(())
    }
}

/// Whether PDOs may carry a value (CiA 301 7.4.8.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum PdoUse {
    /// They may not.
    No,
    /// They may. A receive PDO whose frame ends before it is not processed.
    Required,
    /// They may. A frame of a receive PDO may end before it: the value is zero then.
    Optional,
}

/// A sub-index, or several in a row of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Entry {
    /// The first sub-index.
    pub sub: u8,
    /// How many sub-indices in a row.
    pub count: u8,
    /// Type of the value.
    pub data_type: DataType,
    /// Access right.
    pub access: Access,
    /// Whether PDOs may carry it.
    pub pdo: PdoUse,
    /// Most bytes of a value; zero for a DOMAIN.
    pub size: u16,
    /// Whether it is a number of at most four bytes that an SDO may read.
    pub fetched: bool,
    /// Whether it is a number of at most four bytes that an SDO may write. A BOOLEAN is none: not every byte is one.
    pub stored: bool,
    /// Whether "save" (1010h) keeps it: what a client may write (`rw`, `rwr`) without `volatile`, and a DOMAIN with `keep`.
    /// What receive PDOs write (`rww`) is not kept.
    pub kept: bool,
    /// Limits, for numbers.
    pub limits: Option<&'static Limits>,
    /// The value itself where it follows from the declaration: sub-index 0 of arrays and records.
    pub fixed: Option<u8>,
}

impl Entry {
    /// An entry for values of type `T`.
    pub const fn of<T: Typed>(sub: u8, count: u8, access: Access) -> Entry {
        let is_short = T::SIZE <= 4 && T::TYPE.bits().is_some();
        Entry {
            sub,
            count,
            data_type: T::TYPE,
            access,
            pdo: PdoUse::No,
            size: T::SIZE as u16,
            fetched: is_short && access.is_readable(),
            stored: is_short && access.is_writable() && !matches!(T::TYPE, DataType::Boolean),
            kept: matches!(access, Access::Rw | Access::Rwr) && !matches!(T::TYPE, DataType::Domain),
            limits: None,
            fixed: None,
        }
    }

    /// Sub-index 0: the highest one supported.
    pub const fn highest(sub: u8) -> Entry {
        Entry { fixed: Some(sub), ..Entry::of::<u8>(0, 1, Access::Const) }
    }

    /// The same with this use in PDOs.
    #[must_use]
    pub const fn for_pdo(self, pdo: PdoUse) -> Entry {
        Entry { pdo, ..self }
    }

    /// Whether PDOs may carry it.
    pub const fn is_mappable(&self) -> bool {
        !matches!(self.pdo, PdoUse::No)
    }

    /// The same, a DOMAIN that "save" keeps. What is none, or what a client may not read and write, does not compile:
    ///
    /// ```compile_fail
    /// # use ecss_can::od::{Access, Entry};
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
        Entry { kept: true, ..self }
    }

    /// The same, a value that "save" does not keep although a client may write it: a command, a counter. What is not kept
    /// anyway does not compile:
    ///
    /// ```compile_fail
    /// # use ecss_can::od::{Access, Entry};
    /// const NOT_KEPT_ANYWAY: Entry = Entry::of::<u8>(0, 1, Access::Ro).volatile();
    /// ```
    #[must_use]
    #[track_caller]
    pub const fn volatile(self) -> Entry {
        assert!(
            self.kept,
            "`volatile` is for `rw` and `rwr`: other values, and a DOMAIN, are not kept without it"
        );
        Entry { kept: false, ..self }
    }

    /// The same within limits; those of a type that is no integer do not compile.
    #[must_use]
    #[track_caller]
    pub const fn within(self, limits: Option<&'static Limits>) -> Entry {
        assert!(limits.is_none() || self.data_type.is_integer(), "only integers have limits");
        Entry { limits, ..self }
    }
}

/// So many sub-indices in a row; more than 254 do not compile.
#[track_caller]
pub const fn sub_indices(count: usize) -> u8 {
    assert!(count <= 254, "an object has at most 254 sub-indices");
    count as u8
}

/// An object, or several with indices in a row and alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Object {
    /// The first index.
    pub index: u16,
    /// How many indices in a row.
    pub count: u16,
    /// Kind.
    pub code: ObjectCode,
    /// Sub-indices, in rising order.
    pub entries: &'static [Entry],
}

/// What an object and its entries are called: for EDS and DCF, not for images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Names {
    /// The object. With several in a row, their number is told where `{}` stands.
    pub object: &'static str,
    /// Its entries, beside [`Object::entries`].
    pub entries: &'static [&'static str],
    /// Index of its structure (DEFSTRUCT), zero for none.
    pub structure: u16,
}
