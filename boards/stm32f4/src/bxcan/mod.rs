//! Driver of ST's bxCAN controllers (RM0090 chapter 32).
//!
//! ```text
//! TX interrupt: results of the mailboxes ──┐
//! RX interrupt: frames of the FIFO ────────┼── EventQueue ── Port::poll_event()
//! SCE interrupt: error flags ──────────────┘
//! ```
//!
//! Frames are retransmitted until they are acknowledged or aborted, the mailbox with the lowest identifier first. Those
//! of one COB-ID keep their order (`mailboxes`, `held`). The node decides about recovery from bus-off, so automatic
//! recovery is off. Time-triggered mode stays off: the errata of this block say that its time stamps are not available.

/// Transmit mailboxes of a controller.
const MAILBOXES: usize = 3;

mod filters;
mod held;
mod mailboxes;
mod mode;
mod results;
mod status;
mod waiting;

#[cfg(target_os = "none")]
mod banks;
#[cfg(target_os = "none")]
mod controller;
#[cfg(target_os = "none")]
mod events;
#[cfg(target_os = "none")]
mod interrupts;
#[cfg(target_os = "none")]
mod lines;
#[cfg(target_os = "none")]
mod port;
#[cfg(target_os = "none")]
mod registers;

#[cfg(target_os = "none")]
pub use {
    controller::Controller,
    interrupts::{ControllerInterrupts, ReceiveHandler, StatusHandler, TransmitHandler},
    lines::CanLines,
    port::Port,
};

#[cfg(all(target_os = "none", feature = "full"))]
pub use port::{CaptureFault, ControllerFault, LineFault};
