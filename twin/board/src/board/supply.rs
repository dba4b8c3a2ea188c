//! Power, the oscillator and the reset pin of a board.

use twin_core::{Config, Core};

use super::{EmulatedBoard, State};
use crate::peripherals::ResetCause;

impl EmulatedBoard {
    /// Power comes up at the board's present, or goes away. Flash keeps its content; RAM does not.
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

    /// Pulls the reset pin. Without effect on a board without power.
    pub fn reset(&mut self) {
        if self.is_powered() {
            self.start(ResetCause::Pin);
        }
    }

    /// The supply falls below 2.1 V for a moment: RAM holds anything. Where the option bytes choose a level of the brown-out reset
    /// the reset flags do not name power-on; as delivered only the power-on reset watches the supply. Without effect on a board
    /// without power.
    pub fn brown_out(&mut self) {
        if self.is_powered() {
            let (watched, _) = self.chip.peripherals.flash.watches();
            self.power(false);
            self.restore(if watched { ResetCause::BrownOut } else { ResetCause::PowerOn });
        }
    }

    /// Power comes back to flash with its content and RAM without.
    fn restore(&mut self, cause: ResetCause) {
        self.chip.memory.lose_power();
        let code = self.core.code();
        self.core = Core::new(Config::stm32f4(self.config.model.part.flash_bytes()));
        self.core.share(&code);
        self.core.advance_to(self.chip.clock.now().cycle);
        self.lines = [0; 3];
        self.nmi = false;
        let started = self.now() + self.config.fittings.hse_delay;
        self.chip.peripherals.rcc.hse_from = started;
        self.start(cause);
    }

    /// The oscillator on OSC_IN stops at the board's present, and does not start again.
    ///
    /// # Panics
    /// When the program did not start the clock security system: a chip without clock is not modelled.
    pub fn fail_oscillator(&mut self) {
        self.chip.peripherals.rcc.fail_hse();
        self.refresh();
    }

    /// The oscillator works again: it starts when the program next switches it on.
    pub fn mend_oscillator(&mut self) {
        self.chip.peripherals.rcc.hse_starts = true;
    }
}
