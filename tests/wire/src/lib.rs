//! Two-wire CAN buses in virtual time: timing, arbitration, ACK, cuts.
//!
//! A [`Wire`](wire::Wire) joins any number of [`Controller`](controller::Controller)s. It knows nothing of what stands
//! behind a controller: an emulated bxCAN or a std mock.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod controller;
pub mod frame;
pub mod time;
