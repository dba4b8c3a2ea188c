//! Values at power-on as constants, which are compared with the limits of their declaration.
//!
//! The derive macros implement [`Initial`] for each value that has `default` and a limit. [`Numbers::RANGE`] gives
//! its numbers. It is `None` for types that are not from this crate and no integer of Rust: a constant cannot read
//! their number.

use core::marker::PhantomData;

use super::{Signed, Unsigned};

/// Value at power-on of a type, for a declaration without `default`. [`Domain`](super::Domain) has a function of the
/// same name for arrays of any length, which takes precedence.
pub trait Unwritten: Default {
    /// Makes the value.
    #[inline(always)]
    fn unwritten() -> Self {
        Self::default()
    }
}

impl<T: Default> Unwritten for T {}

/// Value at power-on of the object or sub-index `AT`, of type `T`.
pub trait Initial<T, const AT: u16> {
    /// `default = ..` of the declaration.
    const VALUE: T;
}

/// Numbers of the value at power-on that declaration `D` gives the object or sub-index `AT`.
pub struct Numbers<T, D, const AT: u16>(PhantomData<(T, D)>);

/// Fallback of [`Numbers::RANGE`] for types whose numbers a constant cannot read.
pub trait NoNumbers {
    /// `None`: the default of such a type is not compared with its limits.
    const RANGE: Option<(i128, i128)> = None;
}

impl<T, D, const AT: u16> NoNumbers for Numbers<T, D, AT> {}

/// Implements `RANGE` for an integer, for an array, and for an array of arrays.
macro_rules! numbers {
    ($type:ty $(, $bits:ident)?: $value:ident => $number:expr) => {
        impl<D: Initial<$type, AT>, $(const $bits: u32,)? const AT: u16> Numbers<$type, D, AT> {
            /// Least and greatest number of the value at power-on.
            pub const RANGE: Option<(i128, i128)> = {
                let $value = D::VALUE;
                Some(($number, $number))
            };
        }

        impl<D: Initial<[$type; N], AT>, $(const $bits: u32,)? const N: usize, const AT: u16>
            Numbers<[$type; N], D, AT>
        {
            /// Least and greatest number of the values at power-on. `None` for an empty array.
            pub const RANGE: Option<(i128, i128)> = {
                let (values, mut nth, mut range) = (D::VALUE, 0, None);
                while nth < N {
                    let $value = values[nth];
                    (range, nth) = (extended(range, $number), nth + 1);
                }
                range
            };
        }

        impl<D: Initial<[[$type; M]; N], AT>, $(const $bits: u32,)? const M: usize, const N: usize, const AT: u16>
            Numbers<[[$type; M]; N], D, AT>
        {
            /// Least and greatest number of the values at power-on. `None` for an empty array.
            pub const RANGE: Option<(i128, i128)> = {
                let (values, mut nth, mut range) = (D::VALUE, 0, None);
                while nth < N * M {
                    let $value = values[nth / M][nth % M];
                    (range, nth) = (extended(range, $number), nth + 1);
                }
                range
            };
        }
    };
}

numbers!(u8: value => value as i128);
numbers!(u16: value => value as i128);
numbers!(u32: value => value as i128);
numbers!(u64: value => value as i128);
numbers!(i8: value => value as i128);
numbers!(i16: value => value as i128);
numbers!(i32: value => value as i128);
numbers!(i64: value => value as i128);
numbers!(Unsigned<BITS>, BITS: value => value.get() as i128);
numbers!(Signed<BITS>, BITS: value => value.get() as i128);

/// The same range with one more number.
const fn extended(range: Option<(i128, i128)>, number: i128) -> Option<(i128, i128)> {
    match range {
        Some((least, greatest)) => Some((
            if number < least { number } else { least },
            if number > greatest { number } else { greatest },
        )),
        None => Some((number, number)),
    }
}
