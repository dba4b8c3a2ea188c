//! The controllers of this chip and their settings.

use ecss_can::link::bit_timing::BitTiming;
use embassy_stm32::pac::can::Can;
use embassy_stm32::pac::can::regs::Btr;
use embassy_stm32::pac::can::vals::Silm;
use embassy_stm32::{can, pac, peripherals};

use super::events::EventQueue;

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
pub(super) fn configure(registers: Can, timing: BitTiming, listens: bool) {
    registers.btr().write_value(settings(timing, listens));
}

/// Returns the settings that can be changed in Init mode only.
pub(super) fn settings(timing: BitTiming, listens: bool) -> Btr {
    let mut settings = Btr(0);
    settings.set_brp(timing.prescaler() - 1);
    settings.set_ts(0, timing.segment1() - 1);
    settings.set_ts(1, timing.segment2() - 1);
    settings.set_sjw(timing.jump_width() - 1);
    settings.set_silm(if listens { Silm::SILENT } else { Silm::NORMAL });
    settings
}
