//! A *control word* of the log: fifteen bits that outlast a flipped bit and an interrupted write.
//!
//! ```text
//! bits 0 to 14    number
//! bit 15          parity: bits 0 to 15 have an even number of ones
//! bits 16 to 31   complement of bits 0 to 15
//! ```
//! A bit and its complement are a pair. Two words differ in two pairs at least, and in each of these pairs each word has
//! a one where the other has a zero. This gives what flash needs:
//!
//! * One flipped bit is corrected: it makes one pair equal, and the parity gives its value. Two are detected.
//! * A write that was interrupted leaves some zeros unwritten, an interrupted erase sets some bits. Neither reads as
//!   another number, even with one bit corrected.

/// The control word of a number of 15 bits.
pub fn encode(number: u16) -> u32 {
    let low = number | (number.count_ones() as u16 & 1) << 15;
    u32::from(!low) << 16 | u32::from(low)
}

/// The number of a control word with at most one flipped bit.
#[inline(never)]
pub fn decode(word: u32) -> Option<u16> {
    let (low, other) = (word as u16, !(word >> 16) as u16);
    let number = if low.count_ones().is_multiple_of(2) { low } else { other };
    let is_sound = (low ^ other).count_ones() <= 1 && number.count_ones().is_multiple_of(2);
    is_sound.then_some(number & 0x7FFF)
}
