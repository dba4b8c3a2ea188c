//! The controllers of this chip and their settings.

use ecss_can::link::bit_timing::BitTiming;
use ecss_can::link::port::{ErrorState, Health, LastError};
use embassy_stm32::pac::can::Can;
use embassy_stm32::pac::can::regs::Esr;
use embassy_stm32::pac::can::vals::Lec;
use embassy_stm32::{can, pac, peripherals};

use super::events::EventQueue;
use super::filters::BANKS;

/// A bxCAN controller.
pub trait Controller: can::Instance {
    /// Its registers.
    const REGISTERS: Can;
    /// The first of its filter banks, which are all in the block of CAN1.
    const FIRST_BANK: usize;

    /// From its interrupts to its port.
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

/// From Sleep mode, as after reset, to Init mode, with every setting made.
pub(super) fn configure(registers: Can, timing: BitTiming) {
    // Everything that is not named is off: TTCM, ABOM, AWUM, NART, RFLM, TXFP, SLEEP, DBF.
    registers.mcr().write(|w| w.set_inrq(true));
    while !registers.msr().read().inak() {}
    registers.btr().write(|w| {
        w.set_brp(timing.prescaler() - 1);
        w.set_ts(0, timing.segment1() - 1);
        w.set_ts(1, timing.segment2() - 1);
        w.set_sjw(timing.jump_width() - 1);
    });
    // Not LECIE: on a cut bus it would fire with every attempt.
    registers.ier().write(|w| {
        w.set_tmeie(true);
        w.set_fmpie(0, true);
        w.set_fovie(0, true);
        w.set_ewgie(true);
        w.set_epvie(true);
        w.set_bofie(true);
        w.set_errie(true);
    });
}

/// Error state and counters. Reading them changes nothing.
pub(super) fn health(esr: Esr) -> Health {
    Health {
        state: match (esr.boff(), esr.epvf()) {
            (true, _) => ErrorState::BusOff,
            (false, true) => ErrorState::Passive,
            (false, false) => ErrorState::Active,
        },
        tec: esr.tec(),
        rec: esr.rec(),
        last_error: match esr.lec() {
            Lec::STUFF => LastError::Stuff,
            Lec::FORM => LastError::Form,
            Lec::ACK => LastError::Ack,
            Lec::BIT_RECESSIVE => LastError::BitRecessive,
            Lec::BIT_DOMINANT => LastError::BitDominant,
            Lec::CRC => LastError::Crc,
            // CUSTOM stands there only when software wrote it, which this driver does not.
            Lec::NO_ERROR | Lec::CUSTOM => LastError::None,
        },
    }
}
