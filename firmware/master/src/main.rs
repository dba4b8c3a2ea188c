//! Firmware of the master.
//!
//! On a board `app` starts everything; on the host it prints a hint.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(target_os = "none")]
mod app;
#[cfg(target_os = "none")]
mod application;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This is firmware. Flash a board:  cargo master");
    println!("or a NUCLEO-F446RE:               cargo master --board nucleo-f446re");
    println!("Or see it fly without a board:   cargo demo");
}
