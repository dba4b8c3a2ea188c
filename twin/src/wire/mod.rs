//! CAN buses in virtual time: every bit of every node, and faults.
//!
//! A [`Wire`](bus::Wire) joins any number of [`Controller`](controller::Controller)s. A controller may be an emulated
//! bxCAN or a mock. The wire implements bit timing, arbitration, acknowledgement, error frames and fault confinement
//! (ISO 11898-1). Faults are values ([`fault::Fault`]).

mod arrivals;
mod bits;
pub mod bus;
mod calendar;
pub mod candump;
mod confinement;
pub mod controller;
mod decode;
pub mod encode;
mod errors;
pub mod fault;
pub mod field;
mod fine;
mod flight;
pub mod frame;
mod mac;
mod node;
pub mod pcapng;
pub mod record;
mod segment;
mod stage;
pub mod station;
pub mod time;
pub mod timing;
pub mod transceiver;
pub mod waveform;
