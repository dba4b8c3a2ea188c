//! Check of the program in flash, in the background.
//!
//! The *seal* is length and checksum (CRC-32C) of the program. `ecss-can` writes it into the image after linking; the
//! linker alone leaves it erased. The check computes the checksum again and again, [`SLICE`] bytes between two turns of the
//! other tasks, and compares it with the seal. It covers flash from its start to the end of the last segment, without the seal and
//! without the parameter store. Gaps between segments count as erased.
//!
//! A pass takes 4.8 s, whatever the length of the program. A bit of the check itself may flip, too. So the program counts
//! as damaged after two passes in a row with a wrong checksum, the second one in 1.2 s. It is whole again after a right
//! one.

use ecss_can::node::ProgramState;

use crate::crc::Crc;

/// Bytes of a slice. With 128 bytes the row `rx.inside_look_accelerated` is 9,756 or more.
const SLICE: usize = 16;
/// Size of the seal, bytes.
const SEAL: usize = 8;

/// A check in progress.
struct Check {
    /// Offset of the next slice.
    at: usize,
    crc: Crc,
    /// Whether the pass before this one had a wrong checksum.
    was_wrong: bool,
}

impl Check {
    const fn new() -> Check {
        Check { at: 0, crc: Crc::new(), was_wrong: false }
    }

    /// Adds the next slice of the program, whose seal is at the offset `seal`, behind the vector table. Returns the result
    /// at the end of a pass, except of a first one with another checksum than `expected`.
    fn step(&mut self, program: &[u8], seal: usize, expected: u32) -> Option<ProgramState> {
        let end = if self.at < seal { seal } else { program.len() };
        let next = end.min((self.at | (SLICE - 1)).saturating_add(1));
        self.crc.update(program.get(self.at..next).unwrap_or_default());
        self.at = if next == seal { seal + SEAL } else { next };
        if self.at < program.len() {
            return None;
        }
        let is_wrong = self.crc.value() != expected;
        let was_wrong = self.was_wrong;
        *self = Check { was_wrong: is_wrong, ..Check::new() };
        match (is_wrong, was_wrong) {
            (false, _) => Some(ProgramState::Whole),
            (true, true) => Some(ProgramState::Damaged),
            (true, false) => None,
        }
    }
}

#[cfg(target_os = "none")]
pub use chip::check_program;

#[cfg(target_os = "none")]
mod chip {
    use core::future::poll_fn;
    use core::ptr::addr_of;
    use core::task::Poll;

    use embassy_time::Timer;

    use super::{Check, SLICE};
    use crate::registers::UPSETS;

    /// Bytes of slices in a row, after which the check waits.
    const GROUP: usize = 128;
    /// Duration of a pass in microseconds.
    const PASS: u32 = 4_800_000;
    /// Factor by which a pass is faster after one with a wrong checksum.
    const FASTER: u32 = 4;
    /// Length of a program without a seal: erased flash.
    const NONE: u32 = u32::MAX;

    /// Seal of the program.
    #[repr(C)]
    struct Seal {
        /// Length of the program in bytes.
        bytes: u32,
        crc: u32,
    }

    /// The program `ecss-can` finds it by this name and writes it.
    // SAFETY: no other symbol has this name.
    #[unsafe(export_name = "__program_seal")]
    static SEAL: Seal = Seal { bytes: NONE, crc: u32::MAX };

    unsafe extern "C" {
        static __vector_table: u8;
        static __store_start: u8;
    }

