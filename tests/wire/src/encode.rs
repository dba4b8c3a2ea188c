//! A frame as bits and edges: layout, CRC, stuffing, EOF.
//!
//! Bits are levels: `true` is recessive, `false` dominant. From SOF to the end of the CRC sequence a complementary bit
//! follows five equal ones; CRC delimiter, ACK slot, ACK delimiter and the seven bits of EOF are of fixed form
//! (ISO 11898-1, 10.4 and 10.5).

use std::fmt;

use crate::frame::{WireFrame, WireId};

/// Recessive bits between two frames.
pub const INTERMISSION_BITS: u64 = 3;

/// Fixed-form bits after the CRC sequence: CRC delimiter, ACK slot, ACK delimiter, EOF.
const TAIL: [bool; 10] = [true, false, true, true, true, true, true, true, true, true];

/// Generator of CRC-15/CAN without its leading term.
const CRC_POLYNOMIAL: u16 = 0x4599;

/// Longest frame: extended, 8 data bytes, every stuff bit.
const LONGEST: usize = 160;

/// The bits of one acknowledged frame, SOF to the last bit of EOF.
#[derive(Clone, PartialEq, Eq)]
pub struct Encoded {
    bits: [bool; LONGEST],
    len: u8,
    arbitration_bits: u8,
    /// Indices of the bits whose level differs from the bit before, SOF first.
    changes: [u8; LONGEST],
    changes_len: u8,
}

/// Lays a frame out as the bits on the wire.
pub fn encode(frame: &WireFrame) -> Encoded {
    let mut stuffing = Stuffing {
        encoded: Encoded {
            bits: [true; LONGEST],
            len: 0,
            arbitration_bits: 0,
            changes: [0; LONGEST],
            changes_len: 0,
        },
        last: true,
        run: 0,
        crc: 0,
    };
    stuffing.push(0, 1);
    match frame.id {
        WireId::Standard(id) => {
            stuffing.push(u32::from(id), 11);
            stuffing.push(u32::from(frame.remote), 1);
            stuffing.push(0, 1); // IDE
            stuffing.encoded.arbitration_bits = stuffing.encoded.len;
        }
        WireId::Extended(id) => {
            stuffing.push(id >> 18, 11);
            stuffing.push(0b11, 2); // SRR, IDE
            stuffing.push(id, 18);
            stuffing.push(u32::from(frame.remote), 1);
            stuffing.encoded.arbitration_bits = stuffing.encoded.len;
            stuffing.push(0, 1); // r1
        }
    }
    stuffing.push(0, 1); // r0
    stuffing.push(u32::from(frame.dlc), 4);
    for &byte in frame.payload() {
        stuffing.push(u32::from(byte), 8);
    }
    let crc = stuffing.crc;
    stuffing.push(u32::from(crc), 15);
    let mut encoded = stuffing.encoded;
    TAIL.iter().for_each(|&bit| encoded.push(bit));
    encoded
}

/// The stuffed part as it grows.
struct Stuffing {
    encoded: Encoded,
    last: bool,
    run: u8,
    crc: u16,
}

impl Stuffing {
    /// Appends the `count` low bits of `value`, highest first.
    fn push(&mut self, value: u32, count: u32) {
        for shift in (0..count).rev() {
            let bit = value >> shift & 1 == 1;
            self.crc = crc_step(self.crc, bit);
            self.encoded.push(bit);
            self.run = if bit == self.last { self.run + 1 } else { 1 };
            self.last = bit;
            if self.run == 5 {
                self.encoded.push(!bit);
                (self.last, self.run) = (!bit, 1);
            }
        }
    }
}

impl Encoded {
    fn push(&mut self, bit: bool) {
        let index = usize::from(self.len);
        let before = index.checked_sub(1).is_none_or(|before| self.bits[before]);
        self.bits[index] = bit;
        self.len += 1;
        if bit != before {
            self.changes[usize::from(self.changes_len)] = index as u8;
            self.changes_len += 1;
        }
    }

    /// Every level from SOF to the last bit of EOF, with the ACK slot dominant.
    pub fn bits(&self) -> &[bool] {
        &self.bits[..usize::from(self.len)]
    }

    /// Bits from SOF to the end of the CRC sequence, stuff bits included.
    pub fn stuffed_len(&self) -> usize {
        usize::from(self.len) - TAIL.len()
    }

    /// Bits from SOF to the last bit of the arbitration field (IDE included), stuff bits included. A transmitter that
    /// sends recessive and sees dominant lost arbitration here, and made a bit error after it.
    pub fn arbitration_len(&self) -> usize {
        usize::from(self.arbitration_bits)
    }

    /// Indices of the bits that differ from the bit before them: SOF first, the ACK slot and the ACK delimiter last.
    pub fn changes(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.changes[..usize::from(self.changes_len)].iter().map(|&index| usize::from(index))
    }
}

impl fmt::Debug for Encoded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.bits().iter().try_for_each(|&bit| f.write_str(if bit { "1" } else { "0" }))
    }
}

/// One bit through CRC-15/CAN (ISO 11898-1, 10.4.2.6).
pub(crate) fn crc_step(crc: u16, bit: bool) -> u16 {
    let shifted = crc << 1 & 0x7FFF;
    if bit != (crc & 0x4000 != 0) { shifted ^ CRC_POLYNOMIAL } else { shifted }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The catalogue of parametrised CRC algorithms gives 059Eh as the check value of CRC-15/CAN.
    #[test]
    fn crc_of_the_catalogue_check_string() {
        let bits = b"123456789".iter().flat_map(|byte| (0..8).rev().map(move |shift| byte >> shift & 1 == 1));
        assert_eq!(bits.fold(0, crc_step), 0x059E);
    }
}
