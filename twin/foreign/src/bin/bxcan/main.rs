//! The crate `bxcan` on `stm32f4xx-hal`: scenarios that it passes on silicon, for the twin to pass.
//!
//! They reimplement the hardware test suite of `bxcan`: loopback, filters of all four forms, priority, abort, FIFOs,
//! interrupts, sleep. Both controllers are on one bus.

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
