//! Drivers of embassy-stm32, one after the other, each with a line in the log about what it found.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

// The board that the image is built for.
#[cfg(all(target_os = "none", feature = "nucleo-f446re"))]
extern crate nucleo_f446re as board;
#[cfg(all(target_os = "none", feature = "pyboard-v11"))]
extern crate pyboard_v11 as board;

#[cfg(target_os = "none")]
mod app;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This is firmware for tests. See it fly:  cargo test --package twin --test peripherals");
}
