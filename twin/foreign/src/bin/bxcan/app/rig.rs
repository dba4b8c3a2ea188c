//! Both controllers, and operations that every scenario uses.

use bxcan::filter::Mask32;
use bxcan::{Fifo, Frame, Interrupts, Mailbox, StandardId};
use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::can::Can;
use stm32f4xx_hal::pac::{self, CAN1, CAN2, Interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;

/// Result of a scenario; the error is the condition that failed.
pub type Outcome = Result<(), &'static str>;

/// Fails a scenario with its condition as the reason.
#[macro_export]
macro_rules! check {
    ($condition:expr) => {
        if !$condition {
            return Err(concat!(stringify!($condition), ", line ", line!()));
        }
    };
}

/// 5.25 Mbit/s from 42 MHz: for loopback.
const FAST: u32 = 0x0123_0000;
/// 1709 bit/s, the slowest rate: mailboxes stay full for milliseconds.
const SLOW: u32 = 0x007F_03FF;
/// 1 Mbit/s, sample point at 78.6 %.
pub const MEGABIT: u32 = 0x0029_0002;
/// Reads of a condition before it fails: at least 10 ms at 168 MHz.
const PATIENCE: u32 = 200_000;

/// Both controllers.
pub struct Rig {
    pub can1: bxcan::Can<Can<CAN1>>,
    pub can2: bxcan::Can<Can<CAN2>>,
}

impl Rig {
    /// Clocks of the board, both controllers on pins, both asleep.
    pub fn new(p: pac::Peripherals) -> Rig {
        let mut rcc = p.RCC.freeze(config().sysclk(168.MHz()).pclk1(42.MHz()).pclk2(84.MHz()));
        let a = p.GPIOA.split(&mut rcc);
        let b = p.GPIOB.split(&mut rcc);
        let can1 = p.CAN1.can((a.pa12, a.pa11), &mut rcc);
        let can2 = p.CAN2.can((b.pb6, b.pb5), &mut rcc);
        Rig {
            can1: bxcan::Can::builder(can1).leave_disabled(),
            can2: bxcan::Can::builder(can2).leave_disabled(),
        }
    }

    /// Sets CAN1 to silent loopback at high speed and empties it; CAN2 is off the bus.
    pub fn self_test(&mut self) {
        self.go(FAST);
        self.can2.sleep();
    }

    /// As [`Rig::self_test`], at the slowest rate.
    pub fn slow_self_test(&mut self) {
        self.go(SLOW);
    }

    fn go(&mut self, btr: u32) {
        self.can1.modify_config().set_loopback(true).set_silent(true).set_bit_timing(btr).enable();
        self.empty();
    }

    /// Joins both controllers to the bus. Every frame goes into FIFO 0 of either.
    pub fn both_on_the_bus(&mut self) {
        self.can1.modify_config().set_loopback(false).set_silent(false).set_bit_timing(MEGABIT).enable();
        self.can2.modify_config().set_loopback(false).set_silent(false).set_bit_timing(MEGABIT).enable();
        let mut filters = self.can1.modify_filters();
        filters.set_split(14).clear().enable_bank(0, Fifo::Fifo0, Mask32::accept_all());
        filters.slave_filters().clear().enable_bank(14, Fifo::Fifo0, Mask32::accept_all());
        drop(filters);
        self.empty();
    }

    /// Makes CAN1 admit every frame into FIFO 0.
    pub fn admit_all(&mut self) {
        self.can1.modify_filters().clear().enable_bank(0, Fifo::Fifo0, Mask32::accept_all());
    }

    /// Discards waiting and received frames, and interrupts.
    pub fn empty(&mut self) {
        for mailbox in [Mailbox::Mailbox0, Mailbox::Mailbox1, Mailbox::Mailbox2] {
            self.can1.abort(mailbox);
            self.can2.abort(mailbox);
        }
        while !matches!(self.can1.receive(), Err(nb::Error::WouldBlock)) {}
        while !matches!(self.can2.receive(), Err(nb::Error::WouldBlock)) {}
        self.can1.disable_interrupts(Interrupts::all());
        self.can1.clear_tx_interrupt();
        self.can2.clear_tx_interrupt();
        for interrupt in [Interrupt::CAN1_TX, Interrupt::CAN1_RX0, Interrupt::CAN1_RX1, Interrupt::CAN1_SCE] {
            NVIC::unpend(interrupt);
        }
    }

    /// Sends `frame` from CAN1. Returns when it has been sent.
    pub fn send(&mut self, frame: &Frame) -> Outcome {
        check!(nb::block!(self.can1.transmit(frame)).is_ok());
        check!(!self.can1.is_transmitter_idle());
        check!(eventually(|| self.can1.is_transmitter_idle()));
        Ok(())
    }

    /// Sends `frame` from CAN1 to itself. Returns whether its filters admit it. Checks that the received frame is the
    /// same.
    pub fn admits(&mut self, frame: &Frame) -> Result<bool, &'static str> {
        self.send(frame)?;
        match self.can1.receive() {
            Ok(received) if received == *frame => Ok(true),
            Ok(_) => Err("another frame came back"),
            Err(nb::Error::WouldBlock) => Ok(false),
            Err(nb::Error::Other(_)) => Err("an overrun"),
        }
    }
}

#[cfg(feature = "pyboard-v11-bxcan")]
fn config() -> Config {
    Config::hse(12.MHz())
}

#[cfg(not(feature = "pyboard-v11-bxcan"))]
fn config() -> Config {
    Config::hse(8.MHz()).bypass_hse_oscillator()
}

/// Waits for a condition. Returns whether it became true.
pub fn eventually(mut condition: impl FnMut() -> bool) -> bool {
    (0..PATIENCE).any(|_| condition())
}

/// A standard identifier.
pub fn standard(id: u16) -> StandardId {
    StandardId::new(id).unwrap()
}
