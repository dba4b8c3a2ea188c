//! A yes or no that no flipped bit in memory inverts.

use super::Canonical;

/// A flag in three bits, all equal: it is what two of them are.
///
/// ```
/// use async_canopen::types::Flag;
///
/// assert!(Flag::of(true).is_set());
/// assert!(!Flag::of(false).is_set());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct Flag(u8);

/// All bits.
const SET: u8 = 0b111;
/// Bit n is what most bits of n are.
const MAJORITY: u8 = 0b1110_1000;

impl Flag {
    /// Makes a flag.
    pub const fn of(is_set: bool) -> Flag {
        Flag(if is_set { SET } else { 0 })
    }

    /// Returns whether it is set.
    pub const fn is_set(self) -> bool {
        MAJORITY >> (self.0 & SET) & 1 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given a flag, when any bit of its byte flips, then it is what it was.
    #[test]
    fn a_flipped_bit_does_not_invert_a_flag() {
        for bit in 0..u8::BITS {
            for is_set in [false, true] {
                assert_eq!(Flag(Flag::of(is_set).0 ^ 1 << bit).is_set(), is_set, "bit {bit}");
            }
        }
    }
}
