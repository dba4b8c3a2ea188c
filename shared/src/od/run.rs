//! Values side by side: what a PDO carries of an array, moved at one stroke.

use super::{Limits, Typed, Variable};

/// Values that lie side by side in a PDO and are sub-indices in a row in the dictionary, all of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Run {
    /// How many, at least one.
    pub count: u32,
    /// Bits of each, `1..=64`; of all together at most 64.
    pub bits: u32,
}

impl Run {
    /// The values from `first` on, the first one lowest. `None` when there are not as many.
    #[inline]
    pub fn read<T: Variable>(self, values: &[T], first: usize) -> Option<u64> {
        let values = values.get(first..)?.get(..self.count as usize)?;
        Some(values.iter().rev().fold(0, |above, value| above.wrapping_shl(self.bits) | value.bits()))
    }

    /// Writes the values from `first` on, the lowest bits to the first. `None` when there are not as many; nothing is
    /// written then.
    #[inline]
    pub fn write<T: Variable>(self, values: &mut [T], first: usize, bits: u64) -> Option<()> {
        let mut rest = bits;
        for value in values.get_mut(first..)?.get_mut(..self.count as usize)? {
            value.set_bits(rest);
            rest = rest.wrapping_shr(self.bits);
        }
        Some(())
    }

    /// As [`Run::write`]; `None` also when some do not keep `limits`, which are not written.
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
                Ok(()) => value.set_bits(rest),
                Err(_) => all = None,
            }
            rest = rest.wrapping_shr(self.bits);
        }
        all
    }
}