    /// Checks the program again and again. Returns at once if it has no seal.
    ///
    /// # Cancel safety
    /// The check begins again at its next call.
    pub async fn check_program() {
        // SAFETY: the seal is a static. The read is volatile: the compiler knows the initial value only.
        let Seal { bytes, crc } = unsafe { addr_of!(SEAL).read_volatile() };
        if bytes == NONE {
            return;
        }
        let start = addr_of!(__vector_table);
        // A flipped bit of the length leads to a wrong checksum, not out of the flash.
        let room = addr_of!(__store_start) as usize - start as usize;
        let bytes = room.min(bytes as usize);
        // SAFETY: flash from the vector table to the parameter store is readable, and no code of a node writes it.
        let program = unsafe { core::slice::from_raw_parts(start, bytes) };
        let seal = addr_of!(SEAL) as usize - start as usize;
        let period = PASS * GROUP as u32 / (bytes as u32).max(1);
        let mut check = Check::new();
        loop {
            let wait = if check.was_wrong { period / FASTER } else { period };
            Timer::after_micros(wait.into()).await;
            let mut has_given_way = false;
            poll_fn(|context| {
                // An executor may poll the task first that was woken last. A frame that came before the timer, or comes with the
                // slice, has precedence.
                let is_last = has_given_way && check.at % GROUP >= GROUP - SLICE;
                if !is_last {
                    context.waker().wake_by_ref();
                }
                if !core::mem::replace(&mut has_given_way, true) {
                    return Poll::Pending;
                }
                if let Some(state) = check.step(program, seal, crc) {
                    UPSETS.set_program(state);
                }
                if is_last { Poll::Ready(()) } else { Poll::Pending }
            })
            .await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTES: usize = 26 * SLICE + 8;
    /// Places of the seal: in the first slice, within another one, between two, and at the end.
    const PLACES: [usize; 4] = [4, 300, 16 * SLICE, BYTES - SEAL];

    /// A program, and its checksum without the seal by another implementation.
    fn program(seal: usize) -> (Vec<u8>, u32) {
        let program: Vec<u8> = (0..BYTES).map(|n| (n * n % 251) as u8).collect();
        let rest = [&program[..seal], &program[seal + SEAL..]].concat();
        (program, crc::Crc::<u32>::new(&crc::CRC_32_ISCSI).checksum(&rest))
    }

    /// Results of the passes of ten times as many slices as the program has.
    fn results(check: &mut Check, program: &[u8], seal: usize, expected: u32) -> Vec<ProgramState> {
        (0..10 * BYTES.div_ceil(SLICE)).filter_map(|_| check.step(program, seal, expected)).collect()
    }

    #[test]
    fn sealed_program_is_whole_after_each_pass() {
        for seal in PLACES {
            let (program, expected) = program(seal);
            let results = results(&mut Check::new(), &program, seal, expected);
            assert!((8..=10).contains(&results.len()), "{seal}: {results:?}");
            assert!(results.iter().all(|result| *result == ProgramState::Whole), "{seal}: {results:?}");
        }
    }

    /// Given a flipped bit of any byte but those of the seal, then the program is damaged, from the second pass on.
    #[test]
    fn flipped_bit_of_each_byte_damages_the_program() {
        for seal in PLACES {
            let (mut program, expected) = program(seal);
            for at in (0..BYTES).filter(|at| !(seal..seal + SEAL).contains(at)) {
                program[at] ^= 1 << (at % 8);
                let results = results(&mut Check::new(), &program, seal, expected);
                assert!(results.len() >= 7, "{at}: {results:?}");
                assert!(results.iter().all(|result| *result == ProgramState::Damaged), "{at}: {results:?}");
                program[at] ^= 1 << (at % 8);
            }
        }
    }

    #[test]
    fn repaired_program_is_whole_again() {
        let (mut program, expected) = program(300);
        let mut check = Check::new();
        program[0] ^= 1;
        assert_eq!(results(&mut check, &program, 300, expected).first(), Some(&ProgramState::Damaged));
        program[0] ^= 1;
        assert_eq!(results(&mut check, &program, 300, expected).last(), Some(&ProgramState::Whole));
    }

    /// Given a check of which any bit flips, then a whole program is never damaged.
    #[test]
    fn flipped_bit_of_the_check_damages_no_program() {
        let (program, expected) = program(300);
        for steps in 0..8 {
            for bit in 0..usize::BITS + 33 {
                let mut check = Check::new();
                for _ in 0..steps {
                    check.step(&program, 300, expected);
                }
                match bit.checked_sub(usize::BITS) {
                    None => check.at ^= 1 << bit,
                    Some(32) => check.was_wrong = true,
                    // Any other remainder.
                    Some(bit) => check.crc.update(&[bit as u8]),
                }
                let results = results(&mut check, &program, 300, expected);
                assert!(results.len() >= 8, "{steps} {bit}: {results:?}");
                assert!(
                    results.iter().all(|result| *result == ProgramState::Whole),
                    "{steps} {bit}: {results:?}"
                );
            }
        }
    }
}
