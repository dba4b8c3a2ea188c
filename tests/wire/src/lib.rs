//! Two-wire CAN buses in virtual time: timing, arbitration, ACK, cuts.
//!
//! A [`Wire`](wire::Wire) joins any number of [`Controller`](controller::Controller)s. It knows nothing of what stands
//! behind a controller: an emulated bxCAN or a std mock.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod arbitration;
pub mod candump;
pub mod controller;
pub mod encode;
pub mod fault;
pub mod frame;
pub mod pcapng;
pub mod record;
mod segment;
pub mod time;
pub mod wire;
