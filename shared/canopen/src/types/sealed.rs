//! A COB-ID that no flipped bit in memory turns into another one (ECSS 6.10d).

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
    pub const fn maybe(id: Option<CobId>) -> Sealed {
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
mod tests {
    use super::*;

    /// Verifies: ECSS 6.10d
    #[test]
    fn a_flipped_bit_makes_a_sealed_cob_id_none() {
        for id in (0..=0x7FF).filter_map(CobId::new) {
            let sealed = Sealed::of(id);
            assert_eq!(sealed.id(), Some(id));
            for bit in 0..32 {
                assert_eq!(Sealed(sealed.0 ^ 1 << bit).id(), None, "{id:?}, bit {bit}");
            }
        }
        for bit in 0..32 {
            assert_eq!(Sealed(Sealed::NONE.0 ^ 1 << bit).id(), None, "none, bit {bit}");
        }
    }
}
