//! The check in the background, as a task.

use embassy_time::Timer;

use super::mend::{add, begin, mend_program, sealed, whole};
use crate::registers::UPSETS;

/// Lines that are added between two turns of the other tasks.
const SLICE: usize = 16;
/// Time between two slices in microseconds. A program of 90 KiB is checked in 0.8 s, before a master misses three heartbeats of
/// a slave with a flipped bit.
const PERIOD: u64 = 2_000;

/// Checks the program again and again. Returns at once if it has no seal.
///
/// # Cancel safety
/// The check begins again at its next call.
pub async fn check_program() {
    let program = sealed();
    if program.is_empty() {
        return;
    }
    loop {
        begin();
        let mut remainder = 0;
        for slice in program.chunks(SLICE) {
            Timer::after_micros(PERIOD).await;
            remainder = add(slice);
        }
        // A bit of this check may have flipped, too. `mend_program` begins again.
        UPSETS.set_program(if remainder == 0 { whole() } else { mend_program() });
    }
}
