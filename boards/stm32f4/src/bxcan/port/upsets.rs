//! Registers of a port that are compared with what they have to be, and mended.
//!
//! The runner sets a filter again ten times a second. With each of them the port compares one part of its registers. So all are
//! compared within half a second, by short steps (row `rx.inside_look`). The values are derived from the state of the port. A state
//! that contradicts itself has a flipped bit, and is taken from the registers.

use ecss_can::runner::Clock;
use embassy_stm32::pac::can::Can;
use embassy_stm32::peripherals::{CAN1, CAN2};

use super::Port;
use crate::Uptime;
#[cfg(feature = "full")]
use crate::alternate::Direction;
use crate::bxcan::controller::{self, Controller};
use crate::bxcan::events::EventQueue;
use crate::bxcan::{banks, registers};
use crate::registers::count;
use crate::stamping::FrameStamps;
use crate::timing::ControllerTiming;

/// Parts that are compared in turn.
const PARTS: u8 = 4;

impl<S: FrameStamps> Port<S> {
    /// Compares the next part and mends it.
    pub(super) fn mend_next(&mut self) {
        self.compared = (self.compared + 1) % PARTS;
        match self.compared {
            0 => self.mend_controller(),
            1 => banks::mend(self.first_bank, self.filters),
            2 => self.mend_pins(),
            _ => self.stamps.mend(),
        }
    }

    /// Connects the pins again, unless a bit of what is known of them flipped. A full node does so if their settings differ.
    fn mend_pins(&mut self) {
        if self.pins != self.pin_check() {
            return;
        }
        #[cfg(feature = "full")]
        {
            self.rx.mend(Direction::Input);
            self.tx.mend(Direction::Output);
        }
        #[cfg(not(feature = "full"))]
        self.connect();
    }

    /// Ends the program by a fault if the registers are those of no controller, or the banks or events those of the other one: a bit
    /// of an address flipped. Frames in mailboxes would wait for ever.
    fn check_parts(&self) {
        let parts = (self.registers, self.first_bank, core::ptr::from_ref(self.events));
        if parts != self::parts::<CAN1>() && parts != self::parts::<CAN2>() {
            cortex_m::asm::udf();
        }
    }

    /// Enables the interrupts again. For mode and bit timing the controller leaves its bus and joins again.
    fn mend_controller(&mut self) {
        self.check_parts();
        let controller = self.registers;
        if self.events.mend_sources(controller) {
            count(controller.ier().as_ptr() as u32);
        }
        controller::mend_interrupts(self.first_bank);
        let Some(address) = self.lost_setting(controller) else { return };
        count(address);
        if let Some(request) = self.mode.lose(Uptime.now()) {
            self.obey(request);
        }
        self.is_quiet = false;
        self.advance();
    }

    /// Returns the address of MCR or BTR if it is not as the port has written it.
    fn lost_setting(&mut self, controller: Can) -> Option<u32> {
        let (mode, timing) = (controller.mcr().read(), controller.btr().read().0);
        if self.is_quiet {
            self.mode.restore(!mode.inrq(), ControllerTiming::listens(timing));
        }
        if mode != registers::mode(self.mode.is_init()) {
            return Some(controller.mcr().as_ptr() as u32);
        }
        let listens = self.mode.configured()?;
        self.timing.restore(timing);
        let is_lost = timing != self.timing.register(listens);
        is_lost.then(|| controller.btr().as_ptr() as u32)
    }
}

fn parts<T: Controller>() -> (Can, usize, *const EventQueue) {
    (T::REGISTERS, T::FIRST_BANK, T::events())
}
