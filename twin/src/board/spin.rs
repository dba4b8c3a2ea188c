//! A core that branches to itself: its iterations are counted, not executed.
//!
//! A program that hangs executes `B .` 56 million times a second. All iterations are equal until an exception is
//! pending, so the board skips as many of them as fit before the next event. Instructions, cycles, SysTick and CYCCNT
//! end as if each had been executed.

use super::{EmulatedBoard, State};
use crate::mmio::Width;
use crate::wire::time::Time;

/// Equal iterations in a row after which the accelerator's timing no longer changes.
const STEADY: u32 = 8;

/// `B .` (DDI 0403E A7.7.12, encoding T2).
const BRANCH_TO_ITSELF: u32 = 0xE7FE;

/// Iterations of a spinning core.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spin {
    /// Cycles of the last iteration.
    cycles: u64,
    /// Cycle at which SysTick pends its exception. A changed value means that it has just done so.
    systick: u64,
    /// Number of consecutive iterations with the same length and the same SysTick.
    turns: u32,
}

impl Spin {
    /// Records the cycles of an iteration, and the cycle at which SysTick pends its exception. `None`: the core
    /// executed another instruction.
    pub(super) fn follow(&mut self, turn: Option<(u64, u64)>) {
        self.turns = match turn {
            Some(turn) if turn == (self.cycles, self.systick) => self.turns.saturating_add(1),
            Some(_) => 1,
            None => 0,
        };
        (self.cycles, self.systick) = turn.unwrap_or_default();
    }

    /// Ends skipping after a change of interrupt lines or events: the core has to run before iterations are skipped
    /// again.
    pub(super) fn end(&mut self) {
        self.turns = 0;
    }
}

impl EmulatedBoard {
    /// Returns whether the next instruction branches to itself.
    pub(super) fn branches_to_itself(&self) -> bool {
        let memory = &self.chip.memory;
        let place = self.core.code_address().and_then(|address| memory.place(address));
        place.and_then(|place| memory.load(place, Width::Half)) == Some(BRANCH_TO_ITSELF)
    }

    /// Skips iterations of a spinning core after a step, as long as nothing happens before `until`. The core executes
    /// the last one before an event.
    pub(super) fn skip_turns(&mut self, until: Time) {
        if self.spin.turns < STEADY || self.state != State::Running || self.now() >= until {
            return;
        }
        let now = self.chip.clock.now().cycle;
        let event = self.chip.clock.cycle_at(until).min(self.timer_event).min(self.spin.systick);
        let turns = (event.saturating_sub(now) / self.spin.cycles).saturating_sub(1);
        let cycles = turns * self.spin.cycles;
        self.chip.clock.advance_to_cycle(now + cycles);
        self.counters.instructions += turns;
        self.counters.cycles_awake += cycles;
    }
}
