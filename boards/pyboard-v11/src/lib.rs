//! pyboard v1.1: STM32F405RG with a 12 MHz crystal.
//!
//! | what | pins | header |
//! | --- | --- | --- |
//! | nominal bus, CAN1 RX and TX | PB8, PB9 | Y3, Y4 |
//! | redundant bus, CAN2 RX and TX | PB12, PB13 | Y5, Y6 |
//! | with one controller, CAN1: bus, redundant when high | PB13 | Y6 |
//! | capture of CAN_RX, nominal and redundant, by wires from Y3 and Y5 | PA0, PA1 | X1, X2 |
//! | pulse at an instant | PB1 | Y12 |
//! | straps: bits 0 to 3, odd parity | PA2, PA3, PA4, PA5, PA6 | X3, X4, X5, X6, X7 |
//! | strap: maintenance mode | PA7 | X8 |
//! | LEDs: SYNC (blue), state (yellow) | PB4, PA15 | on board |
//! | LEDs: heartbeat, spacecraft time (external) | PB14, PB15 | Y7, Y8 |
//!
//! The red and green LEDs hang on the debug pins PA13 and PA14 and are never touched. Straps are closed to ground (X14, Y14); inside they have pull-ups.
//!
//! Related crates: [`ecss-can-stm32f4`](https://docs.rs/ecss-can-stm32f4),
//! [`ecss-can-runtime`](https://docs.rs/ecss-can-runtime), [`ecss-can-memory`](https://docs.rs/ecss-can-memory).

#![no_std]
#![cfg(target_os = "none")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

use ecss_can_stm32f4::{Oscillator, board};

board! {
    $crate,
    oscillator: Oscillator::crystal(12_000_000),
    nominal_rx: PB8,
    nominal_tx: PB9,
    redundant_rx: PB12,
    redundant_tx: PB13,
    nominal_edges: PA0,
    nominal_stream: DMA1_CH2,
    redundant_edges: PA1,
    redundant_stream: DMA1_CH4,
    pulse: PB1,
    strap_0: PA2,
    strap_1: PA3,
    strap_2: PA4,
    strap_3: PA5,
    strap_parity: PA6,
    strap_maintenance: PA7,
    led_sync: PB4,
    led_state: PA15,
    led_heartbeat: PB14,
    led_time: PB15,
}
