//! The parameter store: the last two sectors of 128 KiB of the chip's flash.
//!
//! The chip stands still while it erases, a second or two, so nothing is erased but in [`ParameterLog::open`], before the
//! controllers join their buses. Saving only programs words, 16 µs each; without room it answers that there is none.
//!
//! `sequential-storage` was tried for this. It erases inside of storing and even of fetching, needs the whole set in RAM,
//! and with an erase cut short it lost the set in 94 of 136,200 cases, for good. So sets are written here one after the
//! other, as a log, by rules simple enough to be tried at every operation (`log.rs`).

#[cfg(target_os = "none")]
mod chip;
mod crc;
mod log;
#[cfg(test)]
mod tests;
mod word;

#[cfg(target_os = "none")]
pub use chip::{ChipFlash, open};
#[cfg(target_os = "none")]
pub(crate) use crc::Crc;
pub use log::{MAX_SET, Opened, ParameterLog};
