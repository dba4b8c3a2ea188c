//! Power, the oscillator and the reset pin of a board.

use super::{EmulatedBoard, State};
use crate::cpu::CortexM4;
use crate::model::FLASH_BASE;
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
            self.link.peripherals().reset(self.clock.now().time, ResetCause::PowerOn);
            self.link.accelerator().reset();
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
            let (watched, _) = self.link.peripherals().flash().watches();
            self.power(false);
            self.restore(if watched { ResetCause::BrownOut } else { ResetCause::PowerOn });
        }
    }

    /// Power comes back to flash with its content and RAM without.
    fn restore(&mut self, cause: ResetCause) {
        let part = self.config.model.part;
        let mut flash = vec![0; part.flash_bytes() as usize];
        self.cpu.read_memory(FLASH_BASE, &mut flash).expect("the whole flash");
        self.cpu = CortexM4::new(part, &flash, self.link.clone());
        self.link.peripherals().delay_hse(self.clock.now().time + self.config.fittings.hse_delay);
        self.start(cause);
    }

    /// The oscillator on OSC_IN stops at the board's present, and does not start again.
    ///
    /// # Panics
    /// When the program did not start the clock security system: a chip without clock is not modelled.
    pub fn fail_oscillator(&mut self) {
        self.link.peripherals().fail_hse();
        self.refresh();
    }

    /// The oscillator works again: it starts when the program next switches it on.
    pub fn mend_oscillator(&mut self) {
        self.link.peripherals().set_hse(true);
    }
}
