//! Upsets of the flash interface.

use super::*;

impl Flash {
    /// Returns the offsets of the registers, and their bits that hold state. STRT and BSY belong to an operation.
    pub fn stored(&self) -> Vec<(u32, u32)> {
        vec![(ACR, ACR_BITS), (SR, SR_FLAGS), (CR, self.cr_bits())]
    }

    /// Sets the flag of a store without a programming sequence.
    pub fn note_stray_store(&mut self) {
        self.fail(PGSERR);
    }

    /// Inverts a bit of a register. LOCK opens the interface without keys, or closes it.
    pub fn flip(&mut self, offset: u32, bit: u32) {
        let mask = 1 << bit;
        match offset {
            ACR => (self.acr, self.acr_written) = (self.acr ^ mask, true),
            SR => self.sr ^= mask,
            _ if mask == LOCK => {
                self.keys = if self.is_unlocked() { Keys::Locked } else { Keys::Unlocked };
            }
            _ => self.cr ^= mask,
        }
    }
}
