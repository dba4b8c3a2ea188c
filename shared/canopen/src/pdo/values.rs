//! Values of a PDO, in the order in which it carries them.

use crate::od::{DataType, Number};

/// Values of a [`Pdo`](super::Pdo): a tuple of at most eight [numbers](Number), or a struct that derives
/// [`PdoValues`](macro@super::PdoValues).
pub trait PdoValues: Sized {
    /// Types of the values, in the order in which the PDO carries them.
    type Tuple;

    /// Returns the values that a payload carries, the first one in its low bits. `None` if one of them is no value of its
    /// enumeration.
    fn unpack(payload: u64) -> Option<Self>;

    /// Returns the payload that carries the values.
    fn pack(self) -> u64;
}

/// Values behind which a PDO carries one more.
pub trait Append: PdoValues {
    /// These values, and one of type `V` behind them.
    type And<V: Number>: PdoValues;
}

/// Number of bits of a number, at most 64.
const fn bits<V: Number>() -> u32 {
    match DataType::bits(V::TYPE) {
        Some(bits) => bits as u32,
        None => 0,
    }
}

/// Takes a number from the low end of `rest`.
fn take<V: Number>(rest: &mut u64) -> Option<V> {
    let value = V::from_bits(*rest);
    *rest = rest.checked_shr(bits::<V>()).unwrap_or(0);
    value
}

/// Puts a number behind the `filled` low bits.
fn put<V: Number>(payload: &mut u64, filled: &mut u32, value: V) {
    *payload |= value.bits().checked_shl(*filled).unwrap_or(0);
    *filled += bits::<V>();
}

macro_rules! values {
    ($($value:ident)*) => {
        #[allow(non_snake_case, unused_variables, unused_mut, clippy::unused_unit)]
        impl<$($value: Number),*> PdoValues for ($($value,)*) {
            type Tuple = Self;

            fn unpack(payload: u64) -> Option<Self> {
                let mut rest = payload;
                Some(($(take::<$value>(&mut rest)?,)*))
            }

            fn pack(self) -> u64 {
                let ($($value,)*) = self;
                let (mut payload, mut filled) = (0, 0);
                $(put(&mut payload, &mut filled, $value);)*
                payload
            }
        }
    };
}

macro_rules! append {
    ($($value:ident)*) => {
        impl<$($value: Number),*> Append for ($($value,)*) {
            type And<V: Number> = ($($value,)* V,);
        }
    };
}

values!();
values!(A);
values!(A B);
values!(A B C);
values!(A B C D);
values!(A B C D E);
values!(A B C D E F);
values!(A B C D E F G);
values!(A B C D E F G H);

append!();
append!(A);
append!(A B);
append!(A B C);
append!(A B C D);
append!(A B C D E);
append!(A B C D E F);
append!(A B C D E F G);

/// There is no room for a ninth value: [`Pdo::map`](super::Pdo::map) refuses it.
impl<A, B, C, D, E, F, G, H> Append for (A, B, C, D, E, F, G, H)
where
    Self: PdoValues,
{
    type And<V: Number> = Self;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::od::{I24, U40};

    /// The first value is in the low bits, as CiA 301 7.4.8 has it; a BOOLEAN takes one bit.
    #[test]
    fn values_lie_one_behind_the_other() {
        let values = (0x1234_u16, true, -1_i8);
        let payload = 0x1234 | 1 << 16 | 0xFF << 17;
        assert_eq!(values.pack(), payload);
        assert_eq!(<(u16, bool, i8)>::unpack(payload), Some(values));
    }

    #[test]
    fn eight_bytes_are_full() {
        let values = (I24::new(-2), U40::new(0xAB_CDEF_0123));
        assert_eq!(values.pack(), 0xABCD_EF01_23FF_FFFE);
        assert_eq!(<(I24, U40)>::unpack(0xABCD_EF01_23FF_FFFE), Some(values));
        assert_eq!((u64::MAX,).pack(), u64::MAX);
        assert_eq!(<(u64,)>::unpack(u64::MAX), Some((u64::MAX,)));
    }

    #[test]
    fn signs_survive() {
        assert_eq!(<(i16, u8)>::unpack(0x01_FF38), Some((-200, 1)));
        assert_eq!(<(f32,)>::unpack(0x3F80_0000), Some((1.0,)));
    }
}
