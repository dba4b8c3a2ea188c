//! STM32F4DISCOVERY (MB997): STM32F407VG with an 8 MHz crystal.
//!
//! | what | pins | header |
//! | --- | --- | --- |
//! | nominal bus, CAN1 RX and TX | PD0, PD1 | P2 36, 33 |
//! | redundant bus, CAN2 RX and TX | PB12, PB13 | P1 36, 37 |
//! | with one controller, CAN1: bus, redundant when high | PB13 | P1 37 |
//! | capture of CAN_RX, nominal and redundant, by wires from P2 36 and P1 36 | PA2, PA3 | P1 14, 13 |
//! | pulse at an instant | PB1 | P1 21 |
//! | straps: bits 0 to 3, odd parity | PE7, PE8, PE9, PE10, PE11 | P1 25, 26, 27, 28, 29 |
//! | strap: maintenance mode | PE12 | P1 30 |
//! | LEDs: SYNC (LD4, green), state (LD3, orange) | PD12, PD13 | on board |
//! | LEDs: heartbeat (LD5, red), spacecraft time (LD6, blue) | PD14, PD15 | on board |
//!
//! PA0 is the user button, and PB6 and PB9 are the bus of the audio codec, so that the capture inputs and CAN1 are elsewhere than on
//! the other boards. PA13 and PA14 are the debug port of the ST-LINK and are never touched. Straps are closed to ground (P1 23);
//! inside they have pull-ups.
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
    oscillator: Oscillator::crystal(8_000_000),
    nominal_rx: PD0,
    nominal_tx: PD1,
    redundant_rx: PB12,
    redundant_tx: PB13,
    nominal_edges: PA2,
    nominal_stream: DMA1_CH0,
    redundant_edges: PA3,
    redundant_stream: DMA1_CH1,
    pulse: PB1,
    strap_0: PE7,
    strap_1: PE8,
    strap_2: PE9,
    strap_3: PE10,
    strap_parity: PE11,
    strap_maintenance: PE12,
    led_sync: PD12,
    led_state: PD13,
    led_heartbeat: PD14,
    led_time: PD15,
}
