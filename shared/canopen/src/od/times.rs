//! TIME_OF_DAY and TIME_DIFFERENCE (CiA 301 7.1.6.5, 7.1.6.6).

use super::{DataType, Number, Typed, Variable};

/// Bits of the milliseconds; four reserved bits follow.
const MS: u64 = (1 << 28) - 1;

/// Defines a type for a time in milliseconds and days.
macro_rules! time {
    ($(#[$doc:meta])* $name:ident, $data_type:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub struct $name {
            /// Days.
            pub days: u16,
            /// Milliseconds, `0..2^28`.
            pub ms: u32,
        }

        impl Variable for $name {
            fn bits(&self) -> u64 {
                u64::from(self.days) << 32 | u64::from(self.ms) & MS
            }

            fn set_bits(&mut self, bits: u64) {
                *self = $name { days: (bits >> 32) as u16, ms: (bits & MS) as u32 };
            }
        }

        impl Typed for $name {
            const TYPE: DataType = DataType::$data_type;
            const SIZE: usize = 6;
        }

        impl Number for $name {}
    };
}

time!(
    /// Milliseconds since midnight, days since 1984-01-01.
    TimeOfDay,
    TimeOfDay
);
time!(
    /// A span of days and milliseconds.
    TimeDifference,
    TimeDifference
);
