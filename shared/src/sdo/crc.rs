//! The checksum of block transfers: CRC-CCITT, x16 + x12 + x5 + 1 (CiA 301 7.2.4.3.16).

const POLYNOMIAL: u16 = 0x1021;

/// What eight shifts make of each value of the upper byte, with its bytes swapped.
const TABLE: [u16; 256] = table();

const fn table() -> [u16; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut remainder = (byte as u16) << 8;
        let mut bit = 0;
        while bit < 8 {
            remainder = (remainder << 1) ^ if remainder & 0x8000 == 0 { 0 } else { POLYNOMIAL };
            bit += 1;
        }
        table[byte] = remainder.swap_bytes();
        byte += 1;
    }
    table
}

/// A checksum in the making: initial value zero, nothing reflected, nothing inverted.
///
/// Kept with its bytes swapped, because then the byte that selects from the table needs no shift.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Crc(u16);

impl Crc {
    /// Of no bytes.
    pub const fn new() -> Crc {
        Crc(0)
    }

    /// Takes in the next bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        self.0 = bytes.iter().fold(self.0, |crc, byte| {
            let selected = usize::from(crc as u8 ^ byte);
            (crc >> 8) ^ TABLE.get(selected).copied().unwrap_or_default()
        });
    }

    /// Of all bytes so far.
    pub const fn value(self) -> u16 {
        self.0.swap_bytes()
    }
}
