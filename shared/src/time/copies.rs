//! Copies of the clock of a time producer, which no other node corrects.

use super::LocalClock;
use super::clock::Course;
use crate::types::correct;

/// Two copies of the course of a [`LocalClock`]: two of the three have to agree.
#[derive(Clone, Debug)]
pub(crate) struct ClockCopies([Course; 2]);

impl Default for ClockCopies {
    fn default() -> Self {
        ClockCopies([LocalClock::default().course(); 2])
    }
}

impl ClockCopies {
    /// Corrects the clock by its copies, or takes copies of a clock that was set or steered. Call it periodically. Returns whether a
    /// bit was wrong.
    pub fn compare(&mut self, clock: &mut LocalClock) -> bool {
        let ClockCopies([first, second]) = self;
        let mut course = clock.course();
        // A pair moves start and instant, a command number and value at least. A flipped bit is in one of them.
        if course.differences(first) > 1 {
            (*first, *second) = (course, course);
            return false;
        }
        let is_wrong = correct([&mut course, first, second]);
        clock.restore(&course);
        is_wrong
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{FineInstant, FineScet};

    const UNITS_PER_SECOND: u64 = FineInstant::PER_MICRO * 1_000_000;

    /// Given a clock with its copies that was set at 10 s.
    fn at_ten_seconds() -> (LocalClock, ClockCopies) {
        let (mut clock, mut copies) = (LocalClock::default(), ClockCopies::default());
        clock.set(FineInstant::from_units(10 * UNITS_PER_SECOND), FineScet::from_units(1_000 << 32));
        assert!(!copies.compare(&mut clock));
        assert!(!copies.compare(&mut clock));
        (clock, copies)
    }

    /// Given a clock that was set, when any bit of its course or of a copy flips, then it shows the time that it showed before after
    /// the next comparison.
    #[test]
    fn any_flipped_bit_of_the_course_is_corrected() {
        let flips: [fn(&mut Course, u32); 8] = [
            |course, bit| course.base = FineInstant::from_units(course.base.units() ^ 1 << bit),
            |course, bit| course.scet = FineScet::from_units(course.scet.units() ^ 1 << bit),
            |course, bit| course.heard = FineInstant::from_units(course.heard.units() ^ 1 << bit),
            |course, bit| course.residue ^= 1 << bit,
            |course, bit| course.rate ^= 1 << (bit % 32),
            |course, bit| course.drift ^= 1 << (bit % 32),
            |course, bit| course.slew ^= 1 << (bit % 32),
            |course, bit| course.steps ^= 1 << (bit % 16),
        ];
        for (copy, flip) in (0..3).flat_map(|copy| flips.iter().map(move |flip| (copy, flip))) {
            for bit in 0..64 {
                let (mut clock, mut copies) = at_ten_seconds();
                let before = clock.clone();
                let mut course = clock.course();
                match copy {
                    0 => {
                        flip(&mut course, bit);
                        clock.restore(&course);
                    }
                    nth => flip(&mut copies.0[nth - 1], bit),
                }
                assert!(copies.compare(&mut clock), "copy {copy}, bit {bit}");
                assert!(!copies.compare(&mut clock), "copy {copy}, bit {bit}");
                assert_eq!(clock, before, "copy {copy}, bit {bit}");
            }
        }
    }

    /// Given a clock with its copies, when it is set again, also at the same instant, then the comparison keeps the new time.
    #[test]
    fn a_time_that_is_set_is_kept() {
        let (mut clock, mut copies) = at_ten_seconds();
        for second in [10, 11] {
            let at = FineInstant::from_units(second * UNITS_PER_SECOND);
            clock.set(at, FineScet::from_units(5 << 32));
            assert!(!copies.compare(&mut clock));
            assert_eq!(clock.at(at), FineScet::from_units(5 << 32));
        }
    }
}
