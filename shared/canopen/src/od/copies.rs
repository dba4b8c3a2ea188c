//! Three copies of a COB-ID, by which a flipped bit is found and corrected: the object, one with its complement, and the one
//! that a service uses.

use super::CobIdEntry;
use crate::types::Sealed;

/// A COB-ID and its complement.
#[derive(Clone, Copy, Debug)]
pub struct Copied([u32; 2]);

impl Copied {
    /// Copy of no COB-ID. It is replaced before it is compared.
    pub const NONE: Copied = Copied([0; 2]);

    /// Copies a COB-ID.
    pub const fn of(cob_id: u32) -> Copied {
        Copied([cob_id, !cob_id])
    }

    /// Flips a bit, 32 and above in the complement.
    #[cfg(test)]
    pub fn flip(&mut self, bit: usize) {
        self.0[bit / 32] ^= 1 << (bit % 32);
    }

    /// Returns the copied value, unless a bit has flipped.
    pub fn whole(self) -> Option<u32> {
        let Copied([cob_id, complement]) = self;
        (cob_id == !complement).then_some(cob_id)
    }
}

/// The three copies of a COB-ID.
pub struct Copies<'a> {
    object: &'a mut u32,
    second: &'a mut Copied,
    in_use: Sealed,
    /// Bits of the object that the service uses.
    used: u32,
}

impl<'a> Copies<'a> {
    /// Takes the object, the second copy, and the COB-ID that the service uses. All bits of the object are in use.
    pub fn new(object: &'a mut u32, second: &'a mut Copied, in_use: Sealed) -> Self {
        Copies { object, second, in_use, used: u32::MAX }
    }

    /// Compares these bits of the object alone.
    pub fn of_bits(self, used: u32) -> Self {
        Copies { used, ..self }
    }

    /// Takes the second copy from the object.
    pub fn renew(self) {
        *self.second = Copied::of(*self.object);
    }

    /// Corrects object and second copy. Returns whether one of the three was wrong.
    pub fn correct(self) -> bool {
        let whole = self.second.whole();
        let right = whole.unwrap_or(*self.object);
        let is_used = Sealed::maybe(CobIdEntry::from_raw(right & self.used).cob_id()) == self.in_use;
        let is_right = is_used && whole == Some(*self.object);
        (*self.object, *self.second) = (right, Copied::of(right));
        !is_right
    }
}
