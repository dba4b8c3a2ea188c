//! A frame as bits and edges: layout, CRC, stuffing, EOF.
//!
//! Bits are levels: `true` is recessive, `false` dominant. From SOF to the end of the CRC sequence a complementary bit
//! follows five equal ones; CRC delimiter, ACK slot, ACK delimiter and the seven bits of EOF are of fixed form
//! (ISO 11898-1, 10.4 and 10.5).

use crate::controller::Trace;
use crate::frame::{WireFrame, WireId};
use crate::time::Time;

/// Recessive bits between two frames.
pub const INTERMISSION_BITS: u64 = 3;

/// Fixed-form bits after the CRC sequence: CRC delimiter, ACK slot, ACK delimiter, EOF.
const TAIL: [bool; 10] = [true, false, true, true, true, true, true, true, true, true];

/// Generator of CRC-15/CAN without its leading term.
const CRC_POLYNOMIAL: u16 = 0x4599;

/// The bits of one acknowledged frame, SOF to the last bit of EOF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Encoded {
    bits: Vec<bool>,
    arbitration_bits: usize,
}

/// Lays a frame out as the bits on the wire.
pub fn encode(frame: &WireFrame) -> Encoded {
    let (mut plain, arbitration) = layout(frame);
    let crc = crc15(&plain);
    push(&mut plain, u32::from(crc), 15);

    let mut bits = Vec::with_capacity(plain.len() * 5 / 4 + TAIL.len());
    let mut arbitration_bits = 0;
    let (mut last, mut run) = (true, 0);
    for (index, &bit) in plain.iter().enumerate() {
        bits.push(bit);
        run = if bit == last { run + 1 } else { 1 };
        last = bit;
        if run == 5 {
            bits.push(!bit);
            last = !bit;
            run = 1;
        }
        if index + 1 == arbitration {
            arbitration_bits = bits.len();
        }
    }
    bits.extend(TAIL);
    Encoded { bits, arbitration_bits }
}

impl Encoded {
    /// Every level from SOF to the last bit of EOF, with the ACK slot dominant.
    pub fn bits(&self) -> &[bool] {
        &self.bits
    }

    /// Bits from SOF to the end of the CRC sequence, stuff bits included.
    pub fn stuffed_len(&self) -> usize {
        self.bits.len() - TAIL.len()
    }

    /// Bits from SOF to the last bit of the arbitration field (IDE included), stuff bits included. A transmitter that
    /// sends recessive and sees dominant lost arbitration here, and made a bit error after it.
    pub fn arbitration_len(&self) -> usize {
        self.arbitration_bits
    }

    /// Bits from SOF to the end of the ACK slot: the first instant at which a missing acknowledgement is known.
    pub fn acknowledged_len(&self) -> usize {
        self.stuffed_len() + 2
    }

    /// Level changes at the transmitter, SOF first: instant and level from then on.
    pub fn edges(&self, start: Time, bit_time: Time) -> Vec<(Time, bool)> {
        let mut edges = Vec::new();
        let mut level = true;
        for (index, &bit) in self.bits.iter().enumerate() {
            if bit != level {
                edges.push((start + Time(bit_time.0 * index as u64), bit));
                level = bit;
            }
        }
        edges
    }

    /// The frame with its timing, SOF at `start`.
    pub fn trace(&self, frame: WireFrame, transmitter: usize, start: Time, bit_time: Time) -> Trace {
        let end = start + Time(bit_time.0 * self.bits.len() as u64);
        Trace { frame, transmitter, start, end, bit_time, edges: self.edges(start, bit_time) }
    }
}

impl Trace {
    /// The edges as a node `delay` away from the transmitter sees them.
    pub fn edges_after(&self, delay: Time) -> impl Iterator<Item = (Time, bool)> + '_ {
        self.edges.iter().map(move |&(at, level)| (at + delay, level))
    }
}

/// Bits from SOF to the end of the data field, and how many of them arbitrate.
fn layout(frame: &WireFrame) -> (Vec<bool>, usize) {
    let mut bits = Vec::with_capacity(128);
    bits.push(false);
    match frame.id {
        WireId::Standard(id) => {
            push(&mut bits, u32::from(id), 11);
            bits.push(frame.remote);
            bits.push(false); // IDE
        }
        WireId::Extended(id) => {
            push(&mut bits, id >> 18, 11);
            bits.extend([true, true]); // SRR, IDE
            push(&mut bits, id, 18);
            bits.push(frame.remote);
        }
    }
    let arbitration = bits.len();
    if let WireId::Extended(_) = frame.id {
        bits.push(false); // r1
    }
    bits.push(false); // r0
    push(&mut bits, u32::from(frame.dlc), 4);
    for &byte in frame.payload() {
        push(&mut bits, u32::from(byte), 8);
    }
    (bits, arbitration)
}

/// Appends the `count` low bits of `value`, highest first.
fn push(bits: &mut Vec<bool>, value: u32, count: u32) {
    bits.extend((0..count).rev().map(|shift| value >> shift & 1 == 1));
}

/// CRC-15/CAN of a bit string (ISO 11898-1, 10.4.2.6).
fn crc15(bits: &[bool]) -> u16 {
    bits.iter().fold(0, |crc, &bit| {
        let shifted = crc << 1 & 0x7FFF;
        if bit != (crc & 0x4000 != 0) { shifted ^ CRC_POLYNOMIAL } else { shifted }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The catalogue of parametrised CRC algorithms gives 059Eh as the check value of CRC-15/CAN.
    #[test]
    fn crc_of_the_catalogue_check_string() {
        let mut bits = Vec::new();
        for byte in b"123456789" {
            push(&mut bits, u32::from(*byte), 8);
        }
        assert_eq!(crc15(&bits), 0x059E);
    }
}
