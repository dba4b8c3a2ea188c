//! The checksum of block transfers: CRC-CCITT, x16 + x12 + x5 + 1 (CiA 301 7.2.4.3.16).
//!
//! The crate `crc` 3.4 computes it as well. Measured with each, in the row `instructions.block_download_segment` and the flash of
//! the slave on the pyboard:
//!
//! | code | instructions | flash, bytes |
//! | --- | --- | --- |
//! | this module | 169.4 | 83 688 |
//! | `crc`, `Table<1>` | 175.5 (+3.6 %) | 84 124 |
//! | `crc`, `NoTable` | 469.9 (+177 %) | 83 644 |

/// Checksum that is being computed: initial value zero, neither reflected nor inverted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Crc(u16);

/// Returns the remainder of `bits` times x16: up to four bytes, added to the checksum of the bytes before them.
///
/// There is no table, which would have 512 bytes. The quotient is `bits` divided by P, the polynomial over x16:
/// `P = 1 + x^-4 + x^-11 + x^-16`. Squared three times, P is `1 + x^-32` and more. Of 32 bits nothing is left when
/// they move down by 32. So `1 / P` is the 7th power of P here. P times its 4th power is
/// `1 + (x^-4 + x^-11) (1 + x^-16)`, and its square is `1 + x^-8 + x^-22`.
#[inline]
fn remainder(bits: u32) -> u32 {
    let moved = (bits ^ bits >> 7) >> 4;
    let fifth = bits ^ moved ^ moved >> 16;
    let quotient = fifth ^ (fifth ^ fifth >> 14) >> 8;
    ((quotient ^ quotient << 7) << 5 ^ quotient) & 0xFFFF
}

impl Crc {
    /// Makes the checksum of zero bytes.
    pub const fn new() -> Crc {
        Crc(0)
    }

    /// Adds the next bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        let (fours, rest) = bytes.as_chunks::<4>();
        let crc = fours
            .iter()
            .fold(u32::from(self.0), |crc, four| remainder(crc << 16 ^ u32::from_be_bytes(*four)));
        self.0 = rest.iter().fold(crc, |crc, byte| remainder(crc >> 8 ^ u32::from(*byte)) ^ (crc & 0xFF) << 8)
            as u16;
    }

    /// Returns the checksum of all bytes so far.
    pub const fn value(self) -> u16 {
        self.0
    }
}
