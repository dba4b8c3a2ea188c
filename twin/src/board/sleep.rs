//! Peripherals that RCC stops while the core sleeps (LPENR, RM0090 7.3.14).

use super::EmulatedBoard;

impl EmulatedBoard {
    /// Stops or starts the clocks of these peripherals after the core fell asleep or woke up.
    pub(super) fn follow_sleep(&mut self) {
        if self.chip.peripherals.has_sleepers() {
            self.change_sleep();
        }
    }

    #[cold]
    fn change_sleep(&mut self) {
        let cycle = self.chip.clock.now().cycle;
        if self.chip.peripherals.sleep(cycle, self.asleep) {
            self.refresh();
            if !self.asleep && self.chip.peripherals.sleep(cycle, false) {
                self.refresh();
            }
        }
    }
}
