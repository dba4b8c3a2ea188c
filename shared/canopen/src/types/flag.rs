//! A yes or no that no flipped bit in memory inverts.

use super::Canonical;

/// A flag in eight bits, all equal: it is what most of them are.
///
/// ```
/// use async_canopen::types::Flag;
///
/// assert!(Flag::of(true).is_set());
/// assert!(!Flag::of(false).is_set());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct Flag(u8);

impl Flag {
    /// Makes a flag.
    pub const fn of(is_set: bool) -> Flag {
        Flag(if is_set { u8::MAX } else { 0 })
    }

    /// Returns whether it is set.
    pub const fn is_set(self) -> bool {
        self.0.count_ones() > u8::BITS / 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given a flag, when up to three of its bits flip, then it is what it was.
    #[test]
    fn three_flipped_bits_of_eight_do_not_invert_a_flag() {
        for flipped in (0..=u8::MAX).filter(|bits| bits.count_ones() <= 3) {
            for is_set in [false, true] {
                assert_eq!(Flag(Flag::of(is_set).0 ^ flipped).is_set(), is_set, "{flipped:08b}");
            }
        }
    }
}
