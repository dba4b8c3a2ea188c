//! Check of the program in flash: at each reset before anything else, and in the background.
//!
//! The *seal* is the length of the program and a word with which its remainder is zero. The CRC unit of the chip computes
//! the remainder (CRC-32/MPEG-2 of the words). `ecss-can` writes the seal into the image after linking; the linker alone leaves
//! it erased, and then nothing is checked. The program is flash from its start to the end of the last segment, without the
//! parameter store. Gaps between segments count as erased.
//!
//! A remainder other than zero says which bit is wrong, if one is. The core then reads the right word in place of the wrong
//! one ([`mend`]). So a flipped bit of the program costs a reset at most, unless it is in the first few hundred bytes that run
//! after a reset, or in the vector table.
//!
//! | board | check in the background | a pass takes |
//! | --- | --- | --- |
//! | [`Board`](crate::Board) | task of `ecss-can-runtime` | 0.8 s with 90 KiB |
//! | [`MinimalBoard`](crate::MinimalBoard) | interrupt of the supervisor | 4.1 s with 20 KiB |
//!
//! Applications must not use the CRC unit.

mod remainder;

#[cfg(target_os = "none")]
mod mend;

#[cfg(all(target_os = "none", feature = "full"))]
mod background;

#[cfg(all(target_os = "none", not(feature = "full")))]
mod background_minimal;

#[cfg(all(target_os = "none", feature = "full"))]
pub use background::check_program;
#[cfg(all(target_os = "none", not(feature = "full")))]
pub(crate) use background_minimal::on_tick;
#[cfg(target_os = "none")]
pub use mend::mend_program;
