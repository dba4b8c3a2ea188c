//! The CAN driver of `embassy-stm32`, `embassy_stm32::can`: two boards talk on one bus.
//!
//! A board whose PA2 is tied to ground answers; the other one asks every millisecond. Both log when the bus fails and when it
//! works again. Recovery from bus-off is the driver's (ABOM).

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
