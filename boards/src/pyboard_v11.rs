//! pyboard v1.1: STM32F405RG with a 12 MHz crystal.
//!
//! | what | pins | header |
//! | --- | --- | --- |
//! | nominal bus, CAN1 RX and TX | PB8, PB9 | Y3, Y4 |
//! | redundant bus, CAN2 RX and TX | PB12, PB13 | Y5, Y6 |
//! | capture of CAN_RX, nominal and redundant, by wires from Y3 and Y5 | PA0, PA1 | X1, X2 |
//! | straps: bits 0 to 3, odd parity | PA2, PA3, PA4, PA5, PA6 | X3, X4, X5, X6, X7 |
//! | LEDs: activity (blue), state (yellow) | PB4, PA15 | on board |
//!
//! The red and green LEDs hang on the debug pins PA13 and PA14 and are never touched. Straps are closed to ground (X14, Y14); inside they have pull-ups.

use ecss_can::link::bit_timing::BitTiming;
use ecss_can::types::PerBus;
use embassy_stm32::gpio::{Input, Pull};
use embassy_stm32::rcc::{Hse, HseMode, PllPreDiv};
use embassy_stm32::time::Hertz;

use crate::board::{Board, Irqs, Leds, node_id, store};
use crate::bxcan::Port;
use crate::{Uptime, capture, clock_tree, retained, spare};

/// A crystal.
const OSCILLATOR: Hse = Hse { freq: Hertz(12_000_000), mode: HseMode::Oscillator };

impl Board {
    /// Starts clocks, puts both controllers into Init mode (silent: not even an acknowledgement) and reads the straps.
    ///
    /// Without its oscillator the board never returns from here: it logs the failure, its LEDs take turns, and both
    /// controllers stay in reset.
    ///
    /// # Panics
    /// When called twice.
    #[inline(never)] // a stack of its own is a small one, reached by short instructions
    pub fn init(timing: BitTiming) -> Board {
        let p = match clock_tree::start(OSCILLATOR, PllPreDiv::DIV6) {
            Ok(p) => p,
            Err(p) => clock_tree::without_oscillator(Leds::new(p.PB4, p.PA15)),
        };
        let node_id = node_id([
            Input::new(p.PA2, Pull::Up),
            Input::new(p.PA3, Pull::Up),
            Input::new(p.PA4, Pull::Up),
            Input::new(p.PA5, Pull::Up),
            Input::new(p.PA6, Pull::Up),
        ]);
        let edges = capture::start(p.TIM5, p.PA0, p.PA1, p.DMA1_CH2, p.DMA1_CH4);
        // CAN1 first: it holds the filter banks and the clock of both.
        let nominal = Port::new(p.CAN1, p.PB8, p.PB9, Irqs, timing, edges.nominal);
        let redundant = Port::new(p.CAN2, p.PB12, p.PB13, Irqs, timing, edges.redundant);
        Board {
            ports: PerBus { nominal, redundant },
            clock: Uptime,
            leds: Leds::new(p.PB4, p.PA15),
            node_id,
            store: store(p.FLASH),
            retained: retained::take(),
            memory: spare::take(),
        }
    }
}
