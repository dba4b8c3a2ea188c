//! A value in three copies, of which two have to agree.

use super::{Canonical, Instant};

/// A value that decides for long and that no traffic refreshes, in three copies. A flipped bit of one copy has no effect.
///
/// Bits that flip one after the other add up. So the owner calls [`Triple::correct`] periodically, for example with each
/// heartbeat.
///
/// ```
/// use async_canopen::types::Triple;
///
/// let mut limit = Triple::new(250_u16);
/// assert_eq!(limit.get(), Some(250));
/// limit.set(500);
/// assert_eq!((limit.correct(), limit.get()), (false, Some(500))); // no bit was wrong
/// ```
///
/// # Limits
///
/// - Two copies with different flipped bits have no majority. Then [`Triple::get`] returns `None`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Triple<T>([T; 3]);

impl<T: Copy + PartialEq> Triple<T> {
    /// Makes the three copies.
    pub const fn new(value: T) -> Self {
        Triple([value; 3])
    }

    /// Replaces all copies.
    pub fn set(&mut self, value: T) {
        *self = Self::new(value);
    }

    /// Returns the value of two copies that agree. `None`: all three differ.
    pub fn get(&self) -> Option<T> {
        let Triple([first, second, third]) = self;
        if first == second || first == third { Some(*first) } else { (second == third).then_some(*second) }
    }

    /// Corrects the copy that differs from the two others. Returns whether one differed.
    pub fn correct(&mut self) -> bool {
        let Triple([first, second, third]) = self;
        correct([first, second, third])
    }
}

/// Corrects the one of three copies that differs from the two others. If all three differ, the first one is taken. Returns
/// whether one differed.
pub fn correct<T: Copy + PartialEq>(copies: [&mut T; 3]) -> bool {
    let [first, second, third] = copies;
    let wrong = match (first == second, second == third) {
        (true, true) => return false,
        (true, false) => (third, *first),
        (false, true) => (first, *second),
        (false, false) => {
            *third = *first;
            (second, *first)
        }
    };
    *wrong.0 = wrong.1;
    true
}

#[diagnostic::do_not_recommend]
impl<T: Copy + PartialEq + Canonical> Canonical for Triple<T> {
    type Context = T::Context;

    fn canonical(&mut self, now: Instant, context: &T::Context) {
        self.0.canonical(now, context);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALUE: u32 = 0x1357_9BDF;

    /// Given a value in three copies, when any bit of them flips, then the value is the one before, and the copies agree again
    /// after a correction.
    #[test]
    fn a_flipped_bit_of_three_copies_changes_no_value() {
        for copy in 0..3 {
            for bit in 0..32 {
                let mut triple = Triple::new(VALUE);
                triple.0[copy] ^= 1 << bit;
                assert_eq!(triple.get(), Some(VALUE), "copy {copy}, bit {bit}");
                assert!(triple.correct() && !triple.correct());
                assert_eq!(triple.0, [VALUE; 3]);
            }
        }
    }

    /// Given three copies, when two of them have different flipped bits, then none is taken for the value.
    #[test]
    fn two_flipped_bits_leave_no_value() {
        for (one, other) in [(0, 1), (0, 2), (1, 2)] {
            let mut triple = Triple::new(VALUE);
            triple.0[one] ^= 1;
            triple.0[other] ^= 2;
            assert_eq!(triple.get(), None);
        }
    }
}
