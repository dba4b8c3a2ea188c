//! Exceptions (B1.5): which one comes next, sleep, and the inputs of the core.

mod entry;
mod exit;
mod fault;

use crate::cpu::core::Core;
use crate::cpu::system::scb::{SCR_SEVONPEND, SCR_SLEEPDEEP};
use crate::cpu::trap::{INTERRUPTS, NMI, Sleep};

/// Execution priority without exceptions and masks: lower than any other (B1.5.4).
const LOWEST: i16 = 256;

impl Core {
    /// Drives the input of interrupt `irq`, 0 to 96. Level-sensitive; a rising edge while the interrupt is active also counts.
    ///
    /// # Panics
    /// `irq` is above 96.
    pub fn set_irq(&mut self, irq: u16, asserted: bool) {
        assert!(irq < crate::cpu::system::nvic::LINES, "interrupt {irq}: this core has 97 lines, 0 to 96");
        self.set_line(INTERRUPTS + irq, asserted);
    }

    /// Drives the input of the NMI; as [`Core::set_irq`].
    pub fn set_nmi(&mut self, asserted: bool) {
        self.set_line(NMI, asserted);
    }

    fn set_line(&mut self, exception: u16, asserted: bool) {
        let rises = asserted && !self.nvic.lines.contains(exception);
        self.nvic.lines.set(exception, asserted);
        if rises {
            self.pend(exception);
        }
    }

    /// Sets the event register, as SEV of another core does (B1.5.18).
    pub fn send_event(&mut self) {
        self.event = true;
    }

    /// Makes an exception pending.
    pub(in crate::cpu) fn pend(&mut self, exception: u16) {
        if self.scb.scr & SCR_SEVONPEND != 0 && !self.nvic.pending.contains(exception) {
            self.event = true;
        }
        self.nvic.pending.set(exception, true);
        self.attention = 0;
    }

    /// Returns whether the core sleeps.
    #[must_use]
    pub fn is_asleep(&self) -> bool {
        self.sleep != Sleep::Awake
    }

    /// Returns whether the next sleep is a deep one (SCR.SLEEPDEEP): Stop or Standby on an STM32.
    #[must_use]
    pub fn sleeps_deeply(&self) -> bool {
        self.scb.scr & SCR_SLEEPDEEP != 0
    }

    /// Returns whether the core is locked up: a fault came up that no handler can take (B1.5.15).
    #[must_use]
    pub fn is_locked_up(&self) -> bool {
        self.locked_up
    }

    /// Returns the cycle at which SysTick pends its exception, `u64::MAX` for never.
    #[must_use]
    pub fn systick_event(&self) -> u64 {
        self.systick.deadline
    }

    /// Lets time pass up to `cycle` in which the core does nothing, asleep or waiting for its memory. SysTick counts; the cycle
    /// counter counts unless the core sleeps.
    pub fn advance_to(&mut self, cycle: u64) {
        let passed = cycle.saturating_sub(self.cycle);
        if self.is_asleep() {
            self.debug.skip(passed);
        }
        self.cycle += passed;
    }

    /// Lets time pass up to `cycle` in which a debugger has halted the core. SysTick and the cycle counter stand still.
    pub fn skip_to(&mut self, cycle: u64) {
        let passed = cycle.saturating_sub(self.cycle);
        self.debug.skip(passed);
        self.systick.skip(passed);
        self.cycle += passed;
        self.attention = 0;
    }

    pub(in crate::cpu) fn fall_asleep(&mut self, sleep: Sleep) {
        self.sleep = sleep;
        self.attention = 0;
    }

    /// Returns whether the core is awake or its wake-up condition holds. Exceptions that it can take are found before.
    pub(in crate::cpu) fn wakes(&mut self) -> bool {
        match self.sleep {
            Sleep::Awake => true,
            Sleep::ForEvent => std::mem::take(&mut self.event),
            // An interrupt that PRIMASK alone holds back ends the sleep.
            Sleep::ForInterrupt => {
                let priority = self.boosted_priority(false);
                self.nvic.first_pending(self.scb.group_mask()).is_some_and(|(_, pending)| pending < priority)
            }
        }
    }

    /// The pending exception that the core takes now.
    pub(in crate::cpu) fn preempting(&self) -> Option<u16> {
        let (exception, priority) = self.nvic.first_pending(self.scb.group_mask())?;
        let current =
            if self.locked_up { self.execution_priority().min(-1) } else { self.execution_priority() };
        (priority < current).then_some(exception)
    }

    /// Priority of the running code: that of active exceptions and of the masks (B1.5.4).
    pub(in crate::cpu) fn execution_priority(&self) -> i16 {
        self.boosted_priority(self.masks.primask)
    }

    fn boosted_priority(&self, primask: bool) -> i16 {
        let mut priority = self.nvic.active_priority(self.scb.group_mask()).unwrap_or(LOWEST);
        if self.masks.basepri != 0 {
            priority = priority.min(i16::from(self.masks.basepri & self.scb.group_mask()));
        }
        if primask {
            priority = priority.min(0);
        }
        if self.masks.faultmask {
            priority = priority.min(-1);
        }
        priority
    }

    /// Priority group of an exception.
    pub(in crate::cpu) fn priority(&self, exception: u16) -> i16 {
        self.nvic.priority(exception, self.scb.group_mask())
    }
}
