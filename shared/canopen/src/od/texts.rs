//! Strings: VISIBLE_STRING, OCTET_STRING, UNICODE_STRING.
//!
//! The declaration gives their capacity. A client reads a string of any length, and writes at most 256 bytes
//! ([`WHOLE`](super::WHOLE)), because the check of the owner needs the whole value. A DOMAIN takes more. "Save"
//! stores strings of any length, also those that the application itself wrote.

use super::variable::copy_from;
use super::{Bytes, DataType, Typed, Variable};
use crate::types::AbortCode;

/// A text that never changes.
impl Variable for &'static str {
    fn bytes(&mut self) -> Option<&mut dyn Bytes> {
        Some(self)
    }
}

impl Bytes for &'static str {
    fn len(&self) -> usize {
        str::len(self)
    }

    fn read(&self, offset: usize, into: &mut [u8]) -> usize {
        copy_from(self.as_bytes(), offset, into)
    }

    fn write(&mut self, _value: &[u8]) -> Result<(), AbortCode> {
        Err(AbortCode::ReadOnly)
    }
}

impl Typed for &'static str {
    const TYPE: DataType = DataType::VisibleString;
    const SIZE: usize = 255;
}

/// Bytes that never change.
impl Variable for &'static [u8] {
    fn bytes(&mut self) -> Option<&mut dyn Bytes> {
        Some(self)
    }
}

impl Bytes for &'static [u8] {
    fn len(&self) -> usize {
        <[u8]>::len(self)
    }

    fn read(&self, offset: usize, into: &mut [u8]) -> usize {
        copy_from(self, offset, into)
    }

    fn write(&mut self, _value: &[u8]) -> Result<(), AbortCode> {
        Err(AbortCode::ReadOnly)
    }
}

impl Typed for &'static [u8] {
    const TYPE: DataType = DataType::OctetString;
    const SIZE: usize = 255;
}

/// At most `N` bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Buffer<const N: usize> {
    len: u16,
    /// Zero at and above `len`, so that equal strings compare equal.
    bytes: [u8; N],
}

impl<const N: usize> Buffer<N> {
    const fn empty() -> Self {
        Buffer { len: 0, bytes: [0; N] }
    }

    fn get(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or(&self.bytes)
    }

    fn set(&mut self, value: &[u8]) -> Result<(), AbortCode> {
        if value.len() > N {
            return Err(AbortCode::TooLong);
        }
        *self = Buffer::empty();
        self.len = value.len() as u16;
        for (slot, byte) in self.bytes.iter_mut().zip(value) {
            *slot = *byte;
        }
        Ok(())
    }
}

/// In parts: empty from the first one until the last is in.
impl<const N: usize> Buffer<N> {
    fn set_part(&mut self, offset: usize, part: &[u8]) -> Result<(), AbortCode> {
        if offset == 0 {
            *self = Buffer::empty();
        }
        let rest = self.bytes.get_mut(offset..).ok_or(AbortCode::TooLong)?;
        rest.get_mut(..part.len()).ok_or(AbortCode::TooLong)?.copy_from_slice(part);
        Ok(())
    }
}

/// Defines a string type with a capacity of `N` bytes. Its rule decides which bytes it accepts.
macro_rules! string {
    ($(#[$doc:meta])* $name:ident, $data_type:ident, $rule:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub struct $name<const N: usize>(Buffer<N>);

        impl<const N: usize> $name<N> {
            /// An empty string.
            pub const fn empty() -> Self {
                $name(Buffer::empty())
            }

            /// A string of these bytes; `None` when they are too many or not allowed in this type.
            pub fn new(value: &[u8]) -> Option<Self> {
                let mut string = Self::empty();
                string.write(value).ok()?;
                Some(string)
            }

            /// Its bytes.
            pub fn as_bytes(&self) -> &[u8] {
                self.0.get()
            }
        }

        impl<const N: usize> Default for $name<N> {
            fn default() -> Self {
                Self::empty()
            }
        }

        impl<const N: usize> Variable for $name<N> {
            fn bytes(&mut self) -> Option<&mut dyn Bytes> {
                Some(self)
            }
        }

        impl<const N: usize> Bytes for $name<N> {
            fn len(&self) -> usize {
                self.0.get().len()
            }

            fn read(&self, offset: usize, into: &mut [u8]) -> usize {
                copy_from(self.0.get(), offset, into)
            }

            fn write(&mut self, value: &[u8]) -> Result<(), AbortCode> {
                let rule: fn(&[u8]) -> Result<(), AbortCode> = $rule;
                rule(value)?;
                self.0.set(value)
            }

            fn write_part(&mut self, offset: usize, part: &[u8]) -> Result<(), AbortCode> {
                self.0.set_part(offset, part)
            }

            fn finish(&mut self, size: usize) -> Result<(), AbortCode> {
                let rule: fn(&[u8]) -> Result<(), AbortCode> = $rule;
                rule(self.0.bytes.get(..size).ok_or(AbortCode::TooLong)?)?;
                self.0.len = size as u16;
                Ok(())
            }

            fn cancel(&mut self) {
                *self = Self::empty();
            }
        }

        impl<const N: usize> Typed for $name<N> {
            const TYPE: DataType = DataType::$data_type;
            const SIZE: usize = N;
        }
    };
}

string!(
    /// VISIBLE_STRING of at most `N` characters: 00h and 20h to 7Eh (CiA 301 7.1.6.3).
    VisibleString,
    VisibleString,
    |value| {
        let visible = value.iter().all(|byte| matches!(byte, 0 | 0x20..=0x7E));
        if visible { Ok(()) } else { Err(AbortCode::ValueRange) }
    }
);
string!(
    /// OCTET_STRING of at most `N` bytes (CiA 301 7.1.6.2).
    OctetString,
    OctetString,
    |_| Ok(())
);
string!(
    /// UNICODE_STRING in at most `N` bytes, two for each code unit (CiA 301 7.1.6.4).
    UnicodeString,
    UnicodeString,
    |value| if value.len() % 2 == 0 { Ok(()) } else { Err(AbortCode::Length) }
);
