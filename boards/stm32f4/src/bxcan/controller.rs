//! The controllers of this chip and their settings.

use cortex_m::peripheral::NVIC;
use embassy_stm32::pac::can::Can;
use embassy_stm32::pac::can::regs::Btr;
use embassy_stm32::{can, pac, peripherals};

use super::events::EventQueue;
use crate::registers::count;
use crate::timing::ControllerTiming;

/// Filter banks of each controller; the second one's begin here (CAN2SB).
pub(super) const BANKS: usize = 14;

/// A bxCAN controller.
pub trait Controller: can::Instance {
    /// Registers of the controller.
    const REGISTERS: Can;
    /// First filter bank of the controller. The banks of both controllers are registers of CAN1.
    const FIRST_BANK: usize;

    /// Queue of events from the interrupts of the controller to its port.
    #[doc(hidden)]
    fn events() -> &'static EventQueue;
}

impl Controller for peripherals::CAN1 {
    const REGISTERS: Can = pac::CAN1;
    const FIRST_BANK: usize = 0;

    fn events() -> &'static EventQueue {
        static EVENTS: EventQueue = EventQueue::new();
        &EVENTS
    }
}

impl Controller for peripherals::CAN2 {
    const REGISTERS: Can = pac::CAN2;
    const FIRST_BANK: usize = BANKS;

    fn events() -> &'static EventQueue {
        static EVENTS: EventQueue = EventQueue::new();
        &EVENTS
    }
}

/// Writes the settings that can be changed in Init mode only. `listens`: the controller drives no dominant bit.
pub(super) fn configure(registers: Can, timing: &ControllerTiming, listens: bool) {
    registers.btr().write_value(Btr(timing.register(listens)));
}

/// Enables the interrupts of the controller with this first bank in the interrupt controller again: 19, 20, 22 of CAN1; 63, 64,
/// 66 of CAN2.
pub(super) fn mend_interrupts(first_bank: usize) {
    let of_words =
        if first_bank == 0 { [1 << 19 | 1 << 20 | 1 << 22, 0, 0] } else { [0, 1 << 31, 1 << 0 | 1 << 2] };
    // SAFETY: the handlers are bound, as for `enable` of the port. Bits that are written as zero change nothing.
    let nvic = unsafe { &*NVIC::PTR };
    for (word, wanted) in nvic.iser.iter().zip(of_words) {
        if word.read() & wanted != wanted {
            count(core::ptr::from_ref(word) as u32);
            // SAFETY: as above.
            unsafe { word.write(wanted) };
        }
    }
}
