//! A frame as bits and edges: layout, CRC, stuffing, EOF.
//!
//! Bits are levels: `true` is recessive, `false` dominant. From SOF to the end of the CRC sequence a complementary bit
//! follows five equal ones; CRC delimiter, ACK slot, ACK delimiter and the seven bits of EOF are of fixed form
//! (ISO 11898-1, 10.4 and 10.5).

use std::fmt;

use crate::wire::frame::{WireFrame, WireId};

/// Recessive bits between two frames.
pub const INTERMISSION_BITS: u64 = 3;

/// Fixed-form bits after the CRC sequence: CRC delimiter, ACK slot, ACK delimiter, EOF.
const TAIL: [bool; 10] = [true, false, true, true, true, true, true, true, true, true];

/// Generator of CRC-15/CAN without its leading term.
const CRC_POLYNOMIAL: u16 = 0x4599;

/// Equal bits after which a stuff bit follows.
const STUFF_RUN: u32 = 5;

/// Longest frame: extended, 8 data bytes, every stuff bit.
pub(in crate::wire) const LONGEST: usize = 160;

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
    // SOF is dominant: a leading zero.
    let mut header = Bits { word: 0, count: 1 };
    let arbitration = match frame.id {
        WireId::Standard(id) => {
            header.push(u64::from(id), 11);
            header.push(u64::from(frame.remote), 1);
            header.push(0, 1); // IDE
            header.count
        }
        WireId::Extended(id) => {
            header.push(u64::from(id >> 18), 11);
            header.push(0b11, 2); // SRR, IDE
            header.push(u64::from(id), 18);
            header.push(u64::from(frame.remote), 1);
            header.push(0, 1); // r1
            header.count - 1
        }
    };
    header.push(0, 1); // r0
    header.push(u64::from(frame.dlc), 4);
    let payload = 8 * frame.len() as u32;
    let data = u64::from_be_bytes(frame.data);
    header.push(data.checked_shr(64 - payload).unwrap_or(0), payload);
    let crc = crc_of(header.word);
    header.push(u64::from(crc), 15);
    let mut encoded = header.stuffed(arbitration);
    TAIL.iter().for_each(|&bit| encoded.push(bit));
    encoded
}

/// Bits before stuffing, the last one lowest.
struct Bits {
    word: u128,
    count: u32,
}

impl Bits {
    /// Appends the `count` low bits of `value`, highest first.
    fn push(&mut self, value: u64, count: u32) {
        let mask = (1u128 << count) - 1;
        self.word = self.word << count | u128::from(value) & mask;
        self.count += count;
    }

    /// Inserts stuff bits. The first `arbitration` bits are the arbitration field.
    fn stuffed(&self, arbitration: u32) -> Encoded {
        let mut encoded = Encoded {
            bits: [true; LONGEST],
            len: 0,
            arbitration_bits: 0,
            changes: [0; LONGEST],
            changes_len: 0,
        };
        let mut rest = self.word << (128 - self.count);
        let (mut level, mut run, mut passed) = (false, 0, 0);
        while passed < self.count {
            let equal = if level { rest.leading_ones() } else { rest.leading_zeros() };
            let taken = equal.min(self.count - passed).min(STUFF_RUN - run);
            if taken > 0 {
                encoded.push_run(level, taken, run == 0);
            }
            rest <<= taken;
            passed += taken;
            run += taken;
            let stuffs = run == STUFF_RUN;
            level = !level;
            run = u32::from(stuffs);
            if stuffs {
                encoded.push_run(level, 1, true);
            }
            if encoded.arbitration_bits == 0 && passed >= arbitration {
                let beyond = passed - arbitration;
                let stuff_bit = u32::from(stuffs && beyond > 0);
                encoded.arbitration_bits = encoded.len - (beyond + stuff_bit) as u8;
            }
        }
        encoded
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

    /// Appends up to [`STUFF_RUN`] equal bits, fewer than are overwritten later.
    fn push_run(&mut self, level: bool, count: u32, is_change: bool) {
        let from = usize::from(self.len);
        self.bits[from..from + STUFF_RUN as usize].fill(level);
        self.changes[usize::from(self.changes_len)] = self.len;
        self.changes_len += u8::from(is_change);
        self.len += count as u8;
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

/// Updates the CRC-15/CAN by one bit (ISO 11898-1, 10.4.2.6).
pub(in crate::wire) const fn crc_step(crc: u16, bit: bool) -> u16 {
    let shifted = crc << 1 & 0x7FFF;
    if bit != (crc & 0x4000 != 0) { shifted ^ CRC_POLYNOMIAL } else { shifted }
}

/// CRC-15/CAN of bits that follow any number of zeros, which change nothing.
fn crc_of(bits: u128) -> u16 {
    bits.to_be_bytes().iter().fold(0, |crc, byte| {
        let index = crc >> 7 ^ u16::from(*byte);
        crc << 8 & 0x7FFF ^ CRC_OF_BYTE[usize::from(index & 0xFF)]
    })
}

/// Remainder after eight zeros of a remainder whose high byte is the index.
const CRC_OF_BYTE: [u16; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = (byte as u16) << 7;
        let mut bit = 0;
        while bit < 8 {
            crc = crc_step(crc, false);
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::*;

    /// The catalogue of parametrised CRC algorithms gives 059Eh as the check value of CRC-15/CAN.
    #[test]
    fn crc_of_the_catalogue_check_string() {
        let bits = b"123456789".iter().flat_map(|byte| (0..8).rev().map(move |shift| byte >> shift & 1 == 1));
        assert_eq!(bits.fold(0, crc_step), 0x059E);
        let word = b"123456789".iter().fold(0, |word, byte| word << 8 | u128::from(*byte));
        assert_eq!(crc_of(word), 0x059E);
    }
}
