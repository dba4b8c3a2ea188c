//! A code of some words, by which one flipped bit is found and corrected.

use thiserror::Error;

/// Error-correcting code of some words: it corrects one flipped bit, and finds two.
///
/// It protects values that have their place elsewhere, such as the parameters of the object dictionary: four bytes
/// for up to 2,047 words. The code is an extended Hamming code: the exclusive or of the numbers of all bits that are set, and
/// that of the complements of these numbers.
///
/// ```
/// use async_canopen::types::{Ecc, Uncorrectable};
///
/// let mut words = [250, 0x0003_00FA];
/// let mut ecc = Ecc::of(&words); // with each intended change
/// words[1] ^= 1 << 20;
/// assert_eq!(ecc.correct(&mut words), Ok(true));
/// assert_eq!(words, [250, 0x0003_00FA]);
/// words[1] ^= 0b11;
/// assert_eq!(ecc.correct(&mut words), Err(Uncorrectable));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ecc(u32);

/// At least two bits have flipped: nothing was corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("at least two bits have flipped")]
pub struct Uncorrectable;

impl Ecc {
    /// Computes the code of at most 2,047 words.
    pub fn of(words: &[u32]) -> Ecc {
        let mut code = 0;
        for (first, word) in (1..).step_by(32).zip(words) {
            let mut rest = *word;
            while rest != 0 {
                code ^= number(first + rest.trailing_zeros());
                rest &= rest - 1;
            }
        }
        Ecc(code)
    }

    /// Corrects the words, or the code, if one bit of them has flipped. Returns whether one had.
    ///
    /// # Errors
    /// [`Uncorrectable`] if more bits have flipped.
    pub fn correct(&mut self, words: &mut [u32]) -> Result<bool, Uncorrectable> {
        let found = Ecc::of(words);
        let difference = found.0 ^ self.0;
        if difference.count_ones() <= 1 {
            *self = found;
            return Ok(difference != 0);
        }
        let bit = (difference & 0xFFFF).wrapping_sub(1);
        match words.get_mut(bit as usize / 32) {
            Some(word) if number(bit + 1) == difference => {
                *word ^= 1 << (bit % 32);
                Ok(true)
            }
            _ => Err(Uncorrectable),
        }
    }
}

/// Code of a bit: its number, from 1 on, with the complement of the number.
const fn number(bit: u32) -> u32 {
    bit | !bit << 16
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORDS: [u32; 11] =
        [0, u32::MAX, 1, 0x8000_0000, 250, 7, 0x6000_0008, 0, 0, 0x0300_00FA, 0xA5A5_5A5A];

    /// Given words with their code, when any bit of them or of the code flips, then it is found and corrected.
    #[test]
    fn any_flipped_bit_is_corrected() {
        for bit in 0..32 * (WORDS.len() + 1) {
            let (mut words, mut ecc) = (WORDS, Ecc::of(&WORDS));
            match words.get_mut(bit / 32) {
                Some(word) => *word ^= 1 << (bit % 32),
                None => ecc.0 ^= 1 << (bit % 32),
            }
            assert_eq!(ecc.correct(&mut words), Ok(true), "bit {bit}");
            assert_eq!((words, ecc), (WORDS, Ecc::of(&WORDS)), "bit {bit}");
            assert_eq!(ecc.correct(&mut words), Ok(false));
        }
    }

    /// Given words with their code, when any two bits of the words flip, then nothing is corrected to a third value.
    #[test]
    fn two_flipped_bits_are_found() {
        let bits = 32 * WORDS.len();
        for (one, other) in (0..bits).flat_map(|one| (one + 1..bits).map(move |other| (one, other))) {
            let mut words = WORDS;
            words[one / 32] ^= 1 << (one % 32);
            words[other / 32] ^= 1 << (other % 32);
            let before = words;
            assert_eq!(Ecc::of(&WORDS).correct(&mut words), Err(Uncorrectable), "bits {one} and {other}");
            assert_eq!(words, before);
        }
    }
}
