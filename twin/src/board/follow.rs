//! Updates a board from its peripherals: clock tree, interrupt lines, next event, log.

use super::{Edge, EmulatedBoard};
use crate::chip::WatchedRam;
use crate::peripherals::{IrqLevels, ResetCause};
use crate::wire::time::Time;

impl EmulatedBoard {
    /// Resets the chip, and starts its program.
    pub(super) fn start(&mut self, cause: ResetCause) {
        self.drain();
        self.interrupt_flash();
        self.rtt.reset(&mut self.chip.memory);
        self.drive_lines([0; 3]);
        self.core.set_nmi(false);
        self.nmi = false;
        self.core.reset();
        self.chip.peripherals.reset(self.chip.clock.now().time, cause);
        self.admitted_before = self.admitted_in_all();
        self.chip.accelerator.reset();
        self.asleep = false;
        self.panicked = false;
        self.clocks = None;
        self.state = super::State::Running;
        self.refresh();
    }

    /// Updates clock tree, interrupt lines and next timer event after a change of the peripherals.
    pub(crate) fn refresh(&mut self) {
        self.spin.end();
        let chip = &mut self.chip;
        chip.peripherals.run_timers(chip.clock.now().cycle);
        self.edges.extend(chip.peripherals.take_timed_changes().into_iter().map(|change| {
            let (at, fraction) = chip.clock.exact_time_at(change.cycle);
            Edge { at, fraction, pin: change.pin, high: change.high }
        }));
        let clocks = chip.peripherals.rcc.clocks();
        let clocks_changed = self.clocks != Some(clocks);
        if clocks_changed {
            self.clocks = Some(clocks);
            let pclk1 = chip.clock.set(clocks);
            chip.peripherals.set_clocks(chip.clock.now().cycle, clocks, pclk1);
        }
        let now = chip.clock.now();
        // Repeats: timers raise requests, requests move data, moved data changes flags.
        let mut levels = chip.peripherals.irq_levels(now);
        let mut ram = WatchedRam { memory: &mut chip.memory, uses: self.uses.as_deref_mut() };
        if chip.peripherals.transfer(now, &mut ram) {
            levels = chip.peripherals.irq_levels(now);
        }
        self.can_lines = chip.peripherals.can.irqs();
        let nmi = chip.peripherals.rcc.nmi();
        if nmi != self.nmi {
            self.nmi = nmi;
            self.core.set_nmi(nmi);
            self.asleep &= !nmi;
        }
        self.follow_watchdog(clocks_changed);
        self.follow_flash(clocks_changed);
        self.timer_event = self.next_timer_event();
        self.drive_lines(levels);
    }

    /// The cycle of the next event of a timer, the watchdog or the flash; `u64::MAX` without one.
    fn next_timer_event(&self) -> u64 {
        let chip = &self.chip;
        let timer = chip.peripherals.next_timer_event(chip.clock.now()).unwrap_or(u64::MAX);
        let watchdog = self.watchdog.map_or(u64::MAX, |(_, cycle)| cycle);
        timer.min(watchdog).min(self.flash.event())
    }

    /// Drives the interrupt lines of the core.
    fn drive_lines(&mut self, levels: IrqLevels) {
        for (word, (&new, old)) in levels.iter().zip(&mut self.lines).enumerate() {
            let mut changed = new ^ *old;
            while changed != 0 {
                let bit = changed.trailing_zeros();
                changed &= changed - 1;
                let level = new >> bit & 1 == 1;
                self.core.set_irq((word * 32) as u16 + bit as u16, level);
                // A masked interrupt does not wake the core; the next step decides that.
                self.asleep &= !level;
            }
            *old = new;
        }
    }

    fn follow_watchdog(&mut self, clocks_changed: bool) {
        let deadline = self.chip.peripherals.watchdog_deadline();
        if clocks_changed || deadline != self.watchdog.map(|(at, _)| at) {
            // The first cycle that does not begin before the deadline.
            self.watchdog = deadline.map(|at: Time| (at, self.chip.clock.cycle_at(at) + 1));
        }
    }

    /// Reads the log as the debug probe does.
    pub(super) fn drain(&mut self) {
        let first = self.log.len();
        let at = self.now();
        self.rtt.drain(&mut self.chip.memory, &self.config.image, at, &mut self.log);
        let panics = self.log[first..].iter().filter(|line| line.text.contains("panicked at")).count();
        self.panicked |= panics > 0;
        self.counters.panics += panics as u64;
    }
}
