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

/// Takes in the lowest byte of the data, which has the checksum added at its lower end; those above move down.
#[inline]
fn next(data: u32) -> u32 {
    (data >> 8) ^ u32::from(TABLE.get(usize::from(data as u8)).copied().unwrap_or_default())
}

#[inline]
fn four(crc: u32, bytes: [u8; 4]) -> u32 {
    next(next(next(next(crc ^ u32::from_le_bytes(bytes)))))
}

impl Crc {
    /// Of no bytes.
    pub const fn new() -> Crc {
        Crc(0)
    }

    /// Takes in the next bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        // Eight at a time: fewer rounds.
        let (eights, rest) = bytes.as_chunks::<8>();
        let crc = eights.iter().fold(u32::from(self.0), |crc, &[a, b, c, d, e, f, g, h]| {
            four(four(crc, [a, b, c, d]), [e, f, g, h])
        });
        self.0 = rest.iter().fold(crc, |crc, byte| next(crc ^ u32::from(*byte))) as u16;
    }

    /// Of all bytes so far.
    pub const fn value(self) -> u16 {
        self.0.swap_bytes()
    }
}
