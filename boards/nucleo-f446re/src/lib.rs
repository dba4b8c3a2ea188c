//! NUCLEO-F446RE: STM32F446RE with 8 MHz from its ST-LINK.
//!
//! | what | pins | connector |
//! | --- | --- | --- |
//! | nominal bus, CAN1 RX and TX | PB8, PB9 | CN10 3, 5 |
//! | redundant bus, CAN2 RX and TX | PB12, PB13 | CN10 16, 30 |
//! | with one controller, CAN1: bus, redundant when high | PB13 | CN10 30 |
//! | capture of CAN_RX, nominal and redundant, by wires from CN10 3 and 16 | PA0, PA1 | CN7 28, 30 |
//! | pulse at an instant | PB1 | CN10 24 |
//! | straps: bits 0 to 3, odd parity | PC0, PC1, PC2, PC3, PB0 | CN7 38, 36, 35, 37, 34 |
//! | strap: maintenance mode | PA4 | CN7 32 |
//! | LEDs: SYNC (LD2, green), state (external) | PA5, PA6 | on board, CN10 13 |
//! | LEDs: heartbeat, spacecraft time (external) | PB14, PB15 | CN10 28, 26 |
//!
//! PA2 and PA3 are the serial port of the ST-LINK, PA13 and PA14 its debug port; they are never touched. Straps are closed to ground (CN7 22); inside they have pull-ups.
//!
//! Related crates: [`ecss-can-stm32f4`](https://docs.rs/ecss-can-stm32f4),
//! [`ecss-can-runtime`](https://docs.rs/ecss-can-runtime), [`ecss-can-memory`](https://docs.rs/ecss-can-memory).

#![no_std]
#![cfg(target_os = "none")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

use ecss_can_stm32f4::{Oscillator, board};

// The oscillator: the MCO of the ST-LINK, a square wave.
board! {
    $crate,
    oscillator: Oscillator::external(8_000_000),
    nominal_rx: PB8,
    nominal_tx: PB9,
    redundant_rx: PB12,
    redundant_tx: PB13,
    nominal_edges: PA0,
    nominal_stream: DMA1_CH2,
    redundant_edges: PA1,
    redundant_stream: DMA1_CH4,
    pulse: PB1,
    strap_0: PC0,
    strap_1: PC1,
    strap_2: PC2,
    strap_3: PC3,
    strap_parity: PB0,
    strap_maintenance: PA4,
    led_sync: PA5,
    led_state: PA6,
    led_heartbeat: PB14,
    led_time: PB15,
}
