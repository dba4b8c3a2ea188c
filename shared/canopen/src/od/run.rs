//! Values side by side in a PDO that are consecutive in the dictionary: they are moved at once.

use super::{Limits, Typed, Variable};

/// Consecutive values of one kind that are side by side in a PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Run {
    /// Number of values, at least one. Together they have at most 64 bits.
    pub count: u32,
    /// Bytes of each value, `1..=8`; zero for a single bit.
    pub bytes: u32,
}

impl Run {
    /// Returns the values from `first` on. The first one is in the lowest bits. `None` if there are too few.
    #[inline]
    pub fn read<T: Variable>(self, values: &[T], first: usize) -> Option<u64> {
        let (lowest, others) = values.get(first..)?.get(..self.count as usize)?.split_first()?;
        let (mut all, mut at) = (lowest.bits(), 0_u32);
        for value in others {
            at = at.wrapping_add(self.bits());
            all |= value.bits().wrapping_shl(at);
        }
        Some(all)
    }

    /// Returns the number of bits of each value.
    pub const fn bits(self) -> u32 {
        if self.bytes == 0 { 1 } else { self.bytes.wrapping_mul(8) }
    }

    /// Writes the values from `first` on. The lowest bits go to the first one. `None` if there are too few; then
    /// nothing is written. Also `None` if some are no value of an enumeration; those are not written.
    #[inline]
    pub fn write<T: Typed>(self, values: &mut [T], first: usize, bits: u64) -> Option<()> {
        let values = values.get_mut(first..)?.get_mut(..self.count as usize)?;
        let (lowest, others) = values.split_first_mut()?;
        lowest.set_bits(bits);
        let (mut rest, mut all) = (bits, T::is_value(bits));
        for value in others {
            rest = rest.wrapping_shr(self.bits());
            value.set_bits(rest);
            all &= T::is_value(rest);
        }
        all.then_some(())
    }

    /// Writes as [`Run::write`]. Also `None` if some values are outside `limits`; those are not written.
    pub fn write_within<T: Typed>(
        self,
        values: &mut [T],
        first: usize,
        bits: u64,
        limits: &Limits,
    ) -> Option<()> {
        let (mut rest, mut all) = (bits, Some(()));
        for value in values.get_mut(first..)?.get_mut(..self.count as usize)? {
            match limits.check(T::TYPE, rest) {
                Ok(()) if T::is_value(rest) => value.set_bits(rest),
                _ => all = None,
            }
            rest = rest.wrapping_shr(self.bits());
        }
        all
    }
}
