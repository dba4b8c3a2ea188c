//! Values that a slave keeps over a reset of its chip, in RAM that no start initialises.
//!
//! ```text
//! word 0   Bdefault (0 nominal, 1 redundant, 2 none) | resets in a row | notes written | ECh
//! word 1   complement of word 0
//! ```
//!
//! After power-on the RAM has any content. Only two words that match are accepted.

use crate::types::{Bus, Canonical};

/// The highest byte of word 0.
const MARK: u8 = 0xEC;
/// The byte where no Bdefault is retained.
const NONE: u8 = 2;

/// Values that outlive a reset, but not a loss of power. The default is that of power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Retained {
    /// Bdefault since the master was last found. `None` if the stored one holds (ECSS 8.3.3k, l).
    pub bdefault: Option<Bus>,
    /// Number of resets obeyed in a row: [`crate::nmt::machine::ResetGuard::row`].
    pub resets: u8,
    /// Number of notes written to the parameter store since power-on.
    pub notes: u8,
}

impl Retained {
    /// Greatest number of notes that a node writes from power-on to power-off. More would use up the room for sets.
    pub const MOST_NOTES: u8 = 8;

    /// Encodes the values as two words.
    pub const fn encode(self) -> [u32; 2] {
        let bdefault = match self.bdefault {
            Some(bus) => bus.bdefault(),
            None => NONE,
        };
        let word = u32::from_le_bytes([bdefault, self.resets, self.notes, MARK]);
        [word, !word]
    }

    /// Decodes two words. `None` if [`Retained::encode`] did not make them, for example after power-on.
    pub const fn decode([word, check]: [u32; 2]) -> Option<Retained> {
        let [bdefault, resets, notes, mark] = word.to_le_bytes();
        if check != !word || mark != MARK || bdefault > NONE {
            return None;
        }
        Some(Retained { bdefault: Bus::from_bdefault(bdefault), resets, notes })
    }
}
