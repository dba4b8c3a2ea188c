//! Fast test of received frames: a set of COB-IDs in two words.

use crate::types::CobId;

/// A bit for each COB-ID; some share one. Words of 32 bits: built for size, a shift of 64 is a call.
#[derive(Clone, Copy, Debug)]
pub(super) struct CobIdSet([u32; 2]);

impl CobIdSet {
    pub const ALL: CobIdSet = CobIdSet([u32::MAX; 2]);

    /// Returns whether the set has this COB-ID, or another one that shares its bit.
    pub fn may_have(&self, id: CobId) -> bool {
        let (word, bit) = place(id);
        self.0.get(word).is_some_and(|word| word & bit != 0)
    }
}

impl FromIterator<CobId> for CobIdSet {
    fn from_iter<I: IntoIterator<Item = CobId>>(ids: I) -> CobIdSet {
        let mut set = CobIdSet([0; 2]);
        for (word, bit) in ids.into_iter().map(place) {
            if let Some(word) = set.0.get_mut(word) {
                *word |= bit;
            }
        }
        set
    }
}

/// The word and the bit.
fn place(id: CobId) -> (usize, u32) {
    let sum = u32::from(id.raw() ^ id.raw() >> 5);
    ((sum >> 5 & 1) as usize, 1 << (sum & 0x1F))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_has_what_it_was_made_of() {
        for raw in 0..0x800 {
            let id = CobId::new(raw).unwrap();
            let set: CobIdSet = [id].into_iter().collect();
            assert!(set.may_have(id) && CobIdSet::ALL.may_have(id));
            let sharing = (0..0x800).filter(|raw| set.may_have(CobId::new(*raw).unwrap())).count();
            assert_eq!(sharing, 0x800 / 64, "{raw:03X}h");
        }
    }
}
