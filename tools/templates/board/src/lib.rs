//! Olimex STM32-H405: STM32F405RG with an 8 MHz crystal.

#![no_std]
#![cfg(target_os = "none")]
#![forbid(unsafe_code)]

use ecss_can_stm32f4::{Oscillator, board};

board! {
    $crate,
    oscillator: Oscillator::crystal(8_000_000),
    nominal_rx: PB8,
    nominal_tx: PB9,
    redundant_rx: PB12,
    redundant_tx: PB13,
    nominal_edges: PA2,
    nominal_stream: DMA1_CH0,
    redundant_edges: PA3,
    redundant_stream: DMA1_CH1,
    pulse: PB1,
    strap_0: PC0,
    strap_1: PC1,
    strap_2: PC2,
    strap_3: PC3,
    strap_parity: PC5,
    strap_maintenance: PC6,
    led_sync: PC7,
    led_state: PC8,
    led_heartbeat: PB14,
    led_time: PB15,
}
