//! The checksum of a set of parameters: CRC-32C (Castagnoli), which also finds one flipped bit.
//!
//! Two different sets with their checksums differ in at least four bits, whatever their length (Koopman 2002). So one
//! flipped bit is corrected and two are detected. More are taken for a single flipped bit with a probability of one in
//! 16,000.
//!
//! The crate `crc` 3.4 computes the same checksum. Measured with each: model cycles to open a store with a set of 16 KiB,
//! the flash of the slave on the pyboard, and the part of it that is board support (row
//! `size.pyboard-v11.slave.flash.boards`):
//!
//! | code | cycles | flash, bytes | board support, bytes |
//! | --- | --- | --- | --- |
//! | this module | 570,130 | 83,688 | 12,894 |
//! | `crc`, `Table<1>` | 226,021 | 84,744 (+1.3 %) | 13,990 (+8.5 %) |
//! | `crc`, `NoTable` | 1,914,845 (+236 %) | 83,824 (+0.2 %) | 13,074 (+1.4 %) |
//!
//! With `Table<1>` other code moves in flash, and the row `rx.interrupt_to_dictionary_median_accelerated` is 2.6 % higher.

/// Generator, lowest power at the highest bit.
const GENERATOR: u32 = 0x82F6_3B78;

/// Remainders of four bits. A table for bytes would take a KiB; without a table a set of 16 KiB takes 10 ms.
const TABLE: [u32; 16] = {
    let (mut table, mut bits) = ([0; 16], 0);
    while bits < 16 {
        table[bits] = step(step(step(step(bits as u32))));
        bits += 1;
    }
    table
};

/// A checksum in progress.
pub struct Crc(u32);

impl Crc {
    /// Returns the initial checksum.
    pub const fn new() -> Crc {
        Crc(u32::MAX)
    }

    /// Adds the next bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        let mut crc = self.0;
        for byte in bytes {
            crc ^= u32::from(*byte);
            for _ in 0..2 {
                crc = crc >> 4 ^ TABLE[crc as usize % 16];
            }
        }
        self.0 = crc;
    }

    /// Returns the checksum of all bytes added.
    pub const fn value(&self) -> u32 {
        !self.0
    }
}

const fn step(remainder: u32) -> u32 {
    remainder >> 1 ^ if remainder & 1 == 1 { GENERATOR } else { 0 }
}

/// Returns the single flipped bit that makes the checksums of `bits` bits differ by `difference`. Bit 0 is the lowest
/// bit of the first byte; the bits of the checksum follow the data. Returns `None` if more than one bit is flipped.
pub fn flipped(difference: u32, bits: u32) -> Option<u32> {
    // Difference that one flipped bit causes, beginning with the last bit of the checksum.
    let mut made = 1 << 31;
    for bit in (0..bits + 32).rev() {
        if made == difference {
            return Some(bit);
        }
        made = step(made);
    }
    None
}
