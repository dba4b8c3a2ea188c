//! Falling edges of a frame, in bit times after its start.
//!
//! They follow from the frame by layout, CRC-15 and bit stuffing of ISO 11898-1 10.4 and 10.5.

use heapless::Vec;

use crate::types::Frame;

/// Stuffed bits of the longest frame up to its CRC are 122, so no frame has more than 61 falling edges there.
const MAX_EDGES: usize = 64;

/// Generator of CRC-15 without its leading term.
const CRC: u16 = 0x4599;

/// The falling edges of one frame.
pub(super) struct Pattern {
    /// Bit times after SOF, rising: the first is SOF, the last the ACK slot.
    pub edges: Vec<u8, MAX_EDGES>,
    /// The first edge after the arbitration field: only the transmitter drives it.
    pub reference: usize,
    /// Bits from SOF to the last bit of EOF.
    pub length: u8,
}

impl Pattern {
    /// Returns the edges of a frame on the wire. A frame that was sent with a DLC above 8 has other edges.
    pub fn of(frame: &Frame) -> Pattern {
        let mut bits = Bits { edges: Vec::new(), length: 0, recessive: true, run: 0, crc: 0 };
        bits.push(u32::from(frame.id().raw()), 12); // SOF and identifier
        let reference = bits.edges.len();
        bits.push(u32::from(frame.dlc()), 7); // RTR, IDE, r0 and DLC
        frame.data().iter().for_each(|byte| bits.push(u32::from(*byte), 8));
        bits.push(u32::from(bits.crc), 15);
        // CRC delimiter, ACK slot, ACK delimiter, seven bits of EOF.
        bits.level(true);
        bits.level(false);
        Pattern { edges: bits.edges, reference, length: bits.length + 8 }
    }

    /// Returns the place of the ACK slot, in bit times after SOF.
    pub fn ack(&self) -> u8 {
        self.length - 9
    }
}

struct Bits {
    edges: Vec<u8, MAX_EDGES>,
    length: u8,
    recessive: bool,
    run: u8,
    crc: u16,
}

impl Bits {
    /// The low `count` bits of `value`, highest first, stuffed.
    fn push(&mut self, value: u32, count: u32) {
        for shift in (0..count).rev() {
            let bit = value >> shift & 1 == 1;
            let feedback = bit != (self.crc & 0x4000 != 0);
            self.crc = self.crc << 1 & 0x7FFF ^ if feedback { CRC } else { 0 };
            self.level(bit);
            if self.run == 5 {
                self.level(!bit);
            }
        }
    }

    fn level(&mut self, recessive: bool) {
        if recessive == self.recessive {
            self.run += 1;
        } else {
            self.run = 1;
            self.recessive = recessive;
            if !recessive {
                let fits = self.edges.push(self.length).is_ok();
                debug_assert!(fits, "a frame has at most 62 falling edges");
            }
        }
        self.length += 1;
    }
}
