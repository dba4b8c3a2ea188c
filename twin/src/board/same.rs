//! Comparison of two copies of a board.

use super::EmulatedBoard;

impl EmulatedBoard {
    /// Returns whether another copy of this board continues exactly alike. `false` may also mean that the states differ in a way that
    /// has no effect. Counters and logs do not count.
    pub fn continues_as(&self, other: &EmulatedBoard) -> bool {
        let (here, there) = (&self.chip, &other.chip);
        self.core == other.core
            && self.state == other.state
            && (self.asleep, self.lines, self.nmi) == (other.asleep, other.lines, other.nmi)
            && (self.timer_event, self.watchdog) == (other.timer_event, other.watchdog)
            && here.memory == there.memory
            && here.accelerator == there.accelerator
            && !self.flash.is_busy()
            && !other.flash.is_busy()
            && format!("{:?}", here.clock) == format!("{:?}", there.clock)
            && format!("{:?}", here.peripherals) == format!("{:?}", there.peripherals)
    }
}
