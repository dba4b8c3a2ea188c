//! The CAN driver of `embassy-stm32`, `embassy_stm32::can`: two boards communicate on one bus.
//!
//! A board whose PA2 is tied to ground answers; the other one sends a request every millisecond. Both log when the bus
//! fails and when it works again. The controller recovers from bus-off automatically (ABOM).

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(target_os = "none")]
mod app;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This is firmware for tests of the twin. See it fly:  cargo test -p second --test flights drivers_of_others"
    );
}
