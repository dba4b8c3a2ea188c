//! Firmware of the thermometer's master.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(target_os = "none")]
mod app;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This is firmware: cargo xtask firmware --package thermometer-master");
}
