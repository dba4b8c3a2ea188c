//! A core that branches to itself: its turns are counted, not executed.
//!
//! A program that hangs executes `B .` 56 million times a second. All turns are alike until an exception is pending, so the board
//! advances by as many of them as fit before the next event. Instructions, cycles, SysTick and CYCCNT end as if each had been executed.

use can_wire::time::Time;

use super::{EmulatedBoard, State};
use crate::cpu::Step;

/// Equal turns in a row after which the accelerator answers each alike.
const STEADY: u32 = 8;

/// The turns that a core has spun.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spin {
    /// Cycles of the last turn.
    cycles: u32,
    /// When SysTick pends its exception: another value than before means that it has just done so.
    systick: u64,
    /// Turns in a row with the same length and the same SysTick.
    turns: u32,
}

impl Spin {
    /// Takes what the core has just done.
    pub(super) fn follow(&mut self, step: Step) {
        self.turns = match step.spins {
            true if (step.cycles, step.systick) == (self.cycles, self.systick) => {
                self.turns.saturating_add(1)
            }
            true => 1,
            false => 0,
        };
        (self.cycles, self.systick) = (step.cycles, step.systick);
    }

    /// Interrupt lines or events have changed: the core has to run before turns are skipped again.
    pub(super) fn end(&mut self) {
        self.turns = 0;
    }
}

impl EmulatedBoard {
    /// After a step: lets the turns of a core that spins pass, as long as nothing happens before `until`. The last one before an
    /// event is left to the core.
    pub(super) fn skip_turns(&mut self, until: Time) {
        if self.spin.turns < STEADY || self.state != State::Running || self.now() >= until {
            return;
        }
        let now = self.clock.now().cycle;
        let event = self.clock.cycle_at(until).min(self.timer_event).min(self.systick);
        let turns = (event.saturating_sub(now) / u64::from(self.spin.cycles)).saturating_sub(1);
        if let Ok(cycles) = u32::try_from(turns * u64::from(self.spin.cycles)) {
            self.clock.advance(cycles);
            self.counters.instructions += turns;
            self.counters.cycles_awake += u64::from(cycles);
        }
    }
}
