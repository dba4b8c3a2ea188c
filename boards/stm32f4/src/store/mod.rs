//! The parameter store: the last two sectors of 128 KiB of the chip's flash.
//!
//! An erase stalls the chip for one or two seconds. Therefore only [`ParameterLog::open`] erases, before the
//! controllers join their buses. Saving only programs words, 16 µs each, and fails if there is no room.
//!
//! The crate `sequential-storage` was tried. It erases while storing and even while fetching, and needs the whole set
//! in RAM. With an interrupted erase it lost the set permanently in 94 of 136,200 cases. So sets are written one after
//! the other as a log, by rules simple enough to test a power failure at every operation (`log.rs`).

#[cfg(target_os = "none")]
mod chip;
mod log;
#[cfg(test)]
mod tests;
mod word;

#[cfg(target_os = "none")]
pub use chip::{ChipFlash, open};
pub use log::{MAX_SET, Opened, ParameterLog};
