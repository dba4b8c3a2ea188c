//! Runtime of an image: items that an image needs besides its application and may define only once. Each feature
//! enables one of them; all are on by default.
//!
//! | feature | what the image gets |
//! | --- | --- |
//! | `interrupts` | `Irqs`, the interrupts of both CAN controllers |
//! | `time` | the clock of embassy-time on TIM2 |
//! | `critical-section` | a critical section that disables all interrupts |
//! | `log` | the log of defmt in a ring in RAM that a debug probe reads |
//! | `panics` | a panic ends in a fault |
//! | `messages` | a panic logs its message first |
//! | `exceptions` | handlers of faults, NMI and SysTick, which end or supervise the program |
//! | `memory` | routines of the compiler, smaller or faster: copies of memory, divisions of 64-bit numbers |
//! | `mend` | a check of the program in flash at each reset, which mends a flipped bit |
//! | `program` | `mend`, and the same check in the background, as a task beside those of the node |
//!
//! An image links this crate by using `Irqs`, or by `use ecss_can_runtime as _`. [`node_tasks`] declares a function that
//! spawns the tasks of a node, [`pulse_task`] one for the pulse output.
//!
//! On the host the crate contains only these macros.
//!
//! Related crates: [`ecss-can-stm32f4`](https://docs.rs/ecss-can-stm32f4),
//! [`ecss-can-memory`](https://docs.rs/ecss-can-memory), [`ecss-can-cli`](https://docs.rs/ecss-can-cli).

#![cfg_attr(target_os = "none", no_std)]
#![deny(unsafe_op_in_unsafe_fn)]
#![deny(clippy::undocumented_unsafe_blocks)]
#![warn(missing_docs)]

#[cfg(all(target_os = "none", feature = "memory"))]
mod division;
#[cfg(all(target_os = "none", feature = "exceptions"))]
mod exceptions;
#[cfg(all(target_os = "none", feature = "interrupts"))]
mod interrupts;
#[cfg(all(target_os = "none", feature = "log"))]
mod log;
#[cfg(all(target_os = "none", feature = "memory"))]
mod memory;
#[cfg(all(target_os = "none", feature = "mend"))]
mod mend;
#[cfg(all(target_os = "none", feature = "panics"))]
use panic_probe as _;
#[cfg(target_os = "none")]
mod program;
mod tasks;

#[cfg(all(target_os = "none", feature = "interrupts"))]
pub use interrupts::Irqs;

#[cfg(target_os = "none")]
#[doc(hidden)]
pub use {ecss_can_stm32f4::supervised, program::spawn_check};
