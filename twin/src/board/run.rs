//! Advances a board in time: its core runs until the next event of the board, sleeps, or waits for its flash.

use super::{AccessError, EmulatedBoard, State};
use crate::chip::Watching;
use crate::cpu::Stop;
use crate::mmio::{Refusal, RefusedAccess};
use crate::peripherals::ResetCause;
use crate::wire::time::Time;

/// Number of HardFault (DDI 0403E B1.5.2).
const HARD_FAULT: u16 = 3;
/// The system control register, which holds SLEEPDEEP (DDI 0403 B3.2.7).
const SCR: u32 = 0xE000_ED10;

impl EmulatedBoard {
    /// Returns the instant of the board's next activity if no wire changes; zero while its core is awake.
    pub fn next_event(&self) -> Time {
        match self.state {
            State::Off => Time::NEVER,
            State::Running if !self.asleep && !self.is_stalled() => Time::ZERO,
            _ => {
                let can = self.chip.peripherals.can.next_event().unwrap_or(Time::NEVER);
                let event = match self.state {
                    State::Running => self.wake_event(),
                    State::Refused(_) => u64::MAX,
                    _ => self.watchdog.map_or(u64::MAX, |(_, cycle)| cycle),
                };
                let timer = if event == u64::MAX { Time::NEVER } else { self.chip.clock.time_at(event) };
                can.min(timer)
            }
        }
    }

    /// Returns the present of the board. It may be later than the requested instant by the rest of an instruction.
    pub fn now(&self) -> Time {
        self.chip.clock.now().time
    }

    /// Runs until `until`.
    ///
    /// # Errors
    /// [`AccessError`] when the program made an access that the model refuses. The board stays stopped.
    pub fn run_until(&mut self, until: Time) -> Result<(), AccessError> {
        loop {
            let result = self.run(until);
            match self.state {
                State::Off => self.chip.clock.jump_to(until),
                State::Running => {}
                // A core that does not run does not feed the watchdog.
                State::Stuck | State::LockedUp | State::Halted => match self.watchdog {
                    Some((_, cycle)) if self.chip.clock.time_at(cycle) < until => {
                        self.chip.clock.advance_to_cycle(cycle);
                        self.on_event();
                        continue;
                    }
                    _ => self.chip.clock.advance_to(until),
                },
                State::Refused(_) => self.chip.clock.advance_to(until),
            }
            return result;
        }
    }

    fn run(&mut self, until: Time) -> Result<(), AccessError> {
        let before = self.counters.instructions;
        while self.state == State::Running && self.now() < until {
            self.follow_sleep();
            if self.asleep || self.is_stalled() {
                self.sleep(until);
            } else {
                self.execute(until)?;
                self.skip_turns(until);
            }
        }
        if self.counters.instructions != before {
            if self.state == State::Running && self.core.is_locked_up() {
                self.counters.lockups += 1;
                self.state = State::LockedUp;
            }
            self.drain();
        }
        Ok(())
    }

    /// Returns the cycle at which a core that sleeps or waits for its flash may continue.
    fn wake_event(&self) -> u64 {
        // A stalled core cannot take the exception.
        if self.is_stalled() { self.timer_event } else { self.timer_event.min(self.core.systick_event()) }
    }

    fn sleep(&mut self, until: Time) {
        let event = self.wake_event();
        if event == u64::MAX || self.chip.clock.time_at(event) > until {
            self.chip.clock.advance_to(until);
            return;
        }
        self.chip.clock.advance_to_cycle(event);
        // The next step of the core takes the pending exception.
        self.asleep &= event < self.core.systick_event();
        if event >= self.timer_event {
            self.on_event();
        }
    }

    /// Handles `timer_event` at its cycle.
    fn on_event(&mut self) {
        let now = self.chip.clock.now().cycle;
        if self.watchdog.is_some_and(|(_, cycle)| cycle <= now) {
            self.counters.watchdog_resets += 1;
            self.start(ResetCause::Watchdog);
        } else if self.flash.event() <= now {
            self.on_flash_event();
        } else {
            self.refresh();
        }
    }

    /// Runs the core until `until`, the next event of the board, or an access that may change this event.
    fn execute(&mut self, until: Time) -> Result<(), AccessError> {
        let (began, pc, exception) = (self.chip.clock.now().cycle, self.core.pc(), self.core.exception());
        let is_turn = self.branches_to_itself();
        // Busy flash may stop the core after any instruction; iterations of a spinning core are counted.
        let is_stepped = is_turn || self.flash.is_busy() || exception == HARD_FAULT;
        let end = self.chip.clock.cycle_reaching(until).min(self.timer_event);
        self.core.advance_to(began);
        let budget = if is_stepped { 1 } else { end.saturating_sub(began) };
        let run = match &mut self.uses {
            Some(uses) => self.core.run(&mut Watching { chip: &mut self.chip, uses }, budget),
            None => self.core.run(&mut self.chip, budget),
        };

        let cycle = self.core.cycle();
        self.chip.clock.advance_to_cycle(cycle);
        self.counters.instructions += run.steps;
        self.counters.cycles_awake += cycle - began;
        self.asleep = run.asleep;
        let spins = is_turn && !run.asleep && self.core.pc() == pc && self.core.exception() == exception;
        self.spin.follow(spins.then(|| (cycle - began, self.core.systick_event())));

        if std::mem::take(&mut self.chip.needs_attention) {
            if let Some(refused) = self.chip.refused.take() {
                return Err(self.refuse(refused));
            }
            self.refresh();
        }
        if run.asleep && self.core.sleeps_deeply() {
            let refused = RefusedAccess { address: SCR, write: false, refusal: Refusal::DeepSleep };
            return Err(self.stop_at(self.core.pc(), refused));
        }
        if exception != HARD_FAULT && self.core.exception() == HARD_FAULT {
            self.on_hard_fault();
        }
        if self.core.exception() == HARD_FAULT && self.branches_to_itself() {
            self.state = State::Stuck;
        }
        if let Some(stop) = run.stop {
            self.on_stop(stop)?;
        }
        if self.chip.clock.now().cycle >= self.timer_event {
            self.on_event();
        }
        Ok(())
    }

    /// Handles the entry of the core into HardFault.
    fn on_hard_fault(&mut self) {
        self.drain();
        if !self.panicked {
            self.counters.panics += 1;
            self.panicked = true;
        }
    }

    fn on_stop(&mut self, stop: Stop) -> Result<(), AccessError> {
        match stop {
            Stop::Breakpoint { .. } => {
                self.drain();
                self.stand_still();
                Ok(())
            }
            Stop::ResetRequest => {
                self.counters.system_resets += 1;
                self.start(ResetCause::Software);
                Ok(())
            }
            Stop::Unmodelled { address, write, .. } => {
                let refused = RefusedAccess { address, write, refusal: Refusal::SystemRegister };
                Err(self.stop_at(self.core.pc(), refused))
            }
            Stop::Unpredictable { address, word } => {
                let refusal = Refusal::Unpredictable { word };
                Err(self.stop_at(self.core.pc(), RefusedAccess { address, write: false, refusal }))
            }
        }
    }
}
