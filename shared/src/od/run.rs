//! Values side by side: what a PDO carries of an array, moved at one stroke.

use super::{Limits, Typed, Variable};

/// Values that lie side by side in a PDO and are sub-indices in a row in the dictionary, all of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Run {
    /// How many, at least one; all together have at most 64 bits.
    pub count: u32,
    /// Bytes of each, `1..=8`; zero for a single bit.
    pub bytes: u32,
}

impl Run {
    /// The values from `first` on, the first one lowest. `None` when there are not as many.
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

    /// Bits of each.
    pub const fn bits(self) -> u32 {
        if self.bytes == 0 { 1 } else { self.bytes.wrapping_mul(8) }
    }

    /// Writes the values from `first` on, the lowest bits to the first. `None` when there are not as many; nothing is
    /// written then.
    #[inline]
    pub fn write<T: Variable>(self, values: &mut [T], first: usize, bits: u64) -> Option<()> {
        let values = values.get_mut(first..)?.get_mut(..self.count as usize)?;
        let (lowest, others) = values.split_first_mut()?;
        lowest.set_bits(bits);
        let mut rest = bits;
        for value in others {
            rest = rest.wrapping_shr(self.bits());
            value.set_bits(rest);
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
            rest = rest.wrapping_shr(self.bits());
        }
        all
    }
}
