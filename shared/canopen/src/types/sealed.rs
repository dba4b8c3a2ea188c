//! A COB-ID that no flipped bit in memory turns into another one.

use super::{Canonical, CobId};

/// The COB-ID that a service uses, with its complement; or none. Every single flipped bit makes it none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sealed(u32);

impl Sealed {
    /// No COB-ID. It differs from that of every COB-ID in at least ten bits.
    pub const NONE: Sealed = Sealed(0x0000_FFFF);

    /// Seals a COB-ID.
    pub const fn of(id: CobId) -> Sealed {
        let raw = id.raw();
        Sealed(raw as u32 | (!raw as u32) << 16)
    }

    /// Seals a COB-ID, if there is one.
    pub(crate) const fn maybe(id: Option<CobId>) -> Sealed {
        match id {
            Some(id) => Self::of(id),
            None => Self::NONE,
        }
    }

    /// Returns the COB-ID. `None`: there is none, or a bit has flipped.
    pub const fn id(self) -> Option<CobId> {
        let (raw, complement) = (self.0 as u16, (self.0 >> 16) as u16);
        if raw == !complement { CobId::new(raw) } else { None }
    }

    /// Returns whether this is that COB-ID, without a flipped bit.
    pub const fn is(self, id: CobId) -> bool {
        self.0 == Self::of(id).0
    }

    /// Returns the low half, the COB-ID, and [`u16::MAX`] for none.
    pub const fn raw(self) -> u16 {
        self.0 as u16
    }
}

#[cfg(test)]
impl Sealed {
    /// All that one flipped bit makes of it.
    pub(crate) fn flipped(self) -> impl Iterator<Item = Sealed> {
        (0..32).map(move |bit| Sealed(self.0 ^ 1 << bit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Verifies: ECSS 6.10d
    #[test]
    fn a_flipped_bit_makes_a_sealed_cob_id_none() {
        for id in (0..=0x7FF).filter_map(CobId::new) {
            assert_eq!(Sealed::of(id).id(), Some(id));
            assert!(Sealed::of(id).flipped().all(|flipped| flipped.id().is_none()), "{id:?}");
        }
        assert!(Sealed::NONE.flipped().all(|flipped| flipped.id().is_none()));
    }

    /// Given a flipped bit of either half, then it is neither the COB-ID that was sealed nor the one that the bit makes of
    /// it.
    ///
    /// Verifies: ECSS 6.10d
    /// Notices: ECSS 6.10d: a COB-ID in use is compared by its low half alone.
    #[test]
    fn a_sealed_cob_id_with_a_flipped_bit_equals_no_cob_id() {
        for id in (0..=0x7FF).filter_map(CobId::new) {
            assert!(Sealed::of(id).is(id) && !Sealed::NONE.is(id));
            for (flipped, bit) in Sealed::of(id).flipped().zip((0..16).cycle()) {
                assert!(!flipped.is(id), "{id:?}, bit {bit}");
                let other = CobId::new(id.raw() ^ 1 << bit);
                assert!(other.is_none_or(|other| !flipped.is(other)), "{id:?}, bit {bit}");
            }
        }
    }
}
