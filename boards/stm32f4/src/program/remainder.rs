//! Which bit of a program is wrong.

/// Generator of CRC-32, without its highest power: the remainder that the lowest bit of the last word leaves.
const GENERATOR: u32 = 0x04C1_1DB7;

/// Returns the single flipped bit that leaves this remainder in a program of `words` words: its word, and its bit as a mask.
/// Returns `None` if the remainder is zero, or if more bits are flipped; with a probability of `words` in 130 million it then is
/// some other bit.
pub fn flipped(remainder: u32, words: usize) -> Option<(usize, u32)> {
    let mut left = GENERATOR;
    for word in (0..words).rev() {
        for bit in 0..u32::BITS {
            if left == remainder {
                return Some((word, 1 << bit));
            }
            left = left << 1 ^ if left >> 31 == 1 { GENERATOR } else { 0 };
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORDS: usize = 200;

    /// Remainder of a program, by another implementation.
    fn remainder(program: &[u32]) -> u32 {
        let bytes: Vec<u8> = program.iter().flat_map(|word| word.to_be_bytes()).collect();
        crc::Crc::<u32>::new(&crc::CRC_32_MPEG_2).checksum(&bytes)
    }

    /// A program whose remainder is zero: the remainder of the words before is its last one.
    fn program() -> Vec<u32> {
        let mut program: Vec<u32> = (1..WORDS as u32).map(|n| n.wrapping_mul(0x9E37_79B9)).collect();
        program.push(remainder(&program));
        program
    }

    #[test]
    fn each_flipped_bit_is_found() {
        let mut program = program();
        for at in 0..WORDS {
            for bit in 0..32 {
                program[at] ^= 1 << bit;
                assert_eq!(flipped(remainder(&program), WORDS), Some((at, 1 << bit)), "word {at}, bit {bit}");
                program[at] ^= 1 << bit;
            }
        }
    }

    #[test]
    fn whole_program_has_no_flipped_bit() {
        assert_eq!(flipped(remainder(&program()), WORDS), None);
    }

    /// Given two flipped bits, any two of the first and the last words, then none is found.
    #[test]
    fn two_flipped_bits_are_not_taken_for_one() {
        let mut program = program();
        let bits = (0..64).chain(32 * (WORDS - 2)..32 * WORDS);
        for first in bits.clone() {
            for second in bits.clone().filter(|second| *second != first) {
                for bit in [first, second] {
                    program[bit / 32] ^= 1 << (bit % 32);
                }
                assert_eq!(flipped(remainder(&program), WORDS), None, "bits {first} and {second}");
                for bit in [first, second] {
                    program[bit / 32] ^= 1 << (bit % 32);
                }
            }
        }
    }
}
