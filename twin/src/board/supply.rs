//! Power, the oscillator and the reset pin of a board.

use super::{EmulatedBoard, State};
use crate::cpu::{Config, Core};
use crate::peripherals::ResetCause;

impl EmulatedBoard {
    /// Switches power on or off at the board's present. Flash keeps its content; RAM does not.
    pub fn power(&mut self, on: bool) {
        if on == self.is_powered() {
            return;
        }
        if on {
            self.restore(ResetCause::PowerOn);
        } else {
            self.drain();
            self.interrupt_flash();
            self.state = State::Off;
            let now = self.now();
            self.chip.peripherals.reset(now, ResetCause::PowerOn);
            self.chip.accelerator.reset();
        }
    }

    /// Pulls the reset pin. Has no effect on a board without power.
    pub fn reset(&mut self) {
        if self.is_powered() {
            self.start(ResetCause::Pin);
        }
    }

    /// Makes the supply fall below 2.1 V for a moment, after which the content of RAM is undefined. If the option bytes
    /// select a brown-out level, the reset flags do not include power-on. As delivered, only the power-on reset
    /// monitors the supply. Has no effect on a board without power.
    pub fn brown_out(&mut self) {
        if self.is_powered() {
            let (watched, _) = self.chip.peripherals.flash.watches();
            self.power(false);
            self.restore(if watched { ResetCause::BrownOut } else { ResetCause::PowerOn });
        }
    }

    /// Restores power: flash has kept its content, RAM has not.
    fn restore(&mut self, cause: ResetCause) {
        self.chip.memory.lose_power();
        self.note_fpu();
        let code = self.core.code();
        self.core = Core::new(Config::stm32f4(self.config.model.part.flash_bytes()));
        self.core.share(&code);
        if self.chip.is_tolerant {
            self.tolerate_upsets();
        }
        self.core.advance_to(self.chip.clock.now().cycle);
        self.lines = [0; 3];
        self.nmi = false;
        let started = self.now() + self.config.fittings.hse_delay;
        self.chip.peripherals.rcc.hse_from = started;
        self.start(cause);
    }

    /// Stops the oscillator on OSC_IN at the board's present. It does not start again.
    ///
    /// # Panics
    /// When the program did not start the clock security system: a chip without clock is not modelled.
    pub fn fail_oscillator(&mut self) {
        self.chip.peripherals.rcc.fail_hse();
        self.refresh();
    }

    /// Repairs the oscillator: it starts when the program next switches it on.
    pub fn mend_oscillator(&mut self) {
        self.chip.peripherals.rcc.hse_starts = true;
    }
}
