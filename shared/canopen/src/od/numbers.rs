//! Numbers of every width in the dictionary: 8 to 64 bits, REAL, BOOLEAN.

use super::{DataType, Number, Typed, Variable};

/// Unsigned number of 24, 40, 48 or 56 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Unsigned<const BITS: u32>(u64);

/// Signed number of 24, 40, 48 or 56 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Signed<const BITS: u32>(i64);

/// UNSIGNED24, an unsigned number of 24 bits.
pub type U24 = Unsigned<24>;
/// UNSIGNED40, an unsigned number of 40 bits.
pub type U40 = Unsigned<40>;
/// UNSIGNED48, an unsigned number of 48 bits.
pub type U48 = Unsigned<48>;
/// UNSIGNED56, an unsigned number of 56 bits.
pub type U56 = Unsigned<56>;
/// INTEGER24, a signed number of 24 bits.
pub type I24 = Signed<24>;
/// INTEGER40, a signed number of 40 bits.
pub type I40 = Signed<40>;
/// INTEGER48, a signed number of 48 bits.
pub type I48 = Signed<48>;
/// INTEGER56, a signed number of 56 bits.
pub type I56 = Signed<56>;

impl<const BITS: u32> Unsigned<BITS> {
    /// Takes the low bits of a number. Higher bits are cut off.
    pub const fn new(value: u64) -> Self {
        Unsigned(value & (u64::MAX >> (64 - BITS)))
    }

    /// Returns the number as a `u64`.
    pub const fn get(self) -> u64 {
        self.0
    }
}

impl<const BITS: u32> Signed<BITS> {
    /// Takes the low bits of a number. The highest of them is the sign. Higher bits are cut off.
    pub const fn new(value: i64) -> Self {
        Signed(value << (64 - BITS) >> (64 - BITS))
    }

    /// Returns the number as an `i64`.
    pub const fn get(self) -> i64 {
        self.0
    }
}

/// Implements [`Variable`] for a number that is the low bits of a `u64`.
macro_rules! number {
    ($type:ty, $data_type:ident, $size:expr, $value:ident => $to:expr, $bits:ident => $from:expr) => {
        impl Variable for $type {
            #[inline]
            fn bits(&self) -> u64 {
                let $value = *self;
                $to
            }

            #[inline]
            fn set_bits(&mut self, $bits: u64) {
                *self = $from;
            }
        }

        impl Typed for $type {
            const TYPE: DataType = DataType::$data_type;
            const SIZE: usize = $size;
        }

        impl Number for $type {}
    };
}

impl Variable for bool {
    #[inline]
    fn bits(&self) -> u64 {
        u64::from(*self)
    }

    #[inline]
    fn set_bits(&mut self, bits: u64) {
        *self = bits & 1 != 0;
    }
}

impl Typed for bool {
    const TYPE: DataType = DataType::Boolean;
    const SIZE: usize = 1;
}

impl Number for bool {}

number!(u8, Unsigned8, 1, value => u64::from(value), bits => bits as u8);
number!(u16, Unsigned16, 2, value => u64::from(value), bits => bits as u16);
number!(U24, Unsigned24, 3, value => value.0, bits => U24::new(bits));
number!(u32, Unsigned32, 4, value => u64::from(value), bits => bits as u32);
number!(U40, Unsigned40, 5, value => value.0, bits => U40::new(bits));
number!(U48, Unsigned48, 6, value => value.0, bits => U48::new(bits));
number!(U56, Unsigned56, 7, value => value.0, bits => U56::new(bits));
number!(u64, Unsigned64, 8, value => value, bits => bits);
number!(i8, Integer8, 1, value => value as u8 as u64, bits => bits as i8);
number!(i16, Integer16, 2, value => value as u16 as u64, bits => bits as i16);
number!(I24, Integer24, 3, value => value.0 as u64 & 0xFF_FFFF, bits => I24::new(bits as i64));
number!(i32, Integer32, 4, value => value as u32 as u64, bits => bits as i32);
number!(I40, Integer40, 5, value => value.0 as u64 & 0xFF_FFFF_FFFF, bits => I40::new(bits as i64));
number!(I48, Integer48, 6, value => value.0 as u64 & 0xFFFF_FFFF_FFFF, bits => I48::new(bits as i64));
number!(I56, Integer56, 7, value => value.0 as u64 & 0xFF_FFFF_FFFF_FFFF, bits => I56::new(bits as i64));
number!(i64, Integer64, 8, value => value as u64, bits => bits as i64);
number!(f32, Real32, 4, value => u64::from(value.to_bits()), bits => f32::from_bits(bits as u32));
number!(f64, Real64, 8, value => value.to_bits(), bits => f64::from_bits(bits));
