//! Comparison of two copies of a board.

use super::EmulatedBoard;
use crate::chip::{Use, Uses};
use crate::peripherals::RegisterUses;

impl EmulatedBoard {
    /// Returns whether this copy of a board continues exactly as another one. `later` has the uses of the other copy from now to the end
    /// of the time in question. A byte that it does not use, or writes first, does not count, nor does a register without effect that it
    /// does not access. Without `later` all of them count, and `false` may also mean that the states differ in a way that has no effect.
    /// Counters and logs do not count.
    pub fn continues_as(&self, other: &EmulatedBoard, later: Option<&Uses>) -> bool {
        let (here, there) = (&self.chip, &other.chip);
        let cycle = here.clock.now().cycle;
        let probed = self.rtt.control_block();
        // The debug probe reads the control block of the log.
        let counts = |address: u32| {
            probed.contains(&address) || later.is_none_or(|later| later.at(address) == Use::Read)
        };
        self.state == other.state
            && (self.asleep, self.lines, self.nmi) == (other.asleep, other.lines, other.nmi)
            && (self.timer_event, self.watchdog) == (other.timer_event, other.watchdog)
            && !self.flash.is_busy()
            && !other.flash.is_busy()
            && format!("{:?}", here.clock) == format!("{:?}", there.clock)
            && here.memory.continues_as(&there.memory, counts)
            && here.accelerator.continues_as(&there.accelerator, cycle)
            && self.core.continues_as(&other.core, cycle, later.is_none_or(Uses::uses_fpu))
            && here.peripherals.continues_as(
                &there.peripherals,
                cycle,
                later.map(|later| later as &dyn RegisterUses),
            )
    }
}
