//! Firmware of a minimal slave (ECSS 9).
//!
//! On a board `app` starts everything; on a computer `host` runs the application in a mock spacecraft.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

// The board that the image is built for.
#[cfg(all(target_os = "none", feature = "nucleo-f446re"))]
extern crate nucleo_f446re as board;
#[cfg(all(target_os = "none", feature = "pyboard-v11"))]
extern crate pyboard_v11 as board;
#[cfg(all(target_os = "none", feature = "stm32f4discovery"))]
extern crate stm32f4discovery as board;

#[cfg(target_os = "none")]
mod app;

#[cfg(not(target_os = "none"))]
mod host;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    host::run()
}
