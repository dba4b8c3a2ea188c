//! A core that branches to itself: its turns are counted, not executed.
//!
//! A program that hangs executes `B .` 56 million times a second. All turns are alike until an exception is pending, so the board
//! advances by as many of them as fit before the next event. Instructions, cycles, SysTick and CYCCNT end as if each had been executed.

use can_wire::time::Time;

use super::{EmulatedBoard, State};
use crate::mmio::Width;

/// Equal turns in a row after which the accelerator answers each alike.
const STEADY: u32 = 8;

/// `B .` (DDI 0403E A7.7.12, encoding T2).
const BRANCH_TO_ITSELF: u32 = 0xE7FE;

/// The turns that a core has spun.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spin {
    /// Cycles of the last turn.
    cycles: u64,
    /// When SysTick pends its exception: another value than before means that it has just done so.
    systick: u64,
    /// Turns in a row with the same length and the same SysTick.
    turns: u32,
}

impl Spin {
    /// Takes the cycles of a turn, and the cycle at which SysTick pends its exception. `None`: the core did something else.
    pub(super) fn follow(&mut self, turn: Option<(u64, u64)>) {
        self.turns = match turn {
            Some(turn) if turn == (self.cycles, self.systick) => self.turns.saturating_add(1),
            Some(_) => 1,
            None => 0,
        };
        (self.cycles, self.systick) = turn.unwrap_or_default();
    }

    /// Interrupt lines or events have changed: the core has to run before turns are skipped again.
    pub(super) fn end(&mut self) {
        self.turns = 0;
    }
}

impl EmulatedBoard {
    /// Returns whether the next instruction branches to itself.
    pub(super) fn branches_to_itself(&self) -> bool {
        let memory = &self.chip.memory;
        let place = memory.place(self.core.pc());
        place.and_then(|place| memory.load(place, Width::Half)) == Some(BRANCH_TO_ITSELF)
    }

    /// After a step: lets the turns of a core that spins pass, as long as nothing happens before `until`. The last one before an
    /// event is left to the core.
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
