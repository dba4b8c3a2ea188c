//! A *control word* of the log: fifteen bits that are protected against a flipped bit and an interrupted write.
//!
//! ```text
//! bits 0 to 14    number
//! bit 15          parity: bits 0 to 15 have an even number of ones
//! bits 16 to 31   complement of bits 0 to 15
//! ```
//! A bit and its complement are a pair. Two words differ in two pairs at least, and in each of these pairs each word
//! has a one where the other has a zero. This gives:
//!
//! * One flipped bit is corrected: it makes one pair equal, and the parity gives its value. Two are detected.
//! * A write that was interrupted leaves some zeros unwritten, an interrupted erase sets some bits. Neither reads as
//!   another number, even with one bit corrected.

/// Returns the control word of a number of 15 bits.
pub fn encode(number: u16) -> u32 {
    let low = u32::from(number | parity(number) << 15);
    !low << 16 | low
}

/// Returns the number of a control word. `None` if more than one bit is flipped.
pub fn decode(word: u32) -> Option<u16> {
    let (low, other) = (word as u16, !(word >> 16) as u16);
    let number = if parity(low) == 0 { low } else { other };
    let differ = low ^ other;
    // At most one flipped bit.
    let is_sound = differ & differ.wrapping_sub(1) == 0 && parity(number) == 0;
    is_sound.then_some(number & 0x7FFF)
}

/// Returns whether [`decode`] corrected a bit of this word.
pub fn is_flipped(word: u32) -> bool {
    !(word >> 16) as u16 != word as u16
}

/// Returns 1 for an odd number of ones, otherwise 0.
#[inline(never)] // row `size.pyboard-v11.slave.flash`: five of these save 40 bytes
fn parity(bits: u16) -> u16 {
    let bits = bits ^ bits >> 8;
    let bits = bits ^ bits >> 4;
    // The parity of each number of four bits.
    0x6996 >> (bits & 0xF) & 1
}
