//! Runtime of an image: what an image needs beside its application, and may have only once.
//!
//! An image links it by its use of `Irqs`. It defines:
//!
//! - handlers of panics, faults, NMI and SysTick, which end or supervise the program by `boards`;
//! - the log, a ring in RAM that a debug probe reads;
//! - the interrupts of both CAN controllers;
//! - routines of the compiler, smaller or faster: copies of memory, divisions of 64-bit numbers.
//!
//! [`node_tasks`] declares the tasks of a node.
//!
//! On the host it has that macro alone.

#![cfg_attr(target_os = "none", no_std)]
#![deny(unsafe_op_in_unsafe_fn)]
#![deny(clippy::undocumented_unsafe_blocks)]
#![warn(missing_docs)]

#[cfg(target_os = "none")]
mod division;
#[cfg(target_os = "none")]
mod exceptions;
#[cfg(target_os = "none")]
mod image;
#[cfg(target_os = "none")]
mod memory;
mod tasks;

#[cfg(target_os = "none")]
pub use image::Irqs;
